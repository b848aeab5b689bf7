// Measurements as the state has them: {kind, of, points} or {kind, of, box}. Places are in samples; `of` is the volume of
// the file, which its copies and channels share. Their figures come from the program (api.measure).

import { same } from "./view.js";

export const KINDS = {
  distance: { name: "Distance", points: 2, key: "d", how: "two points" },
  angle: { name: "Angle", points: 3, key: "a", how: "three points, the vertex second" },
  box: { name: "Box", points: 2, key: "b", how: "two opposite corners" },
  ellipsoid: { name: "Ellipse", points: 2, key: "e", how: "two opposite corners of its box" },
};
export const MOST = 200; // measurements of a state

export const isRegion = ({ kind }) => kind === "box" || kind === "ellipsoid";

/** The id of the volume that a copy or a channel belongs to. */
export function rootOf(volume, get) {
  const own = volume?.parent ? (get(volume.parent) ?? volume) : volume;
  return own?.channel?.first ?? own?.id ?? null;
}

const numbers = (value, count) => Array.isArray(value) && value.length === count && value.every(Number.isFinite);

function isMeasure(one) {
  if (!one || typeof one !== "object" || !Object.hasOwn(KINDS, one.kind) || typeof one.of !== "string") return false;
  if (isRegion(one)) return numbers(one.box, 6) && one.box.every(Number.isInteger);
  const { points } = one;
  return Array.isArray(points) && points.length === KINDS[one.kind].points && points.every((point) => numbers(point, 3));
}

export const areMeasures = (value) => Array.isArray(value) && value.length <= MOST && value.every(isMeasure);

const clamp = (value, low, high) => Math.min(high, Math.max(low, value));
const sampleOf = (place, n) => clamp(Math.round(place), 0, n - 1);

/** The list with more measurements, of a volume that has another id now; none is there twice. */
export function joinedMeasures(list, more, of) {
  const now = more.map((one) => ({ ...one, of }));
  return [...list, ...now.filter((one) => !list.some((other) => same(one, other)))].slice(0, MOST);
}

/** The box of the samples at two corners, with the ends behind the last samples. */
export const boxOf = ([a, b], dims) =>
  dims.flatMap((n, axis) => {
    const ends = [a, b].map((point) => sampleOf(point[axis], n));
    return [Math.min(...ends), Math.max(...ends) + 1];
  });

export function makeMeasure(kind, of, points, dims) {
  if (isRegion({ kind })) return { kind, of, box: boxOf(points, dims) };
  const inside = (point) => point.map((place, axis) => Number(clamp(place, -0.5, dims[axis] - 0.5).toFixed(2)));
  return { kind, of, points: points.map(inside) };
}

/** The middle of a measurement, as a sample. */
export function middleOf(measure, dims) {
  const { box, points } = measure;
  const middle = box
    ? [0, 1, 2].map((a) => (box[2 * a] + box[2 * a + 1] - 1) / 2)
    : [0, 1, 2].map((a) => points.reduce((total, point) => total + point[a], 0) / points.length);
  return middle.map((place, a) => sampleOf(place, dims[a]));
}

/** The body of the request for its figures. */
export const requestOf = ({ kind, points, box }, time) =>
  isRegion({ kind }) ? { kind, box, ...(time && { time }) } : { kind, points };

// ---- text ---------------------------------------------------------------------------------------------

const minus = (text) => text.replaceAll("-", "\u2212");
// With so many digits, more if values of this spread lie far from 0.
function plain(value, spread = 0, digits = 7) {
  const more = spread > 0 ? Math.floor(Math.log10(Math.abs(value) / spread)) : 0;
  return String(Number(value.toPrecision(clamp(digits + more, digits, 15))));
}

// Two digits, rounded up: it stays a bound.
function roundedUp(error) {
  const power = 10 ** (Math.floor(Math.log10(error)) - 1);
  return Number((Math.ceil(error / power - 1e-9) * power).toPrecision(2));
}

