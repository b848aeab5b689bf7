// Three orthogonal slices with a cross-hair, the value under the pointer, and their window.

import { button, element, field, newestOnly } from "../controls/panel_kit.js";
import { meaningOf, rounded, shortNumber } from "../state/meaning.js";
import { marksToDraw, onFigures } from "../measure/shown.js";
import { lettersOf, planeName } from "./orientation.js";
import { overlayTexts, requestOverlays } from "../state/overlays.js";
import { SLICES } from "../state/panel_state.js";
import { createSlice } from "./slice_view.js";
import { sliceWindows } from "./slice_window.js";
import { tool } from "../measure/tool.js";
import { CT_WINDOWS } from "../transfer/transfer_presets.js";

const VALUE_EVERY_MS = 60;

export function mount(panel, { store, api, volumes, stage }) {
  store.set({ page: { slices: { ...SLICES, ...store.state.page.slices } } }, { undo: false });
  const windows = sliceWindows({ store, api, volumes });
  let windowMode = false;
  let windowStart = null;
  let seen = false; // the slices are visible: hidden ones are not requested

  // ---- elements on the stage --------------------------------------------------------------------------

  const slices = ["z", "y", "x"].map((name) =>
    createSlice(name, {
      fetchSlice: (id, axis, index, window, time, overlays) => api.slice(id, axis, index, window, { time, overlays }),
      moved: (sample, live) => store.set({ page: { sample } }, { live, undo: false }),
      hovered,
      windowed,
      windowing: () => windowMode,
      failed: (error) => (trouble.textContent = error ? error.message : ""),
    }),
  );
  const readout = element("output", { class: "slices-readout", "aria-label": "Value" });
  const windowOut = element("span", { class: "slices-window" });
  const trouble = element("span", { class: "slices-trouble", role: "status" });
  const grid = element("div", { class: "slices-grid" }, ...slices.map((slice) => slice.node));
  const line = element("div", { class: "slices-line" }, readout, windowOut, trouble);
  const box = element("div", { class: "slices-box" }, grid, line);
  stage.slices.append(box);

  // ---- elements in the panel --------------------------------------------------------------------------

  const showBox = element("input", {
    type: "checkbox",
    onchange: () => store.set({ page: { layout: showBox.checked ? "slices" : "single" } }, { undo: false }),
  });
  const coordinates = ["x", "y", "z"].map((name, axis) =>
    field(
      name,
      element("input", {
        type: "number",
        step: 1,
        min: 0,
        onchange: (event) => typeCoordinate(axis, event.target),
      }),
    ),
  );
  const low = field("Black", element("input", { type: "number", step: "any", onchange: typeWindow }));
  const high = field("White", element("input", { type: "number", step: "any", onchange: typeWindow }));
  const named = element("div", { class: "buttons" });
  const modeButton = button("Drag sets window", toggleMode, {
    "aria-pressed": "false",
    title:
      "Dragging in a slice sets the window: sideways the width, up and down the level. The right button always does that.",
  });
  panel.classList.add("panel-slices");
  panel.append(
    element("label", { class: "check" }, showBox, "Show slices"),
    group("Cross-hair, samples", element("div", { class: "field-grid" }, ...coordinates.map(({ node }) => node))),
    group(
      "Window",
      element("div", { class: "field-grid" }, low.node, high.node),
      named,
      element("div", { class: "buttons" }, modeButton),
    ),
    element(
      "p",
      { class: "hint" },
      "Click or drag: move the cross-hair. Wheel: change the slice. Right button: set the window.",
    ),
  );

  function group(legend, ...children) {
    return element("fieldset", { class: "panel-group" }, element("legend", {}, legend), ...children);
  }

  function toggleMode() {
    windowMode = !windowMode;
    show();
  }

  // ---- cross-hair -------------------------------------------------------------------------------------

  function sample() {
    const { dims } = volumes.current();
    const at = store.state.page.sample || dims.map((n) => (n - 1) / 2);
    return at.map((s, a) => Math.min(dims[a] - 1, Math.max(0, Math.round(s))));
  }

  function typeCoordinate(axis, input) {
    if (volumes.current()?.state !== "ready") return;
    const at = sample();
    if (input.value !== "") at[axis] = Math.min(volumes.current().dims[axis] - 1, Math.max(0, Number(input.value)));
    store.set({ page: { sample: at } }, { undo: false });
    show();
  }

  // ---- window -----------------------------------------------------------------------------------------

  function windowed(dx, dy, phase) {
    if (phase === "start") windowStart = windows.get();
    if (!windowStart) return;
    const volume = volumes.current();
    const [from, to] = windowStart;
    const span = Math.max((to - from) * 2 ** (dx / 120), 1e-4 * (volume.max - volume.min));
    const level = (from + to) / 2 + (dy * (to - from)) / 300;
    const wanted = dx || dy ? [level - span / 2, level + span / 2] : windowStart;
    if (dx || dy) windows.set(wanted, phase !== "end");
    if (phase === "end") windowStart = null;
  }

  function typeWindow() {
    const meaning = meaningOf(volumes.current());
    const [from, to] = [low.input, high.input].map((input) => meaning.from(Number(input.value)));
    if (low.input.value !== "" && high.input.value !== "" && to > from) windows.set([from, to]);
    else show();
  }

  let namedFor = "";

  function showNamedWindows(volume) {
    if (namedFor === volume.id) return;
    namedFor = volume.id;
    const meaning = meaningOf(volume);
    const bounds = (level, width) => [meaning.from(level - width / 2), meaning.from(level + width / 2)];
    named.replaceChildren(
      button("Fit", () => windows.set(null)),
      button("All values", () => windows.set([volume.min, volume.max])),
      ...(volume.rescale ? CT_WINDOWS : []).map(([name, ...window]) =>
        button(name, () => windows.set(bounds(...window))),
      ),
    );
  }

  // ---- the value under the pointer --------------------------------------------------------------------

  let pointed = null;

  function hovered(at) {
    pointed = at;
    askValue();
  }

  const askValue = newestOnly(async () => {
    const volume = volumes.current();
    if (volume?.state !== "ready" || !seen) return;
    const at = pointed || sample();
    try {
      const { value, label, overlays } = await api.value(volume.id, ...at, { time: store.state.view.time });
      const means = meaningOf(volume);
      const number = (x) => shortNumber(x, means.digits + 1);
      const meaning = value === null ? NaN : means.to(value); // as axes and windows
      const unit = value !== null && means.unit ? ` ${means.unit}` : "";
      const stored = value !== null && meaning !== value ? element("span", {}, ` stored ${number(value)}`) : "";
      const more = overlayTexts(overlays, store.state.view, volume).flatMap((text) => [" · ", element("span", { class: "of-overlay" }, text)]);
      const text = number(meaning) + unit;
      readout.replaceChildren(element("b", {}, label ? `${text} ${label}` : text), stored, ` at ${at.join(", ")}`, ...more);
    } catch (error) {
      readout.textContent = error.message;
    }
    await new Promise((resolve) => setTimeout(resolve, VALUE_EVERY_MS));
  });

  // ---- updates ----------------------------------------------------------------------------------------

  function showPanel(volume, at, window, meaning) {
    coordinates.forEach(({ input }, axis) => {
      input.value = at[axis];
      input.max = volume.dims[axis] - 1;
    });
    const unit = meaning.unit && `, ${meaning.unit}`;
    [low, high].forEach(({ node, input }, k) => {
      node.firstChild.textContent = ["Black", "White"][k] + unit;
      input.value = rounded(meaning.to(window[k]), meaning.digits + 1);
    });
    showNamedWindows(volume);
  }

  function show() {
    const volume = volumes.current();
    showBox.checked = store.state.page.layout === "slices";
    modeButton.setAttribute("aria-pressed", windowMode);
    grid.classList.toggle("windowing", windowMode);
    const ready = volume?.state === "ready";
    panel.inert = !ready;
    box.inert = !ready;
    if (!ready) return;
    const window = windows.get();
    const meaning = meaningOf(volume);
    const at = sample();
    showPanel(volume, at, window, meaning);
    if (!seen) return;
    const letters = lettersOf(volume);
    const overlays = requestOverlays(store.state.view);
    const coloured = volume.labels && !windows.chosen();
    windowOut.textContent = coloured
      ? "colours of the labels"
      : `window ${shortNumber(meaning.to(window[0]), meaning.digits)} to ${meaning.text(window[1])}`;
    const greys = coloured ? null : window;
    slices.forEach((slice, k) => slice.show(volume, store.state.view.time, at, greys, overlays, letters, planeName(letters, 2 - k)));
    mark();
    if (!pointed) askValue();
  }

  function mark() {
    if (!seen || volumes.current()?.state !== "ready") return;
    const marks = marksToDraw();
    grid.classList.toggle("measuring", tool.kind !== null);
    for (const slice of slices) slice.mark(marks);
  }

  const watch = new ResizeObserver(() => {
    seen = grid.clientWidth > 0;
    for (const slice of slices) slice.resized();
    show();
  });
  watch.observe(grid);

  windows.subscribe(show);
  tool.subscribe(mark);
  onFigures(mark);
  volumes.subscribe(show);
  store.subscribe((state, previous) => {
    if (
      ["sample", "slices", "layout", "measures"].some((name) => state.page[name] !== previous.page[name]) ||
      state.view.volume !== previous.view.volume ||
      state.view.overlays !== previous.view.overlays ||
      state.view.time !== previous.view.time
    )
      show();
  });
  show();
}
