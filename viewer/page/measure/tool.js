// The tool that places the points of a measurement, in slices and on the drawn surface: one for the page.

import { KINDS } from "../state/measures.js";

const listeners = new Set();
let kind = null; // null: no tool is chosen
let points = []; // placed so far
let pointed = null; // where the next one would be placed
let finish = () => {};

const changed = () => listeners.forEach((listener) => listener());

export const tool = {
  get kind() {
    return kind;
  },
  /** The points of the unfinished measurement, with the one under the pointer. */
  get points() {
    return pointed && points.length ? [...points, pointed] : points;
  },
  get placed() {
    return points.length;
  },
  /** Chooses a kind; the same again, or null: none. */
  choose(next) {
    kind = next === kind ? null : next;
    [points, pointed] = [[], null];
    changed();
  },
  place(point) {
    if (!kind) return;
    points = [...points, point];
    pointed = null;
    if (points.length === KINDS[kind].points) {
      const all = points;
      points = [];
      finish(kind, all);
    }
    changed();
  },
  point(place) {
    if (!kind || !points.length) return;
    pointed = place;
    changed();
  },
  /** Drops the points of an unfinished measurement, else the tool; false: there was none. */
  escape() {
    if (!kind) return false;
    if (points.length) [points, pointed] = [[], null];
    else kind = null;
    changed();
    return true;
  },
  /** Calls fn(kind, points) with each finished measurement. */
  onFinish: (fn) => (finish = fn),
  subscribe(fn) {
    listeners.add(fn);
    return () => listeners.delete(fn);
  },
};
