// Overlays of the picture: cross-hair, clip box and plane with handles, scale bar. They use the camera of the visible
// picture, so that they move with it.

import { diagonal, pixelLength, projector, sum, unit, worldOf } from "../state/camera.js";
import { drawSpaceMarks } from "../measure/space_marks.js";
import { facesOf, planePatch, tidyBox } from "../panels/clip_panel.js";
import { make } from "../controls/controls.js";
import { marksToDraw } from "../measure/shown.js";
import { store } from "../state/store.js";
import { lengthText, roundLength } from "../state/units.js";
import { volumes } from "../state/volumes.js";

const EDGES = [0, 1, 2].flatMap((axis) =>
  [0, 1, 2, 3].map((corner) => {
    const others = [0, 1, 2].filter((a) => a !== axis);
    const from = [0, 0, 0];
    from[others[0]] = corner & 1;
    from[others[1]] = corner >> 1;
    const to = [...from];
    to[axis] = 1;
    return [from, to];
  }),
);
const AXIS_NAMES = ["x", "y", "z"];
const SHORTEST_AXIS = 24; // shortest axis, in pixels, along which a handle can be dragged

// Drag along a direction of the screen: pixels per unit, as a vector.
function dragAlong(handle, { start, direction, move }) {
  handle.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    event.preventDefault();
    event.stopPropagation();
    handle.setPointerCapture(event.pointerId);
    const from = { x: event.clientX, y: event.clientY, value: start(), ...direction() };
    const dragged = (moved) => {
      const along = (moved.clientX - from.x) * from.dx + (moved.clientY - from.y) * from.dy;
      move(from.value + along / (from.dx * from.dx + from.dy * from.dy), true);
    };
    const end = () => {
      handle.removeEventListener("pointermove", dragged);
      handle.removeEventListener("pointerup", end);
      handle.removeEventListener("pointercancel", end);
      store.set({});
    };
    handle.addEventListener("pointermove", dragged);
    handle.addEventListener("pointerup", end);
    handle.addEventListener("pointercancel", end);
  });
}

