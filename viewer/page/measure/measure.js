// The panel of measurements: tools, and the list with its figures.

import { button, copyFrom, download, element, field, statusLine, stem } from "../controls/panel_kit.js";
import { replaceMeasure } from "./grab.js";
import { withFace, withPoint } from "./handles.js";
import { csvOf, isRegion, KINDS, makeMeasure, middleOf, MOST, rowsOf } from "../state/measures.js";
import { currentRoot, onFigures, shownMeasures } from "./shown.js";
import { tool } from "./tool.js";

export function mount(panel, { store, volumes }) {
  const list = () => store.state.page.measures.list;
  const change = (measures, options) => store.set({ page: { measures } }, options);
  const status = statusLine();
  const opened = new Set(); // numbers of those whose places are shown

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
    const measure = list()[index];
    const border = Number(input.value) + (face % 2);
    if (input.value !== "") replaceMeasure(index, { ...measure, box: withFace(measure.box, face, border, volumes.current().dims) });
    show();
  }

  function typePart(index, point, axis, input) {
    const measure = list()[index];
    const place = measure.points[point].map((part, a) => (a === axis ? Number(input.value) : part));
    if (input.value !== "") replaceMeasure(index, withPoint(measure, point, place, volumes.current().dims));
    show();
  }

  // ---- the list ---------------------------------------------------------------------------------------

  const number = (label, shown, attributes) =>
    field(shown, element("input", { type: "number", "aria-label": label, "data-at": label, ...attributes })).node;

  function facesOf({ number: n, index, measure }) {
    return ["x from", "x to", "y from", "y to", "z from", "z to"].map((name, face) =>
      number(`${KINDS[measure.kind].name} ${n}, ${name}`, name, {
        step: 1,
        min: 0,
        max: volumes.current().dims[face >> 1] - 1,
        value: measure.box[face] - (face % 2),
        onchange: (event) => typeFace(index, face, event.target),
      }),
    );
  }

  function partsOf({ number: n, index, measure }) {
    return measure.points.flatMap((place, point) =>
      place.map((part, axis) =>
        number(`${KINDS[measure.kind].name} ${n}, point ${point + 1}, ${"xyz"[axis]}`, `${"xyz"[axis]} of ${point + 1}`, {
          step: "any",
          value: part,
          onchange: (event) => typePart(index, point, axis, event.target),
        }),
      ),
    );
  }

  function placesOf(item) {
    const { number: n, measure } = item;
    const region = isRegion(measure);
    return element(
      "details",
      { class: "measure-faces", open: opened.has(n), ontoggle: (event) => (event.target.open ? opened.add(n) : opened.delete(n)) },
      element("summary", { "data-at": `places ${n}` }, region ? "First and last samples" : "Points, in samples"),
      element("div", { class: region ? "field-grid pairs" : "field-grid triples" }, ...(region ? facesOf(item) : partsOf(item))),
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
      placesOf(item),
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
