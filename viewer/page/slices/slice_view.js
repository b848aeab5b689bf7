// One slice: its picture in the right proportions, the cross-hair, and its pointer and keyboard input.

import { clamp, element, newestOnly } from "../controls/panel_kit.js";
import { grabAt, moveGrabbed } from "../measure/grab.js";
import { holdFigures } from "../measure/shown.js";
import { createSliceMarks } from "../measure/slice_marks.js";
import { tool } from "../measure/tool.js";
import { store } from "../state/store.js";

// Axes across and down each slice as the server renders it; `up`: the lowest sample is at the bottom.
const PLANES = {
  x: { axis: 0, across: 1, down: 2, up: true },
  y: { axis: 1, across: 0, down: 2, up: true },
  z: { axis: 2, across: 0, down: 1, up: false },
};

const CLICK_SLACK = 4; // largest movement of a click, in pixels
const REACH = { mouse: 9, touch: 20, pen: 12 }; // pixels between a pointer and the handle that it grabs

/**
 * `fetchSlice(id, axis, index, window, time, overlays)` gives a blob. Callbacks: moved(sample, live), hovered(sample or null),
 * windowed(dx, dy, phase) with phase "start", "move", "end", failed(error); windowing() says whether the plain
 * button sets the window. With a measuring tool, the plain button places its points.
 */
