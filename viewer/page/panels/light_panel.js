// The light panel.

import { ball } from "../controls/ball.js";
import { directions } from "../state/camera.js";
import { bind, check, group, hint, make, slider } from "../controls/controls.js";
import { modePatch } from "./look_panel.js";
import { store } from "../state/store.js";
import { CINEMATIC_LIGHT, DEFAULT_VIEW } from "../state/default_view.js";
import { volumes } from "../state/volumes.js";

export function mountLight(panel) {
  const lit = ({ view }) => view.mode === "iso" || (view.mode === "composite" && view.light.on);
  const withEye = ({ view }) => view.light.in_view || view.light.direction.every((part) => part === 0);
  const light = (name, more) =>
    slider({
      read: (state) => state.view.light[name],
      write: (value) => ({ view: { light: { [name]: value } } }),
      enabled: lit,
      ...more,
    });
  const on = check({
    label: "Light",
    read: lit,
    write: (value) => modePatch(value ? "shaded" : "composite"),
    enabled: ({ view }) => view.mode === "composite",
  });
  const cinematic = check({
    label: "Cinematic",
    title: "Soft light from a sky and a key light, which shines through translucent matter",
    read: ({ view }) => view.light.samples > 0,
    write(value) {
      const light = {};
      for (const name in CINEMATIC_LIGHT) light[name] = (value ? CINEMATIC_LIGHT : DEFAULT_VIEW.light)[name];
      return { view: { light } };
    },
    enabled: lit,
  });
  const eye = check({
    label: "Fixed to the eye",
    title: "The light moves with the eye; otherwise it is fixed to the volume",
    read: withEye,
    write: (value) => ({
      view: {
        light: value
          ? { in_view: true, direction: DEFAULT_VIEW.light.direction }
          : { in_view: false, direction: directions(store.state.view.camera, false).eye },
      },
    }),
    enabled: lit,
  });
  const from = ball({
    label: "Direction of the light",
    read: (state) => (withEye(state) ? null : state.view.light.direction),
    write: (direction) => ({ view: { light: { direction, in_view: false } } }),
    enabled: lit,
  });
  const choices = group(make("div"), [on, cinematic, eye, hint("Drag the spot to change the direction of the light.")]);
  return bind(panel, [
    group(make("div", { class: "ball-row" }), [from, choices]),
    light("ambient", {
      label: "Ambient",
      title: "Ambient light",
      min: 0,
      max: 1,
      step: 0.01,
      initial: DEFAULT_VIEW.light.ambient,
    }),
    light("diffuse", {
      label: "Diffuse",
      title: "Diffuse reflection",
      min: 0,
      max: 2,
      step: 0.01,
      initial: DEFAULT_VIEW.light.diffuse,
    }),
    light("fill", {
      label: "Fill",
      title: "A second light, from the eye",
      min: 0,
      max: 2,
      step: 0.01,
      initial: DEFAULT_VIEW.light.fill,
    }),
    light("occlusion", {
      label: "Occlusion",
      title: "Darkens what its surroundings hide from ambient light",
      min: 0,
      max: 1,
      step: 0.01,
      initial: DEFAULT_VIEW.light.occlusion,
    }),
    light("shadows", {
      label: "Shadows",
      title: "The strength of the shadows of the light",
      min: 0,
      max: 1,
      step: 0.01,
      initial: DEFAULT_VIEW.light.shadows,
    }),
    light("specular", { label: "Specular", title: "Specular reflection", min: 0, max: 2, step: 0.01, initial: DEFAULT_VIEW.light.specular }),
    light("shininess", {
      label: "Shininess",
      title: "Exponent of highlights: larger makes them smaller",
      min: 1,
      max: 256,
      step: 1,
      initial: DEFAULT_VIEW.light.shininess,
    }),
    light("gradient_opacity", {
      label: "Gradient opacity",
      title: "Reduces the density where the gradient is below this value per sample",
      initial: 0,
      limits() {
        const volume = volumes.current();
        const span = volume?.state === "ready" ? volume.max - volume.min : 1;
        return { min: 0, max: span / 2, step: span / 400 };
      },
      enabled: (state) => lit(state) && state.view.mode === "composite",
    }),
  ]);
}
