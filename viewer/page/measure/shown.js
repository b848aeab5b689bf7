// The measurements of the current volume with their figures, which are asked for when they are needed.

import { api } from "../state/api.js";
import { boxOf, isRegion, requestOf, rootOf, shortText } from "../state/measures.js";
import { store } from "../state/store.js";
import { tool } from "./tool.js";
import { volumes } from "../state/volumes.js";

const KEPT = 500; // answers

const answers = new Map(); // key: {answer}, {error} or {} while it is asked for
const listeners = new Set();

/** Calls fn() when a figure has arrived. */
export function onFigures(fn) {
  listeners.add(fn);
  return () => listeners.delete(fn);
}

let held = false;

/** While a measurement moves with the pointer, nothing is asked for. */
export function holdFigures(on) {
  held = on;
  if (!on) listeners.forEach((listener) => listener());
}

function figuresOf(measure, volume, time) {
  const body = requestOf(measure, time);
  const key = `${volume.id} ${volume.partial ? volume.arrived_level : ""} ${volume.arrived_part ?? 0} ${JSON.stringify(body)}`;
  const known = answers.get(key);
  if (known || held) return known ?? {};
  const figures = {};
  if (answers.size >= KEPT) answers.delete(answers.keys().next().value);
  answers.set(key, figures);
  api
    .measure(volume.id, body)
    .then(
      (answer) => Object.assign(figures, { answer }),
      (error) => {
        Object.assign(figures, { error: error.message });
        if (!error.status) answers.delete(key); // the program does not answer: ask again
      },
    )
    .then(() => listeners.forEach((listener) => listener()));
  return figures;
}

export const currentRoot = () => rootOf(volumes.current(), volumes.get);

/** [{number, index (in the state), measure, answer, error}] of the current volume. */
export function shownMeasures() {
  const volume = volumes.current();
  if (volume?.state !== "ready") return [];
  const root = currentRoot();
  return store.state.page.measures.list
    .map((measure, index) => ({ measure, index }))
    .filter(({ measure }) => measure.of === root)
    .map(({ measure, index }, i) => ({ number: i + 1, index, measure, ...figuresOf(measure, volume, store.state.view.time) }));
}

/** What pictures draw: [{index (in the state), shape (a measurement), number, text}], the unfinished one last. */
export function marksToDraw() {
  const { shown } = store.state.page.measures;
  const marks = (shown ? shownMeasures() : []).map(({ number, index, measure, answer }) => ({
    index,
    shape: measure,
    number: String(number),
    text: answer ? `${number}: ${shortText(answer)}` : String(number),
  }));
  const { dims } = volumes.current() ?? {};
  if (dims && tool.placed) marks.push({ shape: unfinished(dims), number: "", text: "" });
  return marks;
}

function unfinished(dims) {
  const { kind, points } = tool;
  if (!isRegion({ kind })) return { kind, points };
  return { kind, box: boxOf([points[0], points.at(-1)], dims) };
}
