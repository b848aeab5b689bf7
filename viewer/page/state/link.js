// Links: the part after # has the camera, and the fields that differ from a newly opened page.
//
//   #camera.azimuth=30&transfer="bone"   fields of the view; .page.sample=[1,2,3] fields of the page

import { areChannels } from "./channels.js";
import { areOverlays } from "./overlays.js";
import { DEFAULT_VIEW } from "./default_view.js";
import { same } from "./view.js";

// Fields of state.page in the link; panels add theirs by carryInLink.
const carried = new Map();

// fits(names, value): returns 1 if the value is valid for the field.
export function carryInLink(name, initial, fits = () => true) {
  carried.set(name, { initial, fits });
}

const numbers = (value, count) => Array.isArray(value) && value.length === count && value.every(Number.isFinite);
const layouts = ["single", "slices", "compare"];
carryInLink("layout", "single", (names, value) => !names.length && layouts.includes(value));
carryInLink("sample", null, (names, value) => !names.length && (value === null || numbers(value, 3)));

const isPlain = (value) => typeof value === "object" && value !== null && !Array.isArray(value);

function* differences(value, initial, path) {
  if (value === undefined || same(value, initial)) return;
  if (isPlain(value) && isPlain(initial))
    for (const key of Object.keys(value)) yield* differences(value[key], initial[key], [...path, key]);
  else yield [path.join("."), value];
}

// Escapes only characters that a URL must not have, so that it stays readable.
const escaped = (text) =>
  encodeURIComponent(text).replace(/%(?:2C|5B|5D|7B|7D|3A|22)/g, (code) =>
    code === "%22" ? "'" : decodeURIComponent(code),
  );

function plainText(value) {
  return JSON.stringify(value).replaceAll("'", "\\u0027");
}

// Fields that the first view of a volume sets otherwise (app.js) are in its link, whatever they are.
const OF_VOLUMES = { ...DEFAULT_VIEW, camera: {}, light: { ...DEFAULT_VIEW.light, on: null } };

export function hashOf({ view, page }) {
  const parts = [...differences(view, view.volume === null ? DEFAULT_VIEW : OF_VOLUMES, [])];
  for (const [name, { initial }] of carried) parts.push(...differences(page[name], initial, ["", "page", name]));
  return parts.map(([path, value]) => `${path}=${escaped(plainText(value))}`).join("&");
}

export function linkOf(state) {
  const address = new URL(location.href);
  address.hash = hashOf(state);
  return address.href;
}

function put(target, path, value) {
  const last = path.pop();
  for (const key of path)
    target = Object.hasOwn(target, key) && isPlain(target[key]) ? target[key] : (target[key] = {});
  target[last] = value;
}

// Fields whose type may differ from that of the default.
const kinds = {
  volume: (value) => typeof value === "string",
  time: (value) => Number.isInteger(value) && value >= 0,
  channels: areChannels,
  overlays: areOverlays,
  transfer: (value) => typeof value === "string" || (Array.isArray(value) && value.every((point) => numbers(point, 5))),
  window: (value) => value === null || numbers(value, 2),
  "surface.value": Number.isFinite,
  "clip.box": (value) =>
    value === null ||
    (Array.isArray(value) && value.length === 6 && value.every((face) => face === null || Number.isFinite(face))),
  "clip.planes": (value) => Array.isArray(value) && value.every((plane) => numbers(plane, 4)),
};

function fits(value, initial) {
  if (Array.isArray(initial)) return numbers(value, initial.length);
  return typeof initial === "number" ? Number.isFinite(value) : typeof value === typeof initial;
}

// Returns 1 if the view has this field and the value is valid.
function known(path, value) {
  const [where, ...names] = path;
  if (where === "page") return carried.get(names[0])?.fits(names.slice(1), value) ?? false;
  const kind = kinds[names.join(".")];
  if (kind) return kind(value);
  let initial = DEFAULT_VIEW;
  for (const name of names) {
    if (!isPlain(initial) || !Object.hasOwn(initial, name)) return false;
    initial = initial[name];
  }
  return !isPlain(initial) && fits(value, initial);
}

// The patch for the store from the part of a URL after #; unknown fields are ignored.
export function patchOf(hash) {
  const patch = {};
  for (const part of hash.replace(/^#/, "").split("&")) {
    const cut = part.indexOf("=");
    if (cut < 0) continue;
    try {
      const value = JSON.parse(decodeURIComponent(part.slice(cut + 1)).replaceAll("'", '"'));
      const words = part.slice(0, cut).split(".");
      const path = words[0] === "" ? words.slice(1) : ["view", ...words];
      if (path.includes("__proto__") || !known(path, value)) continue;
      put(patch, path, value);
    } catch {
      // ignore an invalid part, use the others
    }
  }
  return patch;
}
