// Controls that show and change a part of the state: sliders, choices, checks, buttons.
//
// Each is {element, update(state)}; bind() puts them into a panel and keeps them up to date.

import { store } from "../state/store.js";

let count = 0;
const freshId = () => `control-${++count}`;

// An element; attributes beginning with "on" are listeners.
export function make(tag, attributes = {}, ...children) {
  const node = tag.startsWith("svg:")
    ? document.createElementNS("http://www.w3.org/2000/svg", tag.slice(4))
    : document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === undefined || value === null || value === false) continue;
    if (name.startsWith("on")) node.addEventListener(name.slice(2), value);
    else node.setAttribute(name, value === true ? "" : value);
  }
  node.append(...children);
  return node;
}

export function bind(panel, controls) {
  const section = panel.closest("details");
  const update = (state) => controls.forEach((control) => control.update?.(state));
  panel.append(...controls.map((control) => control.element));
  // A closed panel is updated when it opens.
  const seen = (state) => (!section || section.open) && update(state);
  store.subscribe(seen);
  section?.addEventListener("toggle", () => seen(store.state));
  update(store.state);
  return update;
}

// Groups several controls as one.
export function group(element, controls, update) {
  element.append(...controls.map((control) => control.element));
  return {
    element,
    update(state) {
      controls.forEach((control) => control.update?.(state));
      update?.(state, element);
    },
  };
}

const STEPS = 1000;

// A number: label, slider, field. read(state) returns the value, write(value) the patch that sets it, limits(state)
// {min, max, step} if they change. `log`: the slider is logarithmic. `initial`: the value that a double click sets.
export function slider({ label, title, read, write, limits, min, max, step, log, initial, undo = true, enabled }) {
  const id = freshId();
  const bounds = { min, max, step };
  const toSlider = (value) =>
    log ? (Math.log(value / bounds.min) / Math.log(bounds.max / bounds.min)) * STEPS : value;
  const fromSlider = (place) => {
    if (!log) return place;
    const value = bounds.min * (bounds.max / bounds.min) ** (place / STEPS);
    return Number(value.toPrecision(3));
  };
  const set = (value, live) => store.set(write(value), { live, undo });
  const range = make("input", {
    type: "range",
    "aria-label": label,
    oninput: () => set(fromSlider(Number(range.value)), true),
    onchange: () => set(fromSlider(Number(range.value)), false),
    ondblclick: () => initial !== undefined && set(initial, false),
  });
  const number = make("input", {
    type: "number",
    id,
    step: "any",
    onchange() {
      const value = Number(number.value);
      if (number.value !== "" && Number.isFinite(value)) set(Math.min(bounds.max, Math.max(bounds.min, value)), false);
      number.value = shownNumber(read(store.state));
    },
  });
  const element = make("div", { class: "row", title }, make("label", { for: id }, label), range, number);
  function applyBounds() {
    range.min = log ? 0 : bounds.min;
    range.max = log ? STEPS : bounds.max;
    range.step = log ? 1 : bounds.step;
    number.min = bounds.min;
    number.max = bounds.max;
  }
  applyBounds();
  return {
    element,
    update(state) {
      const now = limits?.(state);
      if (now && (now.min !== bounds.min || now.max !== bounds.max || now.step !== bounds.step)) {
        Object.assign(bounds, now);
        applyBounds();
      }
      const value = read(state);
      range.value = toSlider(value);
      range.setAttribute("aria-valuetext", shownNumber(value));
      if (document.activeElement !== number || number.value === "") number.value = shownNumber(value);
      range.disabled = number.disabled = enabled ? !enabled(state) : false;
    },
  };
}

export const shownNumber = (value) => String(Number(Number(value).toPrecision(5)));

export function check({ label, title, read, write, undo = true, enabled }) {
  const input = make("input", {
    type: "checkbox",
    onchange: () => store.set(write(input.checked), { undo }),
  });
  return {
    element: make("label", { class: "check", title }, input, make("span", {}, label)),
    update(state) {
      input.checked = read(state);
      input.disabled = enabled ? !enabled(state) : false;
    },
  };
}

