// What is shown of the samples along a ray, and on which ground.

import { autoWindow, wantsWindow } from "./auto_window.js";
import { bind, button, check, choice, colour, group, make } from "./controls.js";
import { store } from "./store.js";
import { volumes } from "./volumes.js";

export const MODES = [
  ["composite", "Composite", "Colours and opacities along the ray, front to back"],
  ["shaded", "Shaded", "The same, lit by the volume's gradients"],
  ["iso", "Surface", "The first place along the ray that has a value"],
  ["xray", "X-ray", "The mean along the ray"],
  ["mip", "Maximum", "The largest value along the ray (MIP)"],
  ["min", "Minimum", "The smallest value along the ray"],
];

export const modeOf = ({ mode, light }) => (mode === "composite" && light.on ? "shaded" : mode);
// Surfaces are lit better where they are dense: a density that nobody chose is LIT_DENSITY under light.
const LIT_DENSITY = 6;

export function modePatch(name, { opacity_scale }) {
  if (name !== "composite" && name !== "shaded") return { view: { mode: name } };
  const on = name === "shaded";
  const patch = { mode: "composite", light: { on } };
  if (opacity_scale === (on ? 1 : LIT_DENSITY)) patch.opacity_scale = on ? LIT_DENSITY : 1;
  return { view: patch };
}

// A mode that needs a window comes with one, in one step.
export async function setMode(name) {
  const patch = modePatch(name, store.state.view);
  const { volume } = store.state.view;
  if (wantsWindow(patch.view.mode, store.state.view)) {
    patch.view.window = await autoWindow(patch.view.mode).catch(() => null);
    if (store.state.view.volume !== volume) return;
  }
  store.set(patch);
}

// first(): makes all settings those of the volume when it is opened.
export function mountLook(panel, { first }) {
  const mirror = check({
    label: "Mirrored, as this volume's axes are left-handed",
    read: (state) => state.view.mirror,
    write: (on) => ({ view: { mirror: on } }),
  });
  const updateMirror = mirror.update;
  mirror.update = (state) => {
    updateMirror(state);
    mirror.element.hidden = !volumes.current()?.mirrored && !state.view.mirror;
  };
  return bind(panel, [
    choice({ label: "Mode", options: MODES, read: (state) => modeOf(state.view), choose: setMode }),
    colour({
      label: "Background",
      read: (state) => state.view.background,
      write: (background) => ({ view: { background } }),
      ready: [
        ["Black", [0, 0, 0]],
        ["Grey", [0.22, 0.23, 0.25]],
        ["White", [1, 1, 1]],
      ],
    }),
    mirror,
    group(make("div", { class: "buttons" }), [
      button({
        label: "Reset all settings",
        title: "Every setting as it was when the volume was opened; undo brings them back",
        press: first,
      }),
    ]),
  ]);
}
