// Measurements drawn over the picture of the volume: lines that follow the camera.

import { make } from "../controls/controls.js";
import { freePlace } from "../state/measures.js";
import { linesOf } from "./space_geometry.js";
import { worldOf } from "../state/camera.js";

const NARROW = 420; // pixels of a picture: figures do not fit, numbers do

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
    const [x, y] = freePlace(placed, [at.x + (right ? -8 : 8), at.y - 7], words.length);
    const anchor = { "text-anchor": right ? "end" : "start", x: x.toFixed(1), y: y.toFixed(1) };
    parts.push(make("svg:text", { ...anchor, class: "mark-text" }, words));
  }
  group.replaceChildren(...parts);
}