export function createSlice(name, { fetchSlice, moved, hovered, windowed, windowing, failed }) {
  const plane = PLANES[name];
  const canvas = element("canvas", { class: "slice-picture", width: 1, height: 1 });
  const lineAcross = element("span", { class: "slice-line across" });
  const lineDown = element("span", { class: "slice-line down" });
  const letters = ["left", "right", "top", "bottom"].map((side) => element("span", { class: `slice-letter ${side}` }));
  const marks = createSliceMarks(plane);
  const frame = element("div", { class: "slice-frame" }, canvas, lineAcross, lineDown, marks.node, ...letters);
  const title = element("span", { class: "slice-title" });
  const place = element("span", { class: "slice-place" });
  const slider = element("input", { type: "range", min: 0, step: 1 });
  const area = element("div", { class: "slice-area", tabindex: 0, role: "group" }, frame);
  const node = element(
    "figure",
    { class: `slice slice-${name}` },
    element("figcaption", { class: "slice-caption" }, title, place),
    area,
    slider,
  );

  let volume = null;
  let sample = [0, 0, 0];
  let drawn = "";
  let drag = null;
  let turned = [false, plane.up]; // the lowest sample is on the right; at the bottom

  // ---- the picture ------------------------------------------------------------------------------------

  const fetchNewest = newestOnly(async (key, id, index, window, time, overlays) => {
    try {
      const picture = await createImageBitmap(await fetchSlice(id, name, index, window, time, overlays));
      if (canvas.width !== picture.width || canvas.height !== picture.height)
        [canvas.width, canvas.height] = [picture.width, picture.height];
      canvas.getContext("2d").drawImage(picture, 0, 0);
      picture.close();
      node.dataset.shown = key;
      failed(null);
    } catch (error) {
      if (drawn === key) drawn = "";
      failed(error);
    }
  });

  function fitFrame() {
    if (!volume || !area.clientWidth) return;
    const wide = volume.dims[plane.across] * volume.spacing[plane.across];
    const high = volume.dims[plane.down] * volume.spacing[plane.down];
    const scale = Math.min(area.clientWidth / wide, area.clientHeight / high);
    frame.style.width = `${wide * scale}px`;
    frame.style.height = `${high * scale}px`;
    const enlarged = (wide * scale * devicePixelRatio) / volume.dims[plane.across];
    canvas.classList.toggle("sharp", enlarged > 6);
  }

  const part = (axis, flip) => {
    const at = (sample[axis] + 0.5) / volume.dims[axis];
    return `${100 * (flip ? 1 - at : at)}%`;
  };

  // Radiological convention: the patient's right on the left, front or head at the top.
  function turn(pairs) {
    const low = (axis) => pairs?.[axis][0];
    turned = [low(plane.across) === "L", pairs ? "AS".includes(pairs[plane.down][1]) : plane.up];
    canvas.style.transform = `scale(${turned[0] ? -1 : 1}, ${turned[1] === plane.up ? 1 : -1})`;
  }

  function show(nextVolume, time, nextSample, window, overlays, pairs, word) {
    if (nextVolume !== volume) {
      volume = nextVolume;
      slider.max = volume.dims[plane.axis] - 1;
      fitFrame();
    }
    sample = nextSample;
    turn(pairs);
    const index = clamp(Math.round(sample[plane.axis]), 0, volume.dims[plane.axis] - 1);
    const count = volume.dims[plane.axis];
    title.textContent = word;
    place.textContent = `${name} ${index} of ${count - 1}`;
    slider.value = index;
    slider.setAttribute("aria-label", `${word} slice, ${name}`);
    area.setAttribute(
      "aria-label",
      `${word} slice, ${name} ${index} of ${count - 1}: arrows move the cross-hair, Page Up and Page Down the slice`,
    );
    lineDown.style.left = part(plane.across, turned[0]);
    lineAcross.style.top = part(plane.down, turned[1]);
    [plane.across, plane.down].forEach((axis, side) => {
      const ends = pairs ? pairs[axis] : ["", ""];
      (turned[side] ? [...ends].reverse() : ends).forEach((text, k) => (letters[2 * side + k].textContent = text));
    });
    const key = `${volume.id} ${time} ${index} ${volume.arrived_part ?? 0} ${window} ${overlays ? JSON.stringify(overlays) : ""}`;
    if (!area.clientWidth || key === drawn) return;
    drawn = key;
    fetchNewest(key, volume.id, index, window, time, overlays);
  }

  let marked = []; // measurements
  const shownIndex = () => clamp(Math.round(sample[plane.axis]), 0, volume.dims[plane.axis] - 1);

  function mark(list) {
    marked = list;
    if (!volume || !area.clientWidth) return;
    const index = shownIndex();
    const [width, height] = [frame.clientWidth, frame.clientHeight];
    marks.draw({ marks: list, dims: volume.dims, index, turned, width, height, room: area.clientWidth });
  }

  // ---- pointers ---------------------------------------------------------------------------------------

  function sampleAt(event) {
    const box = frame.getBoundingClientRect();
    const across = (event.clientX - box.left) / box.width;
    const down = (event.clientY - box.top) / box.height;
    const inside = across >= 0 && across <= 1 && down >= 0 && down <= 1;
    const at = [...sample];
    const place = (axis, share) => clamp(Math.floor(share * volume.dims[axis]), 0, volume.dims[axis] - 1);
    at[plane.across] = place(plane.across, turned[0] ? 1 - across : across);
    at[plane.down] = place(plane.down, turned[1] ? 1 - down : down);
    return { at, inside };
  }

  // The place under the pointer, between samples.
  function pointAt(event) {
    const box = frame.getBoundingClientRect();
    const at = sample.map((s) => Math.round(s));
    const place = (axis, share, flip) => clamp(flip ? 1 - share : share, 0, 1) * volume.dims[axis] - 0.5;
    at[plane.across] = place(plane.across, (event.clientX - box.left) / box.width, turned[0]);
    at[plane.down] = place(plane.down, (event.clientY - box.top) / box.height, turned[1]);
    return at;
  }

  // What a pointer there moves of the measurements.
  function grabbedAt(event) {
    const box = frame.getBoundingClientRect();
    const across = (place, axis, flip) => (flip ? 1 - (place + 0.5) / volume.dims[axis] : (place + 0.5) / volume.dims[axis]);
    const toPage = (place) => [
      box.width * across(place[plane.across], plane.across, turned[0]),
      box.height * across(place[plane.down], plane.down, turned[1]),
    ];
    const at = [event.clientX - box.left, event.clientY - box.top];
    return grabAt(marked, plane, shownIndex(), toPage, at, REACH[event.pointerType] ?? REACH.mouse);
  }

  // A click places a point; a drag places one at either end.
  const moves = (event) => Math.hypot(event.clientX - drag.x, event.clientY - drag.y) > CLICK_SLACK;
  function measured(event) {
    const place = pointAt(event);
    if (event.type === "pointerdown") tool.place(place);
    else if (event.type === "pointermove") tool.point(place);
    else if (drag && tool.placed && moves(event)) tool.place(place);
  }

  function scrolled(steps, live) {
    const at = [...sample];
    at[plane.axis] = clamp(Math.round(at[plane.axis]) + steps, 0, volume.dims[plane.axis] - 1);
    moved(at, live);
  }

  area.addEventListener("pointerdown", (event) => {
    if (!volume || drag) return;
    const setsWindow = event.button === 2 || (event.button === 0 && !tool.kind && windowing());
    if (!setsWindow && event.button !== 0) return;
    area.setPointerCapture(event.pointerId);
    const grabbed = setsWindow || tool.kind ? null : grabbedAt(event);
    if (grabbed) {
      drag = { grabbed, x: event.clientX, y: event.clientY };
      holdFigures(true);
      return;
    }
    drag = { x: event.clientX, y: event.clientY, setsWindow, measures: !setsWindow && tool.kind !== null };
    if (drag.measures) measured(event);
    else if (setsWindow) windowed(0, 0, "start");
    else moved(sampleAt(event).at, true);
  });
  area.addEventListener("pointermove", (event) => {
    if (!volume) return;
    const { at, inside } = sampleAt(event);
    if (!drag) area.style.cursor = !tool.kind && grabbedAt(event) ? "grab" : "";
    if (drag?.grabbed) {
      drag.moved ||= moves(event);
      if (drag.moved) moveGrabbed(drag.grabbed, pointAt(event), volume.dims);
    } else if (drag?.setsWindow) windowed(event.clientX - drag.x, event.clientY - drag.y, "move");
    else if (drag?.measures || (!drag && tool.placed)) measured(event);
    else if (drag) moved(at, true);
    hovered(inside ? at : null);
  });
  const finish = (event) => {
    if (!drag) return;
    const { setsWindow, measures, grabbed, moved: grabbedMoved, x, y } = drag;
    if (measures && event.type === "pointerup") measured(event);
    drag = null;
    if (grabbed) {
      if (grabbedMoved) store.set({});
      holdFigures(false);
    }
    if (measures || grabbedMoved) return;
    if (grabbed) {
      if (event.type === "pointerup") moved(sampleAt(event).at, false);
    } else if (setsWindow) windowed(event.clientX - x, event.clientY - y, "end");
    else moved(sample, false);
  };
  area.addEventListener("pointerup", finish);
  area.addEventListener("pointercancel", finish);
  area.addEventListener("pointerleave", () => hovered(null));
  area.addEventListener("contextmenu", (event) => event.preventDefault());

  let wheel = 0;
  area.addEventListener(
    "wheel",
    (event) => {
      if (!volume || event.ctrlKey) return;
      event.preventDefault();
      wheel += event.deltaMode ? event.deltaY * 30 : event.deltaY;
      const steps = Math.trunc(wheel / 30);
      wheel -= steps * 30;
      if (steps) scrolled(clamp(steps, -8, 8), false);
    },
    { passive: false },
  );

  area.addEventListener("keydown", (event) => {
    if (!volume || event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.key === "Enter" && tool.kind) {
      event.preventDefault();
      tool.place(sample.map((s) => Math.round(s)));
      return;
    }
    const size = event.shiftKey ? 10 : 1;
    const right = turned[0] ? -1 : 1;
    const down = turned[1] ? -1 : 1;
    const step = {
      ArrowLeft: [plane.across, -right],
      ArrowRight: [plane.across, right],
      ArrowUp: [plane.down, -down],
      ArrowDown: [plane.down, down],
      PageUp: [plane.axis, 1],
      PageDown: [plane.axis, -1],
      Home: [plane.axis, -Infinity],
      End: [plane.axis, Infinity],
    }[event.key];
    if (!step) return;
    const at = sample.map(Math.round);
    at[step[0]] = clamp(at[step[0]] + step[1] * size, 0, volume.dims[step[0]] - 1);
    moved(at, false);
    event.preventDefault();
    event.stopPropagation();
  });
  slider.addEventListener("input", () => scrolled(Number(slider.value) - Math.round(sample[plane.axis]), true));
  slider.addEventListener("change", () => moved(sample, false));
  slider.addEventListener("keydown", (event) => event.stopPropagation());

  return {
    node,
    show,
    /** Draws measurements (measure/shown.js). */
    mark,
    /** Call after a change of its size, or when it becomes visible. */
    resized: fitFrame,
  };
}
