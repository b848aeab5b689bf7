// The panel of measurements: tools, and the list with its figures.

import { button, copyFrom, download, element, field, statusLine, stem } from "../controls/panel_kit.js";
import { areMeasures, csvOf, isRegion, KINDS, makeMeasure, middleOf, MOST, rowsOf } from "./measures.js";
import { currentRoot, onFigures, shownMeasures } from "./shown.js";
import { tool } from "./tool.js";

export function mount(panel, { store, volumes }) {
  const list = () => store.state.page.measures.list;
  const change = (measures, options) => store.set({ page: { measures } }, options);
  const status = statusLine();
  const opened = new Set(); // numbers of regions whose box is shown

  // ---- elements ---------------------------------------------------------------------------------------

  const tools = Object.entries(KINDS).map(([kind, { name, key }]) =>
    button(name, () => tool.choose(kind), { "aria-pressed": "false", title: `${name} (${key})`, "data-kind": kind }),
  );
  const how = element("p", { class: "hint", role: "status" });
  const rows = element("ol", { class: "measure-list" });
  const shown = element("input", { type: "checkbox", onchange: () => change({ shown: shown.checked }, { undo: false }) });
  const clip = button("Box of the clip", measureClip, { title: "Measures the samples in the clip box" });
  const area = element("textarea", { readonly: true, rows: 3, spellcheck: "false", class: "measure-table" });
  const table = field("As a table (CSV)", area);
  const more = element(
    "div",
    { class: "measure-more" },
    element("p", { class: "hint" }, "± is a proved bound of the difference from the original samples."),
    table.node,
    element(
      "div",
      { class: "buttons" },
      button("Copy", () => copyFrom(area, status, "Table")),
      button("Save CSV", () => download(area.value, `${stem(volumes.current())}-measures.csv`, "text/csv")),
      button("Delete all", () => change({ list: list().filter(({ of }) => of !== currentRoot()) })),
    ),
  );
  panel.classList.add("panel-measure");
  panel.append(
    element("div", { class: "buttons even tools-of-measure", role: "group", "aria-label": "Tools" }, ...tools),
    how,
    clip,
    element("label", { class: "check" }, shown, "Show in the pictures"),
    rows,
    more,
    status.node,
  );

  // ---- changes ----------------------------------------------------------------------------------------

  function add(measure) {
    if (list().length >= MOST) return status.say(`There are ${MOST} measurements: delete some first.`, true);
    status.say("");
    change({ list: [...list(), measure] });
  }

  tool.onFinish((kind, points) => add(makeMeasure(kind, currentRoot(), points, volumes.current().dims)));

  function measureClip() {
    const { dims } = volumes.current();
    const faces = store.state.view.clip.box ?? [null, null, null, null, null, null];
    const corners = [0, 1].map((end) => dims.map((n, a) => faces[2 * a + end] ?? end * (n - 1)));
    add(makeMeasure("box", currentRoot(), corners, dims));
  }

  function remove(index, number) {
    change({ list: list().filter((_, i) => i !== index) });
    const left = shownMeasures().length;
    (left ? panel.querySelector(`[data-at="delete ${Math.min(number, left)}"]`) : tools[0])?.focus();
  }

  function typeFace(index, face, input) {
    const { dims } = volumes.current();
    const measure = list()[index];
    const box = [...measure.box];
    const value = Math.round(Number(input.value));
    const [axis, end] = [face >> 1, face % 2];
    if (input.value !== "") box[face] = end ? Math.min(dims[axis] - 1, Math.max(box[face - 1], value)) + 1 : Math.max(0, Math.min(box[face + 1] - 1, value));
    const next = list().map((one, i) => (i === index ? { ...measure, box } : one));
    if (areMeasures(next)) change({ list: next });
    show();
  }

  // ---- the list ---------------------------------------------------------------------------------------

  function facesOf({ number, index, measure }) {
    const inputs = ["x from", "x to", "y from", "y to", "z from", "z to"].map(
      (name, face) =>
        field(
          name,
          element("input", {
            type: "number",
            step: 1,
            min: 0,
            max: volumes.current().dims[face >> 1] - 1,
            value: measure.box[face] - (face % 2),
            "data-at": `face ${number} ${face}`,
            "aria-label": `${KINDS[measure.kind].name} ${number}, ${name}`,
            onchange: (event) => typeFace(index, face, event.target),
          }),
        ).node,
    );
    const toggled = (event) => (event.target.open ? opened.add(number) : opened.delete(number));
    return element(
      "details",
      { class: "measure-faces", open: opened.has(number), ontoggle: toggled },
      element("summary", { "data-at": `faces ${number}` }, "First and last samples"),
      element("div", { class: "field-grid pairs" }, ...inputs),
    );
  }

  function figuresOf({ answer, error }) {
    if (error) return element("p", { class: "panel-status bad" }, error);
    if (!answer) return element("p", { class: "panel-status" }, "Measuring…");
    return element(
      "dl",
      { class: "measure-figures" },
      ...rowsOf(answer).flatMap(([name, text]) => [element("dt", {}, name), element("dd", {}, text)]),
    );
  }

  function rowOf(item) {
    const { number, index, measure } = item;
    const name = `${KINDS[measure.kind].name} ${number}`;
    const go = () => store.set({ page: { sample: middleOf(measure, volumes.current().dims) } }, { undo: false });
    return element(
      "li",
      {},
      element(
        "div",
        { class: "measure-head" },
        button(name, go, { class: "link", title: "Move the cross-hair there", "data-at": `go ${number}` }),
        button("✕", () => remove(index, number), { class: "icon small", "aria-label": `Delete ${name}`, title: "Delete", "data-at": `delete ${number}` }),
      ),
      figuresOf(item),
      isRegion(measure) ? facesOf(item) : null,
    );
  }

  function hint() {
    if (!tool.kind) return "Choose a tool, then click in slices or on the drawn surface.";
    const { name, how: what, points } = KINDS[tool.kind];
    const surface = ["composite", "iso"].includes(store.state.view.mode) ? "on the surface or in slices" : "in slices (this mode draws no surface)";
    const next = tool.placed ? `point ${tool.placed + 1} of ${points}` : what;
    return `${name}: ${next}, ${surface}. Enter places one at the cross-hair, Escape ends.`;
  }

  function showTool() {
    for (const node of tools) node.setAttribute("aria-pressed", node.dataset.kind === tool.kind);
    how.textContent = hint();
  }

  function show() {
    const volume = volumes.current();
    const ready = volume?.state === "ready";
    panel.inert = !ready;
    shown.checked = store.state.page.measures.shown;
    clip.hidden = !store.state.view.clip.box;
    if (!ready) return;
    const items = shownMeasures();
    const at = panel.contains(document.activeElement) ? document.activeElement.dataset.at : null;
    rows.replaceChildren(...items.map(rowOf));
    if (at) panel.querySelector(`[data-at="${at}"]`)?.focus();
    more.hidden = !items.length;
    area.value = items.length ? csvOf(items, volume.name, store.state.view.time) : "";
  }

  tool.subscribe(showTool);
  onFigures(show);
  volumes.subscribe(show);
  store.subscribe((state, previous) => {
    if (state.page.measures !== previous.page.measures || ["volume", "time", "clip"].some((name) => state.view[name] !== previous.view[name])) show();
    if (state.view.mode !== previous.view.mode) showTool();
  });
  showTool();
  show();
}
