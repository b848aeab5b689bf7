// The levels of bricks (bricks.js) that a picture or a slice needs.

import { directions, dot, pixelLength, worldOf } from "../../viewer/page/state/camera.js";
import { COARSEST } from "./bricks.js";

const SAMPLES_PER_PIXEL = 2.86; // that make level 1 almost as good as level 0: cvol_render_choose_file_level

// Calls fn(b, first, last): the first and the last sample of each brick that it changes.
function eachBrick({ grid, sides, dims, reach, count }, fn) {
  for (let b = 0; b < count; b++) {
    const place = [b % grid[0], Math.floor(b / grid[0]) % grid[1], Math.floor(b / grid[0] / grid[1])];
    const first = place.map((k, a) => Math.max(0, k * sides[a] - reach));
    const last = place.map((k, a) => Math.min(dims[a] - 1, (k + 1) * sides[a] - 1 + reach));
    fn(b, first, last);
  }
}

// The level at which samples are no larger than pixels of this length allow. volume: a VOLUME of doc/viewer-api.md.
function levelFor(pixel, { spacing }) {
  const samples = pixel / Math.max(...spacing);
  return Math.min(COARSEST, Math.max(0, 1 + Math.floor(Math.log2(samples / SAMPLES_PER_PIXEL))));
}

// The least and the largest of the places at which a line from `from` to `to`, in world lengths from the axis of the view,
// may be seen: in pixels of these lengths at its near and its far end.
const spanOf = (from, to, near, far) => [Math.min(from / near, from / far), Math.max(to / near, to / far)];

// Of a view (doc/viewer-api.md) with width and height: Uint8Array, COARSEST for a brick that is not in the picture.
// A brick is seen as the box around it that is parallel to the picture.
export function levelsOfView(bricks, volume, { camera, mirror, width, height, mode, clip }) {
  const levels = new Uint8Array(bricks.count).fill(COARSEST);
  const { eye, right, up } = directions(camera, mirror);
  const pixel = pixelLength(camera, volume, height);
  const distance = camera.fov > 0 ? (pixel * height) / 2 / Math.tan((camera.fov / 360) * Math.PI) : Infinity;
  const box = clip?.box ?? [];
  eachBrick(bricks, (b, first, last) => {
    if ([0, 1, 2].some((a) => last[a] < (box[2 * a] ?? -Infinity) || first[a] > (box[2 * a + 1] ?? Infinity))) return;
    const centre = worldOf(volume, first.map((at, a) => (at + last[a]) / 2)).map((at, a) => at - camera.look_at[a]);
    const half = first.map((at, a) => ((last[a] - at + 1) / 2) * volume.spacing[a]);
    const reach = (axis) => half.reduce((sum, length, a) => sum + length * Math.abs(axis[a]), 0);
    const [depth, deep] = [dot(centre, eye), reach(eye)];
    const [near, far] = [depth + deep, depth - deep].map((at) => pixel * (1 - at / distance));
    if (far <= 0) return; // behind the eye
    if (near <= 0) {
      levels[b] = 0;
      return;
    }
    const isSeen = [[right, width], [up, height]].every(([axis, size]) => {
      const [at, wide] = [dot(centre, axis), reach(axis)];
      const [least, most] = spanOf(at - wide, at + wide, near, far);
      return most >= -size / 2 && least <= size / 2;
    });
    if (isSeen) levels[b] = mode === "iso" ? 0 : levelFor(near, volume);
  });
  return levels;
}

// Of slice `index` across an axis: 0, 1 or 2. Slices have a pixel for each sample.
export function levelsOfSlice(bricks, axis, index) {
  const levels = new Uint8Array(bricks.count).fill(COARSEST);
  eachBrick(bricks, (b, first, last) => {
    if (index >= first[axis] && index <= last[axis]) levels[b] = 0;
  });
  return levels;
}
