// The editor of a transfer function, a window or an isovalue: points over the histogram.
//
// Points of kind "points" have a value and an opacity; of "window" (black, then white) and "surface" (one) only a
// value. Dragging the background moves all points (horizontally) and spreads them (vertically): window and level.

import { clamp, shape } from "../controls/panel_kit.js";
import { hexOf } from "./colour_maps.js";
import { histogramPath, ticks } from "./histogram.js";
import { shortNumber } from "../state/meaning.js";
import { extent, heightOf, insert, moved, opacityAt, pointAt, stretched, without } from "./transfer_points.js";

const MARGIN = { left: 38, right: 10, top: 10, bottom: 38 };
const STRIP = 10; // height of the colour strip below the plot
const OUTSIDE = 28; // pixels outside the editor at which a dragged point is removed
const OPACITY_TICKS = [0, 0.02, 0.1, 0.25, 0.5, 1];

let editors = 0;

/** Calls `changed(points, live)` and `selected(index)`; show(...) sets the state. */
export function createEditor({ changed, selected }) {
  const number = ++editors;
  const fade = shape("linearGradient", { id: `transfer-fade-${number}`, gradientUnits: "userSpaceOnUse" });
  const band = shape("linearGradient", { id: `transfer-band-${number}`, gradientUnits: "userSpaceOnUse" });
  const cut = shape("rect");
  const bars = shape("path", { class: "histogram-bars" });
  const area = shape("path", { class: "transfer-area", fill: `url(#transfer-fade-${number})` });
  const curve = shape("path", { class: "transfer-curve" });
  const reach = shape("path", { class: "transfer-reach" });
  const strip = shape("rect", { class: "transfer-strip", fill: `url(#transfer-band-${number})` });
  const axes = shape("g", { class: "editor-axes", "aria-hidden": "true" });
  const handles = shape("g", { class: "editor-handles" });
  const svg = shape(
    "svg",
    { class: "transfer-editor", role: "group", "aria-label": "Transfer function over the histogram" },
    shape("defs", {}, fade, band, shape("clipPath", { id: `transfer-cut-${number}` }, cut)),
    shape("g", { "clip-path": `url(#transfer-cut-${number})` }, bars, area),
    axes,
    strip,
    shape("g", { "clip-path": `url(#transfer-cut-${number})` }, curve, reach),
    handles,
  );

  let now = null; // the last state
  let width = 320;
  let height = 200;
  let chosen = 0;
  let drag = null;

  const inner = () => ({
    width: Math.max(40, width - MARGIN.left - MARGIN.right),
    height: Math.max(40, height - MARGIN.top - MARGIN.bottom),
  });
  const xOf = (value) => MARGIN.left + ((value - now.low) / (now.high - now.low)) * inner().width;
  const valueOf = (x) => now.low + ((x - MARGIN.left) / inner().width) * (now.high - now.low);
  const yOf = (opacity) => MARGIN.top + inner().height * (1 - heightOf(opacity));
  const opacityOf = (y) => opacityAt(1 - (y - MARGIN.top) / inner().height);
  const flat = () => now.kind !== "points";

  const handleY = (point) => (now.kind === "surface" ? MARGIN.top + inner().height / 2 : yOf(point[4]));

  // ---- drawing ----------------------------------------------------------------------------------------

  function curvePath() {
    if (now.kind === "surface") return `M${xOf(now.points[0][0])} ${MARGIN.top}V${MARGIN.top + inner().height}`;
    const points = [[now.low, ...now.points[0].slice(1)], ...now.points];
    points.push([now.high, ...now.points[now.points.length - 1].slice(1)]);
    let path = "";
    points.forEach((point, i) => {
      const before = points[i - 1];
      // Opacity curves are drawn as curves because of the square root; windows are straight.
      const pieces = i && !flat() && xOf(point[0]) - xOf(before[0]) > 4 ? 12 : 1;
      for (let k = i ? 1 : pieces; k <= pieces; k++) {
        const value = i ? before[0] + (k / pieces) * (point[0] - before[0]) : point[0];
        const opacity = i ? before[4] + (k / pieces) * (point[4] - before[4]) : point[4];
        path += `${path ? "L" : "M"}${xOf(value).toFixed(2)} ${yOf(opacity).toFixed(2)}`;
      }
    });
    return path;
  }

  function drawColours() {
    for (const [gradient, seeThrough] of [
      [fade, true],
      [band, false],
    ]) {
      gradient.setAttribute("x1", MARGIN.left);
      gradient.setAttribute("x2", MARGIN.left + inner().width);
      gradient.replaceChildren(
        ...now.points.map((point) =>
          shape("stop", {
            offset: clamp((point[0] - now.low) / (now.high - now.low), 0, 1),
            "stop-color": hexOf(point.slice(1, 4)),
            "stop-opacity": seeThrough ? 0.75 : 1,
          }),
        ),
      );
    }
  }

  function drawAxes() {
    const { width: w, height: h } = inner();
    const base = MARGIN.top + h;
    const lines = [];
    const meant = [now.meaning.to(now.low), now.meaning.to(now.high)].sort((a, b) => a - b);
    for (const tick of ticks(...meant, Math.max(2, w / 64))) {
      const x = xOf(now.meaning.from(tick));
      lines.push(shape("line", { x1: x, x2: x, y1: base + STRIP, y2: base + STRIP + 4 }));
      lines.push(shape("text", { x, y: base + STRIP + 16, "text-anchor": "middle" }, shortNumber(tick, now.meaning.digits + 2)));
    }
    if (now.meaning.unit)
      lines.push(shape("text", { x: 2, y: base + STRIP + 16, class: "editor-unit" }, now.meaning.unit));
    if (!flat())
      for (const opacity of OPACITY_TICKS) {
        const y = yOf(opacity);
        lines.push(shape("line", { class: "editor-grid", x1: MARGIN.left, x2: MARGIN.left + w, y1: y, y2: y }));
        lines.push(shape("text", { x: MARGIN.left - 5, y: y + 3.5, "text-anchor": "end" }, `${opacity * 100}%`));
      }
    axes.replaceChildren(...lines);
  }

  function nameOf(point, i) {
    if (now.kind === "surface") return "Value of the surface";
    if (now.kind === "window") return i ? "White" : "Black";
    return `Point ${i + 1} of ${now.points.length}`;
  }

  function drawHandles() {
    while (handles.children.length > now.points.length) handles.lastChild.remove();
    while (handles.children.length < now.points.length)
      handles.append(shape("circle", { r: 6.5, tabindex: 0, role: "slider", onfocus: chooseFocused }));
    now.points.forEach((point, i) => {
      const handle = handles.children[i];
      const said = now.meaning.text(point[0]) + (flat() ? "" : `, opacity ${shortNumber(point[4] * 100, 1)} %`);
      handle.setAttribute("cx", clamp(xOf(point[0]), MARGIN.left - 4, width - 4));
      handle.setAttribute("cy", handleY(point));
      handle.setAttribute("fill", hexOf(point.slice(1, 4)));
      handle.setAttribute("aria-label", nameOf(point, i));
      handle.setAttribute("aria-valuemin", now.meaning.to(now.low));
      handle.setAttribute("aria-valuemax", now.meaning.to(now.high));
      handle.setAttribute("aria-valuenow", now.meaning.to(point[0]));
      handle.setAttribute("aria-valuetext", said);
      handle.classList.toggle("chosen", i === chosen);
    });
  }

  function draw() {
    if (!now) return;
    const { width: w, height: h } = inner();
    svg.dataset.kind = now.kind;
    svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
    for (const [name, value] of Object.entries({ x: MARGIN.left, y: MARGIN.top - 2, width: w, height: h + 4 }))
      cut.setAttribute(name, value);
    bars.setAttribute("d", now.histogram ? histogramPath(now.histogram, { ...now, width: w, height: h }) : "");
    bars.setAttribute("transform", `translate(${MARGIN.left} ${MARGIN.top})`);
    for (const [name, value] of Object.entries({ x: MARGIN.left, y: MARGIN.top + h, width: w, height: STRIP }))
      strip.setAttribute(name, value);
    drawColours();
    drawAxes();
    const path = curvePath();
    curve.setAttribute("d", path);
    reach.setAttribute("d", path);
    const base = MARGIN.top + h;
    area.setAttribute("d", now.kind === "points" ? `${path}V${base}H${MARGIN.left}Z` : "");
    drawHandles();
  }

  // ---- changes ----------------------------------------------------------------------------------------

  function change(points, live) {
    now.points = points;
    chosen = clamp(chosen, 0, points.length - 1);
    draw();
    changed(points, live);
  }

  function choose(index) {
    chosen = index;
    drawHandles();
    selected(index);
  }

  function chooseFocused(event) {
    const index = [...handles.children].indexOf(event.target);
    if (index >= 0 && index !== chosen && !drag) choose(index);
  }

  function add(value, opacity = null) {
    if (flat()) return;
    const made = pointAt(now.points, value);
    if (opacity !== null) made[4] = opacity;
    const { points, index } = insert(now.points, made);
    chosen = index;
    change(points, false);
    choose(index);
    handles.children[index].focus();
  }

  function remove(index) {
    if (flat() || now.points.length < 2) return;
    change(without(now.points, index), false);
    choose(Math.min(index, now.points.length - 1));
    handles.children[chosen].focus();
  }

  // ---- pointers ---------------------------------------------------------------------------------------

  function placeOf(event) {
    const box = svg.getBoundingClientRect();
    return [((event.clientX - box.left) / box.width) * width, ((event.clientY - box.top) / box.height) * height];
  }

  function near(x, y) {
    const distances = now.points.map((point) => Math.hypot(xOf(point[0]) - x, handleY(point) - y));
    const index = distances.indexOf(Math.min(...distances));
    // If points coincide, prefer the selected one.
    const best = distances[chosen] <= distances[index] + 1 ? chosen : index;
    return distances[best] < 14 ? best : -1;
  }

  function begin(event) {
    if (!now || drag) return;
    const [x, y] = placeOf(event);
    const index = near(x, y);
    if (event.button === 2) {
      if (index >= 0) remove(index);
      return;
    }
    if (event.button !== 0) return;
    svg.setPointerCapture(event.pointerId);
    drag = { x, y, index, start: now.points, moved: false };
    if (index >= 0) choose(index);
    else if (event.target === reach && !flat()) {
      const made = insert(now.points, pointAt(now.points, valueOf(x)));
      drag = { ...drag, ...{ start: made.points, index: made.index, moved: true } };
      now.points = made.points;
      choose(made.index);
      change(made.points, true);
    } else if (event.target === reach && now.kind === "surface") drag.index = 0;
    if (drag.index >= 0) handles.children[drag.index].focus({ preventScroll: true });
    svg.classList.toggle("moving-all", drag.index < 0);
    event.preventDefault();
  }

  function isOutside(x, y) {
    return x < -OUTSIDE || x > width + OUTSIDE || y < -OUTSIDE || y > height + OUTSIDE;
  }

  function dragAll(x, y) {
    if (now.kind === "surface") return moved(drag.start, 0, valueOf(x), 1);
    const [low, high] = extent(drag.start);
    const level = (low + high) / 2 + ((x - drag.x) / inner().width) * (now.high - now.low);
    const span = Math.max((high - low) * 2 ** ((drag.y - y) / 80), 1e-3 * (now.high - now.low));
    return stretched(drag.start, level - span / 2, level + span / 2);
  }

  function follow(event) {
    if (!drag) return;
    const [x, y] = placeOf(event);
    if (!drag.moved && Math.hypot(x - drag.x, y - drag.y) < 3) return;
    drag.moved = true;
    if (drag.index < 0) return change(dragAll(x, y), true);
    if (!flat() && drag.start.length > 1 && isOutside(x, y)) return change(without(drag.start, drag.index), true);
    const opacity = flat() ? drag.start[drag.index][4] : opacityOf(y);
    chosen = drag.index;
    return change(moved(drag.start, drag.index, valueOf(clamp(x, MARGIN.left, width - MARGIN.right)), opacity), true);
  }

  function finish() {
    if (!drag) return;
    const { moved: hasMoved } = drag;
    drag = null;
    svg.classList.remove("moving-all");
    if (hasMoved) change(now.points, false);
    selected(chosen);
  }

  svg.addEventListener("pointerdown", begin);
  svg.addEventListener("pointermove", follow);
  svg.addEventListener("pointerup", finish);
  svg.addEventListener("pointercancel", finish);
  svg.addEventListener("contextmenu", (event) => event.preventDefault());
  svg.addEventListener("dblclick", (event) => {
    const [x, y] = placeOf(event);
    if (now && near(x, y) < 0) add(valueOf(x), opacityOf(y));
  });

  // ---- keys -------------------------------------------------------------------------------------------

  let keyMoved = false;

  handles.addEventListener("keydown", (event) => {
    const index = [...handles.children].indexOf(event.target);
    if (index < 0 || event.ctrlKey || event.metaKey || event.altKey) return;
    const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    if (step) {
      const [value, , , , opacity] = now.points[index];
      const size = event.shiftKey ? 10 : 1;
      const across = flat() ? step[0] + step[1] : step[0];
      const to = value + (across * size * (now.high - now.low)) / 200;
      const height = heightOf(opacity) + step[1] * size * 0.01;
      keyMoved = true;
      change(moved(now.points, index, to, flat() ? opacity : opacityAt(height)), true);
    } else if (event.key === "Delete" || event.key === "Backspace") remove(index);
    else if (event.key === "Insert" || event.key === "+") {
      const next = now.points[index + 1] || now.points[index - 1] || [now.high];
      add((now.points[index][0] + next[0]) / 2);
    } else return;
    event.preventDefault();
    event.stopPropagation();
  });
  const endKeys = () => {
    if (!keyMoved) return;
    keyMoved = false;
    change(now.points, false);
    selected(chosen);
  };
  handles.addEventListener("keyup", endKeys);
  handles.addEventListener("focusout", endKeys);

  new ResizeObserver(() => {
    const box = svg.getBoundingClientRect();
    if (!box.width || (box.width === width && box.height === height)) return;
    [width, height] = [box.width, box.height];
    draw();
  }).observe(svg);

  return {
    node: svg,
    get chosen() {
      return chosen;
    },
    get busy() {
      return Boolean(drag) || keyMoved;
    },
    choose,
    add,
    remove,
    /** {kind, points, histogram, meaning, logarithmic, low, high} */
    show(what) {
      now = what;
      chosen = clamp(chosen, 0, now.points.length - 1);
      draw();
    },
  };
}