// One of several options: [value, text, title]. choose(value) applies the choice, or write(value) returns a patch.
export function choice({ label, options, read, write, choose, style = "", undo = true }) {
  choose ??= (value) => store.set(write(value), { undo });
  const name = freshId();
  const inputs = new Map();
  const labels = options.map(([value, text, title]) => {
    const input = make("input", { type: "radio", name, value, onchange: () => choose(value) });
    inputs.set(value, input);
    return make("label", { title }, input, make("span", {}, text));
  });
  return {
    element: make("div", { class: `choice ${style}`.trim(), role: "radiogroup", "aria-label": label }, ...labels),
    update(state) {
      const value = read(state);
      for (const [key, input] of inputs) input.checked = key === value;
    },
  };
}

// The same as a drop-down list.
export function select({ label, options, read, write, undo = true }) {
  const id = freshId();
  const list = make("select", {
    id,
    onchange: () => store.set(write(options[list.selectedIndex][0]), { undo }),
  });
  list.append(...options.map(([, text]) => make("option", {}, text)));
  return {
    element: make("div", { class: "row" }, make("label", { for: id }, label), make("div", { class: "rest" }, list)),
    update: (state) => (list.selectedIndex = options.findIndex(([value]) => value === read(state))),
  };
}

export function button({ label, title, press, pressed, enabled }) {
  const element = make("button", { type: "button", class: "button", title, onclick: press }, label);
  return {
    element,
    update(state) {
      if (pressed) element.setAttribute("aria-pressed", pressed(state));
      element.disabled = enabled ? !enabled(state) : false;
    },
  };
}

export const hint = (text) => ({ element: make("p", { class: "hint" }, text) });

const hexOf = (colour) =>
  `#${colour
    .map((c) =>
      Math.round(255 * c)
        .toString(16)
        .padStart(2, "0"),
    )
    .join("")}`;
const colourOf = (hex) => [1, 3, 5].map((at) => Number((parseInt(hex.slice(at, at + 2), 16) / 255).toFixed(4)));

// A colour, with presets: [[name, [r, g, b]], ...].
export function colour({ label, read, write, ready = [] }) {
  const id = freshId();
  const input = make("input", {
    type: "color",
    id,
    oninput: () => store.set(write(colourOf(input.value)), { live: true }),
    onchange: () => store.set(write(colourOf(input.value))),
  });
  const swatches = ready.map(([name, value]) =>
    make("button", { type: "button", class: "button", onclick: () => store.set(write(value)) }, name),
  );
  return {
    element: make(
      "div",
      { class: "row" },
      make("label", { for: id }, label),
      make("div", { class: "rest swatches" }, input, ...swatches),
    ),
    update: (state) => (input.value = hexOf(read(state))),
  };
}

// The two ends of a range on one slider. read(state): [from, to]; write([from, to]): a patch; limits(state): {max}.
export function span({ label, read, write, limits }) {
  const set = (live) => {
    let [from, to] = ends.map((end) => Number(end.value));
    if (from > to - 1) {
      // The dragged end stops at the other end.
      if (document.activeElement === ends[0]) from = to - 1;
      else to = from + 1;
    }
    store.set(write([from, to]), { live });
  };
  const ends = ["from", "to"].map((word) =>
    make("input", {
      type: "range",
      min: 0,
      step: 1,
      "aria-label": `${label} ${word}`,
      oninput: () => set(true),
      onchange: () => set(false),
    }),
  );
  const text = make("output", { class: "span-text" });
  const bar = make("div", { class: "span-bar" });
  return {
    element: make(
      "div",
      { class: "row span-row" },
      make("span", { class: "label" }, label),
      make("div", { class: "span" }, bar, ...ends),
      text,
    ),
    update(state) {
      const { max } = limits(state);
      const [from, to] = read(state);
      ends.forEach((end, i) => {
        end.max = max;
        end.value = i ? to : from;
      });
      bar.style.left = `${(100 * from) / max}%`;
      bar.style.right = `${100 - (100 * to) / max}%`;
      text.value = `${Math.round(from)} – ${Math.round(to)}`;
    },
  };
}
