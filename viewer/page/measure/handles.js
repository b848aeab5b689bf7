// Handles of measurements in slices: points, corners and sides of regions, and their middles.

import { sectionOf } from "./slice_geometry.js";

const clamp = (value, low, high) => Math.min(high, Math.max(low, value));

/** A face of a region at the nearest border of samples; it stays at least a sample from the opposite one. */
export function withFace(box, face, border, dims) {
  const next = [...box];
  const n = dims[face >> 1];
  const rounded = Math.round(border);
  next[face] = face % 2 ? clamp(rounded, box[face - 1] + 1, n) : clamp(rounded, 0, box[face + 1] - 1);
  return next;
}

/** The measurement with a point at another place. */
export function withPoint(measure, point, place, dims) {
  const inside = place.map((part, axis) => Number(clamp(part, -0.5, dims[axis] - 0.5).toFixed(2)));
  return { ...measure, points: measure.points.map((old, i) => (i === point ? inside : old)) };
}

/** The region with its middle at a place along some axes; it stays in the volume. */
function withMiddle(box, axes, place, dims) {
  const next = [...box];
  for (const axis of axes) {
    const [from, to] = [box[2 * axis], box[2 * axis + 1]];
    const shift = clamp(Math.round(place[axis] + 0.5 - (from + to) / 2), -from, dims[axis] - to);
    next[2 * axis] = from + shift;
    next[2 * axis + 1] = to + shift;
  }
  return next;
}

const pointHandles = ({ points }, plane, slice) =>
  points
    .map((place, i) => ({ place, kind: "point", move: (measure, at, dims) => withPoint(measure, i, at, dims) }))
    .filter(({ place }) => Math.abs(place[plane.axis] - slice) <= 0.5);

// The section of an ellipsoid is smaller than its middle one, by `share` along each axis: the face is where the side
// of the section is at the pointer.
function faceAt(box, face, place, share) {
  const [border, opposite] = [place[face >> 1] + 0.5, box[face ^ 1]];
  return (2 * border - opposite * (1 - share)) / (1 + share);
}

function regionHandles(region, plane, slice) {
  const section = sectionOf(region, plane, slice);
  if (!section) return [];
  const axes = [plane.across, plane.down];
  const middles = section.map(([lo, hi]) => (lo + hi) / 2);
  const share = (section[0][1] - section[0][0]) / (region.box[2 * axes[0] + 1] - region.box[2 * axes[0]]);
  const placeOf = (across, down) => {
    const place = [slice, slice, slice];
    [place[plane.across], place[plane.down]] = [across, down];
    return place;
  };
  const moving = (change) => (measure, at, dims) => ({ ...measure, box: change(measure.box, at, dims) });
  const toFace = (face) => (box, at, dims) => withFace(box, face, faceAt(box, face, at, share), dims);

  const handles = [{ place: placeOf(...middles), kind: "middle", move: moving((box, at, dims) => withMiddle(box, axes, at, dims)) }];
  for (const end of [0, 1]) {
    const faces = axes.map((axis) => 2 * axis + end);
    handles.push({ place: placeOf(section[0][end], middles[1]), kind: "side", move: moving(toFace(faces[0])) });
    handles.push({ place: placeOf(middles[0], section[1][end]), kind: "side", move: moving(toFace(faces[1])) });
  }
  if (region.kind === "box")
    for (const across of [0, 1])
      for (const down of [0, 1]) {
        const moves = [toFace(2 * axes[0] + across), toFace(2 * axes[1] + down)];
        const change = (box, at, dims) => moves.reduce((now, move) => move(now, at, dims), box);
        handles.push({ place: placeOf(section[0][across], section[1][down]), kind: "corner", move: moving(change) });
      }
  return handles;
}

/** [{place, kind: point, middle, side or corner, move(measure, place, dims): the measurement after it}, ...] */
export const handlesOf = (shape, plane, slice) => (shape.box ? regionHandles : pointHandles)(shape, plane, slice);
