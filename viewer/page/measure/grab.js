// Points and corners of measurements that a pointer can move in a slice.

import { store } from "../state/store.js";
import { sectionOf } from "./slice_geometry.js";

const REACH = 9; // pixels

/**
 * The nearest point or corner within reach: {index (in the state), point} or {index, faces: [across, down]}, or null.
 * marks: measure/shown.js; toPage([x, y, z]): pixels; at: the pointer.
 */
export function grabAt(marks, plane, slice, toPage, at) {
  let best = null;
  let nearest = REACH;
  const offer = (place, found) => {
    const [x, y] = toPage(place);
    const apart = Math.hypot(x - at[0], y - at[1]);
    if (apart > nearest) return;
    [best, nearest] = [found, apart];
  };
  for (const { index, shape } of marks) {
    if (index === undefined) continue; // the unfinished one
    if (shape.points)
      shape.points.forEach((place, point) => Math.abs(place[plane.axis] - slice) <= 0.5 && offer(place, { index, point }));
    else if (shape.kind === "box" && sectionOf(shape, plane, slice))
      for (const across of [0, 1])
        for (const down of [0, 1]) {
          const place = [0, 0, 0];
          place[plane.across] = shape.box[2 * plane.across + across] - 0.5;
          place[plane.down] = shape.box[2 * plane.down + down] - 0.5;
          offer(place, { index, faces: [2 * plane.across + across, 2 * plane.down + down] });
        }
  }
  return best;
}

/** A face of a region at the nearest border of samples; it stays at least a sample from the opposite one. */
export function withFace(box, face, border, dims) {
  const next = [...box];
  const n = dims[face >> 1];
  const rounded = Math.round(border);
  next[face] = face % 2 ? Math.min(n, Math.max(box[face - 1] + 1, rounded)) : Math.max(0, Math.min(box[face + 1] - 1, rounded));
  return next;
}

/** The measurement with a point at another place. */
export function withPoint(measure, point, place, dims) {
  const inside = place.map((part, axis) => Number(Math.min(dims[axis] - 0.5, Math.max(-0.5, part)).toFixed(2)));
  return { ...measure, points: measure.points.map((old, i) => (i === point ? inside : old)) };
}

export function replaceMeasure(index, measure, live = false) {
  const list = store.state.page.measures.list.map((one, i) => (i === index ? measure : one));
  store.set({ page: { measures: { list } } }, { live });
}

/** Moves what was grabbed to a place in samples. */
export function moveGrabbed({ index, point, faces }, place, dims) {
  const measure = store.state.page.measures.list[index];
  if (!measure) return;
  if (faces) {
    const box = faces.reduce((now, face) => withFace(now, face, place[face >> 1] + 0.5, dims), measure.box);
    replaceMeasure(index, { ...measure, box }, true);
  } else {
    replaceMeasure(index, withPoint(measure, point, place, dims), true);
  }
}
