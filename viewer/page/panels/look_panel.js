// The look panel: mode and background.

import { autoWindow, wantsWindow } from "./auto_window.js";
import { bind, button, check, choice, colour, group, make } from "../controls/controls.js";
import { store } from "../state/store.js";
import { volumes } from "../state/volumes.js";

export const MODES = [
  ["shaded", "Lit", "Colours and opacities along the ray, front to back, with light"],
  ["composite", "Unlit", "The same without light"],
  ["iso", "Surface", "The first place along the ray with a value"],
  ["xray", "X-ray", "The mean along the ray"],
  ["mip", "Maximum", "The largest value along the ray (MIP)"],
  ["min", "Minimum", "The smallest value along the ray"],
];

export const modeOf = ({ mode, light }) => (mode === "composite" && light.on ? "shaded" : mode);

export function modePatch(name) {
  if (name !== "composite" && name !== "shaded") return { view: { mode: name } };
  return { view: { mode: "composite", light: { on: name === "shaded" } } };
}

// A mode that needs a window gets one, in the same undo step.
export async function setMode(name) {
  const patch = modePatch(name);
  const { volume } = store.state.view;
  if (wantsWindow(patch.view.mode, store.state.view)) {
    patch.view.window = await autoWindow(patch.view.mode).catch(() => null);
    if (store.state.view.volume !== volume) return;
  }
  store.set(patch);
}

// first(): resets all settings to those of a newly opened volume.
export function mountLook(panel, { first }) {
  const mirror = check({
    label: "Mirrored, because the axes of this volume are left-handed",
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
        title: "Reset every setting to its initial value; undo restores them",
        press: first,
      }),
    ]),
  ]);
}