/** "93.21 ± 0.12": with one digit more than the bound has. */
export function figureText(value, error, spread) {
  if (!Number.isFinite(value)) return "none";
  if (!Number.isFinite(error)) return minus(plain(value, spread));
  if (error === 0) return `${minus(plain(value, spread))} \u00b1 0`;
  const bound = roundedUp(error);
  const digits = clamp(2 - Math.floor(Math.log10(bound)), 0, 12);
  return `${minus(String(Number(value.toFixed(digits))))} \u00b1 ${plain(bound)}`;
}

const nameOfUnit = (unit) => (unit === "um" ? "\u00b5m" : unit);
const assumed = ({ unit, unit_assumed: is }) => (is ? " (unit assumed)" : unit ? "" : " (no unit in the file)");

export const lengthText = (answer) =>
  `${Number(answer.length.toPrecision(5))} ${nameOfUnit(answer.unit)}`.trimEnd() + assumed(answer);

export function volumeText(answer) {
  const size = Number(answer.volume.toPrecision(5));
  if (!answer.unit) return `${size}${assumed(answer)}`;
  const cubed = `${size} ${nameOfUnit(answer.unit)}\u00b3`;
  return (answer.unit === "mm" ? `${Number((answer.volume / 1000).toPrecision(5))} ml, ${cubed}` : cubed) + assumed(answer);
}

/** The figure that stands next to a measurement in pictures. */
export function shortText(answer) {
  if (answer.kind === "distance") return `${Number(answer.length.toPrecision(4))} ${nameOfUnit(answer.unit)}`.trimEnd();
  if (answer.kind === "angle") return `${Number(answer.degrees.toFixed(1))}\u00b0`;
  if (!Number.isFinite(answer.mean)) return "";
  const { mean, mean_error: error } = answer;
  const figure = error > 0 ? figureText(mean, error) : minus(plain(mean, answer.max - answer.min, 4));
  return `mean ${figure} ${answer.value_unit}`.trimEnd();
}

/** [[name, text], ...] for the list. */
export function rowsOf(answer) {
  if (answer.kind === "distance") return [["Length", lengthText(answer)]];
  if (answer.kind === "angle") return [["Angle", `${Number(answer.degrees.toFixed(2))}\u00b0`]];
  const spread = answer.max - answer.min;
  const value = (name) => `${figureText(answer[name], answer[`${name}_error`], spread)} ${answer.value_unit}`.trimEnd();
  return [
    ["Mean", value("mean")],
    ["Std. deviation", value("standard_deviation")],
    ["Minimum", value("min")],
    ["Maximum", value("max")],
    ["Samples", String(answer.samples)],
    ["Volume", volumeText(answer)],
  ];
}

const [LETTER_WIDTH, LINE_HEIGHT] = [7.5, 14]; // pixels of the page

/** Moves a label of so many letters below those that are placed; adds it to them. */
export function freePlace(placed, [x, y], letters) {
  const width = LETTER_WIDTH * letters;
  let free = y;
  while (placed.some((one) => Math.abs(one.x - x) < Math.max(width, one.width) && Math.abs(one.y - free) < LINE_HEIGHT)) free += LINE_HEIGHT;
  placed.push({ x, y: free, width });
  return [x, free];
}

const FIGURES = ["length", "degrees", "unit", "unit_assumed", "samples", "volume", "mean", "mean_error",
  "standard_deviation", "standard_deviation_error", "min", "min_error", "max", "max_error", "value_unit"];
const PLACES = ["x0", "y0", "z0", "x1", "y1", "z1", "x2", "y2", "z2"];

const cell = (value) => {
  const text = value === null || value === undefined ? "" : String(value);
  return /[",\n\r]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
};

/** A table of all measurements: [{number, measure, answer (or null)}]. A region has its first and last sample. */
export function csvOf(items, file, time) {
  const lines = items.map(({ number, measure, answer }) => {
    const { box, points } = measure;
    const places = box ? [...[0, 2, 4].map((i) => box[i]), ...[1, 3, 5].map((i) => box[i] - 1)] : points.flat();
    return [number, measure.kind, file, isRegion(measure) ? time : "", ...PLACES.map((_, i) => places[i]), ...FIGURES.map((name) => answer?.[name])];
  });
  return [["number", "kind", "file", "time", ...PLACES, ...FIGURES], ...lines].map((line) => `${line.map(cell).join(",")}\n`).join("");
}
