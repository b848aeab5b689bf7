// The page's one state, and the steps by which it can be taken back.
//
//   state.view   the view of doc/viewer-api.md, all its fields but width and height (view.js has the defaults)
//   state.page   what is not of a picture:
//       layout   "single", "slices" (three slices beside the view) or "compare" (two views): what the stage shows
//       sample   [x, y, z], fractions: the place of the linked cross-hair, or null
//       open     {section: true}: which sections of the panel are open
//       motion   {fps, size}: what is aimed for while something moves
//       marks    whether orientation cube and scale bar are shown; turning: the turntable's degrees a second
//   Panels keep what is theirs under a name of their own in state.page.
//
// States are never changed, only replaced: what is the same in two states is the same object.

import { DEFAULT_VIEW, same } from "./view.js";

const STEPS_MAX = 200;

const isPlain = (value) => typeof value === "object" && value !== null && !Array.isArray(value);

// `base` with what `patch` says; `base` itself if that is nothing new.
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
    // Merges `patch` into the state. `live`: in the midst of a gesture, which the next set without it ends, all of
    // it being one step. Without `undo` the change is not a step, and no step takes it back.
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
    // Makes all states, those of steps too, what fn makes of each: for what is no change but another way to say it.
    rewrite(fn) {
      past = past.map(fn);
      future = future.map(fn);
      if (gestureStart) gestureStart = fn(gestureStart);
      replace(fn(state), false);
    },
    // fn(state, previous, {live}), after each set, undo and redo; returns what ends it.
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
  },
});
