// A control for a direction: a spot on a ball, which turns with the volume.

import { directions, dot, sum, unit } from "../state/camera.js";
import { make } from "./controls.js";
import { store } from "../state/store.js";

const RADIUS = 44;
const STEP = (5 * Math.PI) / 180;

// read(state): a direction in the world, or null for towards the eye. write(direction): returns a patch.
export function ball({ label, read, write, enabled = () => true }) {
  const disc = make("svg:circle", { r: RADIUS, class: "ball-disc" });
  const spot = make("svg:circle", { r: 7, class: "ball-spot" });
  const stem = make("svg:line", { x1: 0, y1: 0, class: "ball-stem" });
  const rings = [0.5, 1].map((share) => make("svg:circle", { r: RADIUS * share, class: "ball-ring" }));
  const element = make(
    "svg:svg",
    { class: "ball", viewBox: "-48 -48 96 96", role: "slider", tabindex: 0, "aria-label": label },
    disc,
    ...rings,
    stem,
    spot,
  );

  const axes = () => directions(store.state.view.camera, store.state.view.mirror);
  const rounded = (direction) => unit(direction).map((part) => Number(part.toFixed(3)));

  function seen(state) {
    const world = read(state);
    if (!world) return [0, 0, 1];
    const { right, up, eye } = axes();
    const u = unit(world);
    return [dot(u, right), dot(u, up), dot(u, eye)];
  }

  function point([x, y, z], live) {
    const { right, up, eye } = axes();
    store.set(write(rounded(sum([x, right], [y, up], [z, eye]))), { live });
  }

  function drag(event, live) {
    const box = element.getBoundingClientRect();
    let x = ((event.clientX - box.left) / box.width - 0.5) * (96 / RADIUS);
    let y = (0.5 - (event.clientY - box.top) / box.height) * (96 / RADIUS);
    const length = Math.hypot(x, y);
    // Outside the rim: the far side of the ball.
    if (length > 1) {
      const behind = -Math.sin(Math.min(Math.PI / 2, (length - 1) * 2));
      const rim = Math.sqrt(1 - behind * behind);
      point([(x / length) * rim, (y / length) * rim, behind], live);
    } else {
      point([x, y, Math.sqrt(1 - length * length)], live);
    }
  }

  let held = false;
  element.addEventListener("pointerdown", (event) => {
    if (element.getAttribute("aria-disabled") === "true") return;
    held = true;
    element.setPointerCapture(event.pointerId);
    drag(event, true);
  });
  element.addEventListener("pointermove", (event) => held && drag(event, true));
  for (const name of ["pointerup", "pointercancel"])
    element.addEventListener(name, () => {
      if (held) store.set({});
      held = false;
    });
  element.addEventListener("keydown", (event) => {
    const turn = { ArrowLeft: [-STEP, 0], ArrowRight: [STEP, 0], ArrowUp: [0, STEP], ArrowDown: [0, -STEP] }[event.key];
    if (!turn || element.getAttribute("aria-disabled") === "true") return;
    event.preventDefault();
    event.stopPropagation();
    const [x, y, z] = seen(store.state);
    const across = Math.atan2(x, z) + turn[0];
    const up = Math.max(-Math.PI / 2, Math.min(Math.PI / 2, Math.asin(Math.max(-1, Math.min(1, y))) + turn[1]));
    point([Math.sin(across) * Math.cos(up), Math.sin(up), Math.cos(across) * Math.cos(up)], false);
  });

  return {
    element,
    update(state) {
      const [x, y, z] = seen(state);
      spot.setAttribute("cx", x * RADIUS);
      spot.setAttribute("cy", -y * RADIUS);
      stem.setAttribute("x2", x * RADIUS);
      stem.setAttribute("y2", -y * RADIUS);
      element.classList.toggle("behind", z < 0);
      element.setAttribute("aria-disabled", !enabled(state));
      const degrees = (radians) => Math.round((radians * 180) / Math.PI);
      const across = degrees(Math.atan2(x, z));
      const above = degrees(Math.asin(Math.max(-1, Math.min(1, y))));
      element.setAttribute("aria-valuemin", -180);
      element.setAttribute("aria-valuemax", 180);
      element.setAttribute("aria-valuenow", across);
      element.setAttribute("aria-valuetext", `${across} degrees to the right of the eye, ${above} degrees above it`);
    },
  };
}
