// Light on surfaces: from where, and what they make of it.

import { ball } from "./ball.js";
import { directions } from "./camera.js";
import { bind, check, group, hint, make, slider } from "./controls.js";
import { modePatch } from "./look_panel.js";
import { store } from "./store.js";
import { volumes } from "./volumes.js";

export function mountLight(panel) {
  const lit = ({ view }) => view.mode === "iso" || (view.mode === "composite" && view.light.on);
  const withEye = ({ view }) => view.light.direction.every((part) => part === 0);
  const light = (name, more) =>
    slider({
      read: (state) => state.view.light[name],
      write: (value) => ({ view: { light: { [name]: value } } }),
      enabled: lit,
      ...more,
    });
  const on = check({
    label: "Light surfaces",
    read: lit,
    write: (value) => modePatch(value ? "shaded" : "composite", store.state.view),
    enabled: ({ view }) => view.mode === "composite",
  });
  const eye = check({
    label: "With the eye",
    title: "The light moves with the eye; else it stays with the volume",
    read: withEye,
    write: (value) => ({
      view: { light: { direction: value ? [0, 0, 0] : directions(store.state.view.camera, false).eye } },
    }),
    enabled: lit,
  });
  const from = ball({
    label: "Where the light is",
    read: (state) => (withEye(state) ? null : state.view.light.direction),
    write: (direction) => ({ view: { light: { direction } } }),
    enabled: lit,
  });
  const beside = group(make("div"), [on, eye, hint("Drag the spot to where the light is.")]);
  return bind(panel, [
    group(make("div", { class: "ball-row" }), [from, beside]),
    light("ambient", {
      label: "Ambient",
      title: "Light from everywhere",
      min: 0,
      max: 1,
      step: 0.01,
      initial: 0.1,
    }),
    light("diffuse", {
      label: "Diffuse",
      title: "Of what faces the light",
      min: 0,
      max: 2,
      step: 0.01,
      initial: 0.7,
    }),
    light("specular", { label: "Specular", title: "Of highlights", min: 0, max: 2, step: 0.01, initial: 0.2 }),
    light("shininess", {
      label: "Shininess",
      title: "The more, the smaller are highlights",
      min: 1,
      max: 256,
      step: 1,
      initial: 10,
    }),
    light("gradient_opacity", {
      label: "Gradient opacity",
      title: "Matter whose values rise by less than this a sample is thinner",
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
