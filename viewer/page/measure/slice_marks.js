// Measurements drawn over a slice, in pixels of the page.

import { shape as svg } from "../controls/panel_kit.js";
import { freePlace } from "../state/measures.js";
import { handlesOf } from "./handles.js";
import { passes, sectionOf } from "./slice_geometry.js";

const SIDES = 64; // of an ellipse
const NARROW = 200; // pixels: figures do not fit, numbers do
const LEAST_WITH_HANDLES = 32; // pixels: handles would hide a smaller region

export function createSliceMarks(plane) {
  const node = svg("svg", { class: "slice-marks marks", "aria-hidden": "true" });

  /** room: the width of the slice's area; turned: [the lowest sample is on the right, at the bottom]. */
  function draw({ marks, dims, index, turned, width, height, room }) {
    const x = (s) => width * (turned[0] ? 1 - (s + 0.5) / dims[plane.across] : (s + 0.5) / dims[plane.across]);
    const y = (s) => height * (turned[1] ? 1 - (s + 0.5) / dims[plane.down] : (s + 0.5) / dims[plane.down]);
    const at = (point) => [x(point[plane.across]), y(point[plane.down])];
    const text = ([px, py]) => px.toFixed(1) + " " + py.toFixed(1);
    const [parts, placed] = [[], []];
    const line = (d, style = "") => parts.push(svg("path", { d, class: "mark-edge" }), svg("path", { d, class: `mark-line ${style}` }));
    const label = (words, [px, py]) => {
      if (!words) return;
      const right = px > width * 0.55;
      const [left, base] = freePlace(placed, [px + (right ? -7 : 7), Math.max(13, py - 6)], words.length);
      parts.push(svg("text", { x: left, y: base, class: "mark-text", "text-anchor": right ? "end" : "start" }, words));
    };

    const spot = (place, style) => parts.push(svg("circle", { cx: at(place)[0], cy: at(place)[1], r: 3.5, class: style }));

    function drawPoints({ points }, words) {
      const lines = points.slice(1).map((to, i) => ({ from: points[i], to, how: passes(points[i], to, plane, index) }));
      for (const { from, to, how } of lines) if (how) line(`M${text(at(from))}L${text(at(to))}`, how);
      const seen = points.filter((point) => Math.abs(point[plane.axis] - index) <= 0.5);
      for (const point of seen) spot(point, "mark-spot");
      if (!seen.length && !lines.some(({ how }) => how)) return;
      const [a, b] = [at(points[0]), at(points.at(-1))];
      label(words, points.length === 3 ? at(points[1]) : [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2]);
    }

    function drawRegion(region, words) {
      const section = sectionOf(region, plane, index);
      if (!section) return;
      const [[x0, x1], [y0, y1]] = [section[0].map(x), section[1].map(y)];
      if (region.kind === "box") line(`M${text([x0, y0])}L${text([x1, y0])}L${text([x1, y1])}L${text([x0, y1])}Z`);
      else {
        const [cx, cy, rx, ry] = [(x0 + x1) / 2, (y0 + y1) / 2, (x1 - x0) / 2, (y1 - y0) / 2];
        const corners = Array.from({ length: SIDES }, (_, i) => {
          const angle = (2 * Math.PI * i) / SIDES;
          return text([cx + rx * Math.cos(angle), cy + ry * Math.sin(angle)]);
        });
        line(`M${corners.join("L")}Z`);
      }
      label(words, [(x0 + x1) / 2, Math.min(y0, y1)]);
    }

    // What a pointer can move of a region.
    function drawHandles(region) {
      const handles = handlesOf(region, plane, index);
      const places = handles.map(({ place }) => at(place));
      const lengths = [0, 1].map((i) => Math.max(...places.map((one) => one[i])) - Math.min(...places.map((one) => one[i])));
      if (Math.min(...lengths) < LEAST_WITH_HANDLES) return;
      for (const { place, kind } of handles) spot(place, kind === "middle" ? "mark-handle middle" : "mark-handle");
    }

    for (const { index: listed, shape, number, text: words } of marks) {
      (shape.box ? drawRegion : drawPoints)(shape, room < NARROW ? number : words);
      if (shape.box && listed !== undefined && sectionOf(shape, plane, index)) drawHandles(shape);
    }
    node.setAttribute("viewBox", `0 0 ${width} ${height}`);
    node.replaceChildren(...parts);
  }

  return { node, draw };
}
