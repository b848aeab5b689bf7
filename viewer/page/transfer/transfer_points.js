// Functions on the points of a transfer function, [value, r, g, b, opacity], sorted by value; they return new lists.

import { colourAt, stopCount } from "./colour_maps.js";

/** The editor shows square roots of opacities, because translucent looks need values below 0.1. */
export const heightOf = (opacity) => Math.sqrt(Math.max(0, opacity));
export const opacityAt = (height) => Math.min(1, Math.max(0, height)) ** 2;

const mix = (a, b, part) => a.map((value, k) => value + part * (b[k] - value));

/** The point of the function at a value. */
export function pointAt(points, value) {
  if (value <= points[0][0]) return [value, ...points[0].slice(1)];
  for (let i = 1; i < points.length; i++) {
    const [a, b] = [points[i - 1], points[i]];
    if (value <= b[0]) return [value, ...mix(a, b, b[0] > a[0] ? (value - a[0]) / (b[0] - a[0]) : 1).slice(1)];
  }
  return [value, ...points[points.length - 1].slice(1)];
}

/** Adds a point: {points, index}. */
export function insert(points, point) {
  let index = points.findIndex((other) => other[0] > point[0]);
  if (index < 0) index = points.length;
  return { points: [...points.slice(0, index), point, ...points.slice(index)], index };
}

export const without = (points, index) => points.filter((_, i) => i !== index);

/** Moves one point, between its neighbours. */
export function moved(points, index, value, opacity) {
  const low = index > 0 ? points[index - 1][0] : -Infinity;
  const high = index < points.length - 1 ? points[index + 1][0] : Infinity;
  const point = [...points[index]];
  point[0] = Math.min(high, Math.max(low, value));
  point[4] = Math.min(1, Math.max(0, opacity));
  return points.map((other, i) => (i === index ? point : other));
}

export const recoloured = (points, index, colour) =>
  points.map((point, i) => (i === index ? [point[0], ...colour, point[4]] : point));

/** First and last value. */
export const extent = (points) => [points[0][0], points[points.length - 1][0]];

/** Moves all points so that the first and the last have these values. */
export function stretched(points, low, high) {
  const [from, to] = extent(points);
  const part = (value) => (to > from ? (value - from) / (to - from) : 0.5);
  return points.map((point) => [low + part(point[0]) * (high - low), ...point.slice(1)]);
}

/** The range of visible values, over which a colour map is spread. */
function seen(points) {
  let first = points.findIndex((point) => point[4] > 0);
  if (first < 0) return extent(points);
  let last = points.length - 1;
  while (last > first && points[last][4] === 0) last--;
  first = Math.max(0, first - 1);
  last = Math.min(points.length - 1, points[last][4] > 0 && last < points.length - 1 ? last + 1 : last);
  return [points[first][0], points[last][0]];
}

/** Applies the colours of a map and keeps the opacities; adds points if the map needs them. */
export function coloured(points, name) {
  const [low, high] = seen(points);
  let result = points;
  const count = stopCount(name);
  for (let i = 1; i < count - 1 && high > low; i++) {
    const value = low + (i / (count - 1)) * (high - low);
    const near = result.some((point) => Math.abs(point[0] - value) < 0.04 * (high - low));
    if (!near) result = insert(result, pointAt(result, value)).points;
  }
  return result.map((point) => [point[0], ...colourAt(name, (point[0] - low) / (high - low || 1)), point[4]]);
}

function farthest(points, from, to) {
  let index = -1;
  let worst = 0;
  for (let i = from + 1; i < to; i++) {
    const line = pointAt([points[from], points[to]], points[i][0]);
    const off = Math.max(
      Math.abs(heightOf(line[4]) - heightOf(points[i][4])) / 0.02,
      ...[1, 2, 3].map((k) => Math.abs(line[k] - points[i][k]) / 0.04),
    );
    if (off > worst) [worst, index] = [off, i];
  }
  return worst > 1 ? index : -1;
}

/** Reduces the points, with nearly the same function (Douglas and Peucker), for editing by hand. */
export function simplified(points) {
  if (points.length <= 12) return points;
  const kept = new Set([0, points.length - 1]);
  const spans = [[0, points.length - 1]];
  while (spans.length) {
    const [from, to] = spans.pop();
    const index = farthest(points, from, to);
    if (index < 0) continue;
    kept.add(index);
    spans.push([from, index], [index, to]);
  }
  return points.filter((_, i) => kept.has(i));
}
