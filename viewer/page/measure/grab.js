// Handles of measurements that a pointer moves in a slice.

import { store } from "../state/store.js";
import { handlesOf } from "./handles.js";

/**
 * The nearest handle within `reach` pixels: {index (in the state), move (handles.js)}, or null.
 * marks: measure/shown.js; toPage([x, y, z]): pixels; at: the pointer.
 */
export function grabAt(marks, plane, slice, toPage, at, reach) {
  let best = null;
  let nearest = reach;
  for (const { index, shape } of marks) {
    if (index === undefined) continue; // the unfinished one
    for (const { place, move } of handlesOf(shape, plane, slice)) {
      const [x, y] = toPage(place);
      const apart = Math.hypot(x - at[0], y - at[1]);
      if (apart <= nearest) [best, nearest] = [{ index, move }, apart];
    }
  }
  return best;
}

export function replaceMeasure(index, measure, live = false) {
  const list = store.state.page.measures.list.map((one, i) => (i === index ? measure : one));
  store.set({ page: { measures: { list } } }, { live });
}

/** Moves what was grabbed to a place in samples. */
export function moveGrabbed({ index, move }, place, dims) {
  const measure = store.state.page.measures.list[index];
  if (measure) replaceMeasure(index, move(measure, place, dims), true);
}
