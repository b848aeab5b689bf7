// Tools for panels: elements, labelled fields, single requests, downloads, copying.

const SVG = "http://www.w3.org/2000/svg";

function fill(node, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) node.addEventListener(name.slice(2), value);
    else if (value === true) node.setAttribute(name, "");
    else if (value !== false && value !== null && value !== undefined) node.setAttribute(name, value);
  }
  node.append(...children.filter((child) => child !== null && child !== undefined));
  return node;
}

/** Creates an element with attributes and children; attributes beginning with "on" are listeners. */
export function element(name, attributes = {}, ...children) {
  return fill(document.createElement(name), attributes, children);
}

/** The same for SVG elements. */
export function shape(name, attributes = {}, ...children) {
  return fill(document.createElementNS(SVG, name), attributes, children);
}

export function button(text, onclick, attributes = {}) {
  return element("button", { type: "button", class: "button", onclick, ...attributes }, text);
}

let fields = 0;

/** An input with a label above: {node, input}. */
export function field(label, input, after = null) {
  input.id ||= `panel-field-${++fields}`;
  const row = after === null ? [input] : [element("span", { class: "field-row" }, input, after)];
  return { node: element("div", { class: "field" }, element("label", { for: input.id }, label), ...row), input };
}

export function options(select, choices, chosen) {
  select.replaceChildren(
    ...choices.map(([value, text]) => element("option", { value, selected: value === chosen }, text)),
  );
}

/** A logarithmic slider between two bounds: {input, get(), set(value)}. */
export function logSlider(low, high, attributes = {}) {
  const input = element("input", { type: "range", min: 0, max: 1000, step: 1, ...attributes });
  return {
    input,
    get: () => low * (high / low) ** (Number(input.value) / 1000),
    set: (value, said) => {
      const clamped = Math.min(high, Math.max(low, value));
      input.value = Math.round((1000 * Math.log(clamped / low)) / Math.log(high / low));
      input.setAttribute("aria-valuetext", said);
    },
  };
}

/** Runs one job at a time, then the newest waiting job. */
export function newestOnly(job) {
  let running = false;
  let next = null;
  return async function ask(...wanted) {
    next = wanted;
    if (running) return;
    running = true;
    try {
      while (next) {
        const now = next;
        next = null;
        await job(...now);
      }
    } finally {
      running = false;
    }
  };
}

/** A status line; screen readers read changes. */
export function statusLine() {
  const node = element("p", { class: "panel-status", role: "status" });
  return {
    node,
    say(text, bad = false) {
      node.textContent = text;
      node.classList.toggle("bad", bad);
    },
  };
}

export function download(content, name, type = "application/json") {
  const address = URL.createObjectURL(content instanceof Blob ? content : new Blob([content], { type }));
  const link = element("a", { href: address, download: name });
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(address), 60000);
}

/** Copies text from a text field to the clipboard, or selects it if the browser forbids that. */
export async function copyFrom(area, status, what) {
  area.select();
  try {
    await navigator.clipboard.writeText(area.value);
    status.say(`${what} copied.`);
  } catch {
    const done = document.execCommand && document.execCommand("copy");
    status.say(done ? `${what} copied.` : `${what} selected: copy it with Ctrl+C.`, !done);
  }
}

/** The file name of a volume without extensions. */
export function stem(volume) {
  return (volume?.name || "volume").replace(
    /\.(cvol|nii\.gz|nii|nrrd|nhdr|mha|mhd|tiff?|npy|vti|raw|dcm|mrc|vtk|h5)$/i,
    "",
  );
}

export const clamp = (value, low, high) => Math.min(high, Math.max(low, value));
