// The levels of bricks (bricks.js) that a picture or a slice needs.

import { directions, pixelLength, worldOf } from "../../viewer/page/state/camera.js";
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

const cornersOf = (first, last) =>
  Array.from({ length: 8 }, (_, k) => [0, 1, 2].map((a) => ((k >> a) & 1 ? last[a] + 0.5 : first[a] - 0.5)));

// A function of a point in world lengths: its place in pixels from the top left of the picture, and the length of a
// pixel there; null behind the eye. It is projector() of camera.js with the length.
function projection({ camera, mirror, width, height }, volume) {
  const { eye, right, up } = directions(camera, mirror);
  const pixel = pixelLength(camera, volume, height);
  const distance = camera.fov > 0 ? (pixel * height) / 2 / Math.tan((camera.fov / 360) * Math.PI) : Infinity;
  return (world) => {
    const p = world.map((at, a) => at - camera.look_at[a]);
    const along = (axis) => p[0] * axis[0] + p[1] * axis[1] + p[2] * axis[2];
    const share = distance === Infinity ? 1 : 1 - along(eye) / distance;
    if (share <= 0) return null;
    const length = pixel * share;
    return { x: width / 2 + along(right) / length, y: height / 2 - along(up) / length, pixel: length };
  };
}

// Of a view (doc/viewer-api.md) with width and height: Uint8Array, COARSEST for a brick that is not in the picture.
export function levelsOfView(bricks, volume, view) {
  const { width, height, mode, clip } = view;
  const levels = new Uint8Array(bricks.count).fill(COARSEST);
  const project = projection(view, volume);
  const box = clip?.box ?? [];
  eachBrick(bricks, (b, first, last) => {
    if ([0, 1, 2].some((a) => last[a] < (box[2 * a] ?? -Infinity) || first[a] > (box[2 * a + 1] ?? Infinity))) return;
    const seen = cornersOf(first, last).map((corner) => project(worldOf(volume, corner)));
    if (seen.every((at) => at === null)) return;
    if (seen.includes(null)) levels[b] = 0; // the eye is in it, or next to it
    else {
      const [xs, ys] = [seen.map(({ x }) => x), seen.map(({ y }) => y)];
      if (Math.max(...xs) < 0 || Math.min(...xs) > width || Math.max(...ys) < 0 || Math.min(...ys) > height) return;
      levels[b] = mode === "iso" ? 0 : levelFor(Math.min(...seen.map(({ pixel }) => pixel)), volume);
    }
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
