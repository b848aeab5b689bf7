// The state of the page, and its undo steps.
//
//   state.view   the view of doc/viewer-api.md, without width and height (view.js has the defaults)
//   state.page   settings that are not part of a picture:
//       layout   "single", "slices" (three slices next to the view) or "compare" (two views)
//       sample   [x, y, z], fractions: the position of the linked cross-hair, or null
//       open     {section: true}: the open sections of the panel
//       motion   {fps, size}: targets during motion
//       marks    show orientation cube and scale bar; turning: degrees per second of the turntable
//       measures {list, shown}: see state/measures.js
//       bookmarks {list}: see state/bookmarks.js
//       playing  times per second of a series that is played
//   Each panel keeps its fields under its own name in state.page.
//
// States are never changed, only replaced: equal parts of two states are the same object.

import { DEFAULT_VIEW } from "./default_view.js";
import { same } from "./view.js";

const STEPS_MAX = 200;

const isPlain = (value) => typeof value === "object" && value !== null && !Array.isArray(value);

// Returns `base` with the fields of `patch`; returns `base` itself if nothing differs.
export function merge(base, patch) {
  let out = base;
  for (const [key, value] of Object.entries(patch)) {
    const now = base[key];
    let next = value;
    if (isPlain(now) && isPlain(value)) next = merge(now, value);
    else if (same(now, value)) next = now;
    if (next === now && key in base) continue;
    if (out === base) out = { ...base };
    out[key] = next;
  }
  return out;
}

export function createStore(first) {
  let state = first;
  let past = [];
  let future = [];
  let gestureStart = null; // the state before a gesture that has not ended
  const listeners = new Set();

  function replace(next, live) {
    const previous = state;
    state = next;
    for (const listener of [...listeners]) listener(state, previous, { live });
  }

  function step(from, to) {
    if (!from.length) return false;
    gestureStart = null;
    to.push(state);
    replace(from.pop(), false);
    return true;
  }

  return {
    get state() {
      return state;
    },
    get canUndo() {
      return past.length > 0;
    },
    get canRedo() {
      return future.length > 0;
    },
    // Merges `patch` into the state. `live`: part of a gesture. The next set() without `live` ends the gesture,
    // which is one undo step. `undo: false`: the change is not an undo step and is also applied to all saved
    // states.
    set(patch, { undo = true, live = false } = {}) {
      const next = merge(state, patch);
      if (!undo) {
        const quietly = (other) => merge(other, patch);
        past = past.map(quietly);
        future = future.map(quietly);
        if (gestureStart) gestureStart = quietly(gestureStart);
      } else if (live) {
        gestureStart ??= state;
      } else {
        const start = gestureStart ?? state;
        gestureStart = null;
        if (!same(start, next)) {
          past.push(start);
          if (past.length > STEPS_MAX) past.shift();
          future = [];
        }
      }
      replace(next, live);
    },
    // Applies fn to the state and all saved states; for changes of representation only.
    rewrite(fn) {
      past = past.map(fn);
      future = future.map(fn);
      if (gestureStart) gestureStart = fn(gestureStart);
      replace(fn(state), false);
    },
    // Calls fn(state, previous, {live}) after each set, undo and redo; returns a function that ends this.
    subscribe(fn) {
      listeners.add(fn);
      return () => listeners.delete(fn);
    },
    undo: () => step(past, future),
    redo: () => step(future, past),
  };
}

export const store = createStore({
  view: DEFAULT_VIEW,
  page: {
    layout: "single",
    sample: null,
    open: {},
    motion: { fps: 30, size: "auto" },
    marks: true,
    turning: 24,
    playing: 5,
    measures: { list: [], shown: true },
    bookmarks: { list: [] },
  },
});
