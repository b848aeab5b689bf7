// Where slices cut measurements.

/** The part of a region in the slice `index`: [[lo, hi] across, [lo, hi] down] faces in samples, or null. */
export function sectionOf({ kind, box }, plane, index) {
  const ends = (axis) => [box[2 * axis], box[2 * axis + 1]];
  const [from, to] = ends(plane.axis);
  if (index < from || index >= to) return null;
  const along = (2 * index + 1 - from - to) / (to - from);
  const share = kind === "ellipsoid" ? Math.sqrt(Math.max(0, 1 - along * along)) : 1;
  return [plane.across, plane.down].map((axis) => {
    const [lo, hi] = ends(axis).map((end) => end - 0.5);
    const middle = (lo + hi) / 2;
    return [middle - share * (middle - lo), middle + share * (hi - middle)];
  });
}

/** How a segment lies to a slice: "in" it, "through" it, or null. */
export function passes(a, b, plane, index) {
  const [from, to] = [a, b].map((point) => point[plane.axis] - index);
  if (Math.abs(from) <= 0.5 && Math.abs(to) <= 0.5) return "in";
  return Math.min(from, to) <= 0.5 && Math.max(from, to) >= -0.5 ? "through" : null;
}