export function mountOverlay(svg, scaleBar, view3d) {
  let project = null;
  let volume = null;

  const box = make("svg:path", { class: "clip-edges" });
  const farBox = make("svg:path", { class: "clip-edges far" });
  const cut = make("svg:path", { class: "clip-plane" });
  const arrow = make("svg:line", { class: "clip-arrow" });
  const cross = make("svg:g", { class: "cross" }, make("svg:path", { class: "cross-edge" }), make("svg:path"));
  const handle = (title, style = "") =>
    make(
      "svg:g",
      { class: `handle ${style}` },
      make("svg:title", {}, title),
      make("svg:circle", { r: 18, class: "handle-reach" }),
      make("svg:circle", { r: 6, class: "handle-spot" }),
    );
  const handles = [0, 1, 2, 3, 4, 5].map((face) =>
    handle(`${AXIS_NAMES[face >> 1]}, ${face % 2 ? "to" : "from"}`, `axis-${AXIS_NAMES[face >> 1]}`),
  );
  const planeHandle = handle("Plane", "plane");
  const measures = make("svg:g", { class: "marks" });
  svg.append(farBox, box, cut, arrow, measures, cross, ...handles, planeHandle);

  const faces = () => facesOf(store.state.view.clip.box, volume.dims);

  function faceCentre(face) {
    const f = faces();
    const centre = [0, 1, 2].map((a) => (f[2 * a] + f[2 * a + 1]) / 2);
    centre[face >> 1] = f[face];
    return centre;
  }

  // The movement of a face on the screen, in pixels per sample.
  function faceDirection(face) {
    const at = faceCentre(face);
    const next = [...at];
    next[face >> 1] += 1;
    const [a, b] = [project(worldOf(volume, at)), project(worldOf(volume, next))];
    return a && b ? { x: a.x, y: a.y, dx: b.x - a.x, dy: b.y - a.y } : null;
  }

  handles.forEach((node, face) =>
    dragAlong(node, {
      start: () => faces()[face],
      direction: () => faceDirection(face),
      move(value) {
        const f = faces();
        const last = volume.dims[face >> 1] - 1;
        const [lo, hi] = face % 2 ? [f[face - 1] + 1, last] : [0, f[face + 1] - 1];
        f[face] = Math.min(hi, Math.max(lo, value));
        store.set({ view: { clip: { box: tidyBox(f, volume.dims) } } }, { live: true });
      },
    }),
  );

  const plane = () => store.state.view.clip.planes[0];

  function planeCentre() {
    const n = unit(plane().slice(0, 3));
    return n.map((part) => part * plane()[3]);
  }

  function planeDirection() {
    const centre = planeCentre();
    const n = unit(plane().slice(0, 3));
    const [a, b] = [project(centre), project(sum([1, centre], [1, n]))];
    return a && b ? { x: a.x, y: a.y, dx: b.x - a.x, dy: b.y - a.y } : null;
  }

  dragAlong(planeHandle, {
    start: () => plane()[3],
    direction: planeDirection,
    move(value) {
      const half = diagonal(volume) / 2;
      const d = Number(Math.min(half, Math.max(-half, value)).toPrecision(4));
      store.set(planePatch(store.state.view.clip.planes, [...plane().slice(0, 3), d]), { live: true });
    },
  });

  const points = (places) => places.map(({ x, y }) => `${x.toFixed(1)} ${y.toFixed(1)}`);

  function drawBox() {
    const f = faces();
    const corner = (c) =>
      project(
        worldOf(
          volume,
          c.map((end, a) => f[2 * a + end]),
        ),
      );
    const lines = EDGES.map(([from, to]) => [corner(from), corner(to)]).filter(([a, b]) => a && b);
    // The edges at the farthest corner are behind the volume.
    const farthest = Math.min(...lines.flat().map(({ depth }) => depth));
    const isFar = (line) => line.some(({ depth }) => depth - farthest < 1e-6 * diagonal(volume));
    const path = (which) => which.map((line) => `M${points(line).join("L")}`).join("");
    box.setAttribute("d", path(lines.filter((line) => !isFar(line))));
    farBox.setAttribute("d", path(lines.filter(isFar)));
    handles.forEach((node, face) => {
      const at = faceDirection(face);
      const length = at ? Math.hypot(at.dx, at.dy) : 0;
      const usable = length * (volume.dims[face >> 1] - 1) > SHORTEST_AXIS;
      node.toggleAttribute("hidden", !usable);
      if (usable) node.setAttribute("transform", `translate(${at.x.toFixed(1)} ${at.y.toFixed(1)})`);
    });
  }

  // The polygon of the plane inside the volume, with ordered corners.
  function drawPlane() {
    const n = unit(plane().slice(0, 3));
    const last = volume.dims.map((count) => count - 1);
    const height = (p) => p[0] * n[0] + p[1] * n[1] + p[2] * n[2] - plane()[3];
    const corners = [];
    for (const [from, to] of EDGES) {
      const [a, b] = [from, to].map((c) =>
        worldOf(
          volume,
          c.map((end, axis) => end * last[axis]),
        ),
      );
      const [ha, hb] = [height(a), height(b)];
      if (ha * hb > 0 || ha === hb) continue;
      corners.push(sum([hb / (hb - ha), a], [-ha / (hb - ha), b]));
    }
    const places = corners.map((corner) => project(corner)).filter(Boolean);
    const middle = {
      x: places.reduce((total, p) => total + p.x, 0) / places.length,
      y: places.reduce((total, p) => total + p.y, 0) / places.length,
    };
    const angle = (p) => Math.atan2(p.y - middle.y, p.x - middle.x);
    places.sort((a, b) => angle(a) - angle(b));
    cut.setAttribute("d", places.length > 2 ? `M${points(places).join("L")}Z` : "");
    const at = planeDirection();
    const length = at ? Math.hypot(at.dx, at.dy) : 0;
    const usable = at && length * diagonal(volume) > SHORTEST_AXIS;
    planeHandle.toggleAttribute("hidden", !usable);
    arrow.toggleAttribute("hidden", !usable);
    if (!usable) return;
    planeHandle.setAttribute("transform", `translate(${at.x.toFixed(1)} ${at.y.toFixed(1)})`);
    const reach = Math.min(46, length * diagonal(volume) * 0.2) / length;
    for (const [name, value] of Object.entries({
      x1: at.x,
      y1: at.y,
      x2: at.x + at.dx * reach,
      y2: at.y + at.dy * reach,
    }))
      arrow.setAttribute(name, value.toFixed(1));
  }

  function drawCross() {
    const { sample } = store.state.page;
    const at = sample && project(worldOf(volume, sample));
    cross.toggleAttribute("hidden", !at);
    if (!at) return;
    const arms = [
      [-1, 0],
      [1, 0],
      [0, -1],
      [0, 1],
    ];
    const arm = ([x, y]) => `M${at.x + x * 5} ${at.y + y * 5}l${x * 9} ${y * 9}`;
    for (const path of cross.children) path.setAttribute("d", arms.map(arm).join(""));
  }

  function drawScale(frame, view) {
    const parallel = view.camera.fov === 0 && store.state.page.marks;
    scaleBar.hidden = !parallel;
    if (!parallel) return;
    const pixel = pixelLength(view.camera, volume, frame.height);
    const length = roundLength(pixel * Math.min(260, Math.max(90, frame.width * 0.2)));
    const assumed = !volume.unit && volume.patient; // as in cvol render --annotate
    scaleBar.style.setProperty("--length", `${length / pixel}px`);
    scaleBar.firstElementChild.textContent = lengthText(length, assumed ? "mm" : volume.unit) + (assumed ? " (assumed)" : "");
  }

  return function draw() {
    const { frame } = view3d;
    const view = frame && (frame.seen ?? frame.view);
    const drawn = frame && volumes.get(view.volume);
    volume = drawn?.state === "ready" ? drawn : null; // a coarse level may be drawn of a file that fails later
    svg.toggleAttribute("hidden", !volume);
    if (!volume) {
      scaleBar.hidden = true;
      return;
    }
    svg.setAttribute("viewBox", `0 0 ${frame.width} ${frame.height}`);
    project = projector(view, volume, frame.width, frame.height);
    const clipping = store.state.page.open.clip === true && store.state.view.volume === volume.id;
    for (const node of [box, farBox, ...handles]) node.toggleAttribute("hidden", !clipping);
    for (const node of [cut, arrow, planeHandle]) node.toggleAttribute("hidden", !clipping || !plane());
    if (clipping) drawBox();
    if (clipping && plane()) drawPlane();
    drawSpaceMarks(measures, volume.id === store.state.view.volume ? marksToDraw() : [], volume, project, frame.width);
    drawCross();
    drawScale(frame, view);
  };
}
