// Measurements drawn over the picture of the volume: lines that follow the camera.

import { make } from "../controls/controls.js";
import { freePlace } from "./measures.js";
import { worldOf } from "../state/camera.js";

const SIDES = 48; // of an ellipse
const NARROW = 420; // pixels of a picture: figures do not fit, numbers do

/** The lines of a measurement, each a list of places in samples. */
export function linesOf({ kind, points, box }) {
  if (!box) return [points];
  const faces = [0, 1, 2].map((a) => [box[2 * a] - 0.5, box[2 * a + 1] - 0.5]);
  const pairs = [
    [0, 1],
    [1, 2],
    [2, 0],
  ];
  if (kind === "ellipsoid") {
    const middle = faces.map(([from, to]) => (from + to) / 2);
    const radius = faces.map(([from, to]) => (to - from) / 2);
    const ellipse = ([a, b]) =>
      Array.from({ length: SIDES + 1 }, (_, i) => {
        const angle = (2 * Math.PI * i) / SIDES;
        const place = [...middle];
        place[a] += radius[a] * Math.cos(angle);
        place[b] += radius[b] * Math.sin(angle);
        return place;
      });
    const flat = pairs.filter((pair) => pair.every((a) => box[2 * a + 1] - box[2 * a] > 1));
    return (flat.length === 1 ? flat : pairs).map(ellipse);
  }
  const corner = (...ends) => ends.map((end, a) => faces[a][end]);
  return [0, 1].flatMap((z) => [
    [corner(0, 0, z), corner(1, 0, z), corner(1, 1, z), corner(0, 1, z), corner(0, 0, z)],
    ...(z ? [[0, 0], [1, 0], [1, 1], [0, 1]].map(([x, y]) => [corner(x, y, 0), corner(x, y, 1)]) : []),
  ]);
}

/** Draws into an SVG group; project: from the world to the page (camera.js). */
export function drawSpaceMarks(group, marks, volume, project, width) {
  const [parts, placed] = [[], []];
  const text = ({ x, y }) => `${x.toFixed(1)} ${y.toFixed(1)}`;
  for (const { shape, number, text: figure } of marks) {
    const words = width < NARROW ? number : figure;
    const lines = linesOf(shape).map((line) => line.map((place) => project(worldOf(volume, place))));
    const seen = lines.filter((line) => line.every(Boolean));
    if (!seen.length) continue;
    const d = seen.map((line) => `M${line.map(text).join("L")}`).join("");
    parts.push(make("svg:path", { d, class: "mark-edge" }), make("svg:path", { d, class: "mark-line" }));
    const places = seen.flat();
    if (shape.points)
      for (const { x, y } of places) parts.push(make("svg:circle", { cx: x.toFixed(1), cy: y.toFixed(1), r: 3.5, class: "mark-spot" }));
    if (!words) continue;
    const top = places.reduce((best, place) => (place.y < best.y ? place : best));
    const at =
      shape.points?.length === 3 ? places[1] : shape.points ? { x: (places[0].x + places.at(-1).x) / 2, y: (places[0].y + places.at(-1).y) / 2 } : top;
    const right = at.x > width * 0.6;
    const [x, y] = freePlace(placed, [at.x + (right ? -8 : 8), at.y - 7]);
    const anchor = { "text-anchor": right ? "end" : "start", x: x.toFixed(1), y: y.toFixed(1) };
    parts.push(make("svg:text", { ...anchor, class: "mark-text" }, words));
  }
  group.replaceChildren(...parts);
}
