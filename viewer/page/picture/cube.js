// The orientation cube: shows the direction of the view, and selects the six named views.

import { directions, dot } from "../state/camera.js";
import { make } from "../controls/controls.js";
import { store } from "../state/store.js";
import { volumes } from "../state/volumes.js";

const HALF = 27;
const LETTERS = { front: "A", back: "P", left: "L", right: "R", top: "S", bottom: "I" };

export function mountCube(svg, named) {
  const axes = ["x", "y", "z"].map((name) => ({
    line: make("svg:line", { class: `cube-axis axis-${name}` }),
    text: make("svg:text", { class: `cube-axis-name axis-${name}` }, name),
  }));
  const faces = Object.keys(LETTERS).map((name) => {
    const text = make("svg:text", { class: "cube-name" });
    const square = make("svg:rect", {
      x: -HALF,
      y: -HALF,
      width: 2 * HALF,
      height: 2 * HALF,
      class: "cube-square",
    });
    const element = make("svg:g", { class: "cube-face", onclick: () => named(name) }, square, text);
    return { name, element, text };
  });
  svg.append(...axes.flatMap(({ line, text }) => [line, text]), ...faces.map(({ element }) => element));

  // Each face has the orientation of its view; faces on the far side are hidden.
  function drawFace({ name, element, text }, volume, view) {
    const camera = volume.views?.[name];
    if (!camera) return element.toggleAttribute("hidden", true);
    const side = directions({ roll: 0, ...camera }, view.mirror);
    const seen = directions(view.camera, view.mirror);
    const facing = dot(side.eye, seen.eye);
    element.toggleAttribute("hidden", facing < 0.04);
    const onScreen = (v) => [dot(v, seen.right), -dot(v, seen.up)];
    const [u, v, middle] = [onScreen(side.right), onScreen(side.up.map((part) => -part)), onScreen(side.eye)];
    const numbers = [...u, ...v, HALF * middle[0], HALF * middle[1]].map((n) => n.toFixed(4));
    element.setAttribute("transform", `matrix(${numbers.join(" ")})`);
    element.style.setProperty("--facing", facing.toFixed(2));
    text.textContent = volume.patient ? LETTERS[name] : name[0].toUpperCase() + name.slice(1);
    text.classList.toggle("letter", volume.patient === true);
  }

  function drawAxis({ line, text }, axis, view) {
    const seen = directions(view.camera, view.mirror);
    const from = [-HALF, -HALF, -HALF];
    const at = (p) => ({ x: dot(p, seen.right).toFixed(2), y: (-dot(p, seen.up)).toFixed(2) });
    const to = [...from];
    to[axis] = HALF * 1.35;
    const beyond = [...from];
    beyond[axis] = HALF * 1.7;
    const [a, b, name] = [at(from), at(to), at(beyond)];
    for (const [key, value] of Object.entries({ x1: a.x, y1: a.y, x2: b.x, y2: b.y })) line.setAttribute(key, value);
    text.setAttribute("x", name.x);
    text.setAttribute("y", name.y);
  }

  return function draw() {
    const volume = volumes.current();
    const shown = volume?.state === "ready" && store.state.page.marks;
    svg.toggleAttribute("hidden", !shown);
    if (!shown) return;
    const { view } = store.state;
    faces.forEach((face) => drawFace(face, volume, view));
    axes.forEach((axis, index) => drawAxis(axis, index, view));
  };
}
