// The panel of colours and opacities: presets, the editor over the histogram, the selected point, colour maps,
// files.

import { button, clamp, element, field, logSlider, statusLine } from "../controls/panel_kit.js";
import { tinted } from "../state/channels.js";
import { colourAt, colourMaps, hexOf, rgbOf } from "./colour_maps.js";
import { robustRange } from "./histogram.js";
import { meaningOf, rounded, shortNumber } from "../state/meaning.js";
import { transferFiles } from "./transfer_files.js";
import { createEditor } from "./transfer_editor.js";
import { coloured, extent, moved, recoloured, simplified, stretched } from "./transfer_points.js";
import { CT_WINDOWS, presetGroups, presetWord } from "./transfer_presets.js";

const PROJECTIONS = ["xray", "mip", "min"];
const OWN = "(own)";

/** The initial function if the server cannot fit one. */
function plainRamp({ min, max }) {
  return [
    [min, 0.1, 0.1, 0.1, 0],
    [max, 1, 1, 1, 0.3],
  ];
}

export function mount(panel, { store, api, volumes }) {
  let about = { transfers: ["auto"], ct_transfers: [] };
  let fitted = [[0, 0, 0, 0, 0]]; // the points of the named function, fitted to this volume
  let fittedOf = ""; // the volume and name of `fitted`
  let histogram = null;
  let histogramOf = null;
  let range = null; // the visible range of values
  let logarithmic = true;
  let whole = false; // show all values, not only the relevant range
  const status = statusLine();

  // ---- edited points ----------------------------------------------------------------------------------

  const volume = () => volumes.current();
  const view = () => store.state.view;
  const kind = () => (PROJECTIONS.includes(view().mode) ? "window" : view().mode === "iso" ? "surface" : "points");

  function points() {
    const { transfer, window, surface } = view();
    const bounds = histogram || { min: volume()?.min ?? 0, max: volume()?.max ?? 1 };
    if (kind() === "window") {
      const [black, white] = window || [bounds.min, bounds.max];
      return [
        [black, 0, 0, 0, 0],
        [white, 1, 1, 1, 1],
      ];
    }
    if (kind() === "surface") {
      return [[surface.value ?? (bounds.min + bounds.max) / 2, ...surface.colour, 1]];
    }
    return tinted(typeof transfer === "string" ? fitted : transfer, view());
  }

  function change(next, live) {
    if (kind() === "window") store.set({ view: { window: [next[0][0], next[1][0]] } }, { live });
    else if (kind() === "surface")
      store.set({ view: { surface: { value: next[0][0], colour: next[0].slice(1, 4) } } }, { live });
    else store.set({ view: { transfer: next } }, { live });
  }

  // ---- elements ---------------------------------------------------------------------------------------

  const editor = createEditor({ changed: change, selected: showChosen });

  const preset = element("select", {
    onchange: () => {
      if (preset.value !== OWN) store.set({ view: { transfer: preset.value } });
    },
  });
  const presetField = field("Preset", preset);

  const toggle = (text, title, onclick) => button(text, onclick, { "aria-pressed": "false", title });
  const logButton = toggle("Log", "Heights of the histogram: logarithms of the counts", () => {
    logarithmic = !logarithmic;
    show();
  });
  const wholeButton = toggle("Show all", "Show all values there are, not those that matter", () => {
    whole = !whole;
    range = null;
    show();
  });

  const valueInput = element("input", { type: "number", step: "any", onchange: typeValue });
  const opacityInput = element("input", { type: "number", min: 0, max: 100, step: "any", onchange: typeOpacity });
  const colourInput = element("input", {
    type: "color",
    oninput: () => paint(true),
    onchange: () => paint(false),
  });
  const valueField = field("Value", valueInput);
  const opacityField = field("Opacity, %", opacityInput);
  const colourField = field("Colour", colourInput);
  const addButton = button("Add", addAfter, { title: "Add a point after this one (Insert)" });
  const deleteButton = button("Delete", () => editor.remove(editor.chosen), { title: "Delete this point (Delete)" });
  const chosenTitle = element("legend", {}, "Point");
  const chosenBox = element(
    "fieldset",
    { class: "panel-group chosen-point" },
    chosenTitle,
    element("div", { class: "field-grid" }, valueField.node, opacityField.node, colourField.node),
    element("div", { class: "buttons" }, addButton, deleteButton),
  );

  const levelInput = element("input", { type: "number", step: "any", onchange: typeWindow });
  const widthInput = element("input", { type: "number", step: "any", onchange: typeWindow });
  const levelField = field("Level", levelInput);
  const widthField = field("Width", widthInput);
  const windowButtons = element("div", { class: "buttons" });
  const levelBox = element(
    "fieldset",
    { class: "panel-group" },
    element("legend", {}, "Window"),
    element("div", { class: "field-grid" }, levelField.node, widthField.node),
    windowButtons,
  );

  const swatches = element("div", { class: "map-swatches" }, ...colourMaps.map(swatch));
  const coloursBox = element("fieldset", { class: "panel-group" }, element("legend", {}, "Colour map"), swatches);

  const density = logSlider(0.02, 50, {
    oninput: () => scaleOpacity(true),
    onchange: () => scaleOpacity(false),
    ondblclick: () => store.set({ view: { opacity_scale: 1 } }),
  });
  const densityOut = element("output", {});
  const densityField = field("Density", density.input, densityOut);

  const filesRow = transferFiles({
    api,
    volumes,
    status,
    points: () => points(),
    loaded(read) {
      store.set({ view: { transfer: read } });
      range = null;
      show();
    },
  });

  const hint = element("p", { class: "hint" });
  const keys =
    "Keys: Tab selects the next point, arrows move it (Shift: further), Insert adds one, Delete removes it.";
  const keysHint = element("p", { class: "unseen", id: "transfer-keys" }, keys);
  editor.node.setAttribute("aria-describedby", keysHint.id);
  panel.classList.add("panel-transfer");
  panel.append(
    presetField.node,
    element("div", { class: "editor-bar buttons" }, logButton, wholeButton),
    editor.node,
    hint,
    keysHint,
    chosenBox,
    levelBox,
    densityField.node,
    coloursBox,
    filesRow,
    status.node,
  );

  function swatch(name) {
    const stops = Array.from({ length: 9 }, (_, k) => hexOf(colourAt(name, k / 8)));
    const bar = element("span", { class: "swatch-bar" });
    bar.style.backgroundImage = `linear-gradient(to right, ${stops.join(", ")})`;
    return button("", () => applyMap(name), {
      class: "button swatch",
      title: `${name}: change the colours, keep the opacities`,
    })
      .appendChild(bar)
      .parentNode.appendChild(element("span", {}, name)).parentNode;
  }

  // ---- actions ----------------------------------------------------------------------------------------

  function applyMap(name) {
    store.set({ view: { transfer: coloured(points(), name) } });
    status.say(`Colours of ${name}.`);
  }

  function addAfter() {
    const all = points();
    const [from, to] = [all[editor.chosen], all[editor.chosen + 1]];
    editor.add(to ? (from[0] + to[0]) / 2 : from[0] + (range[1] - range[0]) / 20);
  }

  function typeValue() {
    const value = meaningOf(volume()).from(Number(valueInput.value));
    const all = points();
    if (valueInput.value === "" || !Number.isFinite(value)) return showChosen();
    return change(moved(all, editor.chosen, value, all[editor.chosen][4]), false);
  }

  function typeOpacity() {
    const all = points();
    if (opacityInput.value === "") return showChosen();
    return change(moved(all, editor.chosen, all[editor.chosen][0], Number(opacityInput.value) / 100), false);
  }

  function paint(live) {
    change(recoloured(points(), editor.chosen, rgbOf(colourInput.value)), live);
  }

  function setWindow(low, high) {
    const all = points();
    change(stretched(all, Math.min(low, high), Math.max(low, high)), false);
  }

  function typeWindow() {
    const meaning = meaningOf(volume());
    const [level, span] = [Number(levelInput.value), Math.abs(Number(widthInput.value))];
    if (levelInput.value === "" || !(span > 0)) return showWindow();
    return setWindow(meaning.from(level - span / 2), meaning.from(level + span / 2));
  }

  function scaleOpacity(live) {
    const value = density.get();
    // Values close to 1 become 1.
    store.set(
      { view: { opacity_scale: Math.abs(Math.log(value)) < 0.03 ? 1 : Number(value.toPrecision(3)) } },
      { live },
    );
  }

  // ---- updates ----------------------------------------------------------------------------------------

  function fit() {
    const all = points();
    const bounds = histogram || { min: volume()?.min ?? 0, max: volume()?.max ?? 1 };
    let [low, high] = whole || !histogram ? [bounds.min, bounds.max] : robustRange(histogram, 0.0005, 0.0005);
    const [first, last] = extent(all);
    low = Math.min(low, first);
    high = Math.max(high, last);
    const air = 0.02 * (high - low || 1);
    range = [low - air, high + air];
  }

  function showChosen() {
    const meaning = meaningOf(volume());
    const all = points();
    const index = clamp(editor.chosen, 0, all.length - 1);
    const point = all[index];
    chosenTitle.textContent =
      kind() === "points"
        ? `Point ${index + 1} of ${all.length}`
        : kind() === "window"
          ? index
            ? "White"
            : "Black"
          : "Surface";
    valueField.node.firstChild.textContent = meaning.unit ? `Value, ${meaning.unit}` : "Value";
    valueInput.value = rounded(meaning.to(point[0]), meaning.digits + 1);
    valueInput.step = meaning.step;
    opacityInput.value = Number((point[4] * 100).toFixed(2));
    colourInput.value = hexOf(point.slice(1, 4));
    deleteButton.disabled = all.length < 2;
  }

  function showWindow() {
    const meaning = meaningOf(volume());
    const [low, high] = extent(points()).map(meaning.to);
    const digits = meaning.digits + 1;
    levelInput.value = rounded((low + high) / 2, digits);
    widthInput.value = rounded(Math.abs(high - low), digits);
    levelField.node.firstChild.textContent = meaning.unit ? `Level, ${meaning.unit}` : "Level";
    widthField.node.firstChild.textContent = meaning.unit ? `Width, ${meaning.unit}` : "Width";
  }

  function showWindowButtons() {
    const named = volume()?.rescale && kind() === "window" ? CT_WINDOWS : [];
    const meaning = meaningOf(volume());
    const plain = [
      [
        "All values",
        () => (kind() === "window" ? store.set({ view: { window: null } }) : setWindow(histogram.min, histogram.max)),
      ],
      ["Fit", () => setWindow(...robustRange(histogram))],
    ];
    windowButtons.replaceChildren(
      ...(histogram ? plain.map(([text, act]) => button(text, act)) : []),
      ...named.map(([text, level, span]) =>
        button(text, () => setWindow(meaning.from(level - span / 2), meaning.from(level + span / 2))),
      ),
    );
  }

  function showPresets() {
    const { transfer } = view();
    const groups = presetGroups(about, volume()).map(([label, names]) =>
      element("optgroup", { label }, ...names.map((name) => element("option", { value: name }, presetWord(name)))),
    );
    const own = element("option", { value: OWN, disabled: true, hidden: true }, "Edited");
    preset.replaceChildren(own, ...groups);
    preset.value = typeof transfer === "string" ? transfer : OWN;
  }

  const HINTS = {
    points:
      "Drag a point to move it. Click the line or double-click to add one. Drag it out or press Delete to remove it. Drag elsewhere: window and level.",
    window: "Drag black or white. Drag elsewhere: sideways for the level, up and down for the width.",
    surface: "Drag the line to the value of the surface.",
  };

  function show() {
    panel.inert = volume()?.state !== "ready";
    if (!range) fit();
    editor.show({
      kind: kind(),
      points: points(),
      histogram,
      meaning: meaningOf(volume()),
      logarithmic,
      low: range[0],
      high: range[1],
    });
    logButton.setAttribute("aria-pressed", logarithmic);
    wholeButton.setAttribute("aria-pressed", whole);
    hint.textContent = HINTS[kind()];
    presetField.node.hidden = kind() !== "points";
    densityField.node.hidden = kind() !== "points";
    coloursBox.hidden = kind() !== "points";
    filesRow.hidden = kind() !== "points";
    levelBox.hidden = kind() === "surface";
    opacityField.node.hidden = kind() !== "points";
    colourField.node.hidden = kind() === "window";
    addButton.parentNode.hidden = kind() !== "points";
    preset.value = typeof view().transfer === "string" ? view().transfer : OWN;
    const { opacity_scale: scale } = view();
    density.set(scale, `${shortNumber(scale, 2)} times`);
    densityOut.value = `× ${shortNumber(scale, 2)}`;
    showChosen();
    showWindow();
  }

  // ---- requests ---------------------------------------------------------------------------------------

  // A file that is arriving has other values at each level.
  const valuesOf = (at) => `${at?.id} ${at?.arrived_level ?? 0}`;

  async function fetchHistogram() {
    const at = volume();
    const wanted = valuesOf(at);
    if (at?.state !== "ready" || histogramOf === wanted) return;
    histogramOf = wanted;
    histogram = null;
    range = null;
    try {
      const read = await api.histogram(at.id);
      if (histogramOf === wanted) histogram = read;
    } catch (error) {
      if (histogramOf === wanted) status.say(error.message, true);
    }
    range = null;
    showWindowButtons();
    show();
  }

  async function fetchFitted() {
    const at = volume();
    const { transfer } = view();
    const wanted = `${valuesOf(at)} ${transfer}`;
    if (at?.state !== "ready" || typeof transfer !== "string" || fittedOf === wanted) return;
    fittedOf = wanted;
    try {
      const { points: read } = await api.transfer(at.id, transfer);
      if (fittedOf !== wanted) return;
      fitted = simplified(read);
      range = null;
      status.say("");
    } catch (error) {
      if (fittedOf !== wanted) return;
      fittedOf = "";
      status.say(error.message, true);
    }
    show();
  }

  function refresh() {
    showPresets();
    showWindowButtons();
    show();
    fetchHistogram();
    fetchFitted();
  }

  api.about().then(
    (answer) => {
      about = answer;
      refresh();
    },
    (error) => status.say(error.message, true),
  );
  volumes.subscribe(refresh);
  store.subscribe((state, previous, { live } = {}) => {
    const changed = state.view.volume !== previous.view.volume || state.view.mode !== previous.view.mode;
    if (changed) {
      range = null;
      status.say("");
      refresh();
    } else if (
      ["transfer", "window", "surface", "opacity_scale", "channels"].some((name) => state.view[name] !== previous.view[name])
    ) {
      const [first, last] = extent(points());
      if (!live && range && (first < range[0] || last > range[1])) range = null;
      show();
      if (!live) fetchFitted();
    }
  });
  refresh();
}
