// The quality panel: still pictures and pictures in motion.

import { bind, hint, make, select, slider } from "../controls/controls.js";

const heading = (text) => ({ element: make("h3", {}, text) });

export function mountQuality(panel) {
  const motion = (name) => ({
    undo: false,
    read: (state) => state.page.motion[name],
    write: (value) => ({ page: { motion: { [name]: value } } }),
  });
  bind(panel, [
    heading("Still pictures"),
    slider({
      label: "Step",
      title: "Distance of samples along a ray, in samples; 0: chosen by the engine",
      min: 0,
      max: 4,
      step: 0.25,
      initial: 0,
      read: (state) => state.view.step,
      // The smallest step; a slider close to 0 means 0.
      write: (step) => ({ view: { step: step < 1 / 64 ? 0 : step } }),
    }),
    slider({
      label: "Rays per pixel",
      title: "Rays per pixel along each axis of the picture",
      min: 0.25,
      max: 4,
      step: 0.25,
      initial: 1,
      read: (state) => state.view.oversample,
      write: (oversample) => ({ view: { oversample } }),
    }),
    select({
      label: "Interpolation",
      options: [
        ["linear", "Linear"],
        ["catmull-rom", "Catmull-Rom, cubic"],
        ["b-spline", "B-spline, smoothest"],
        ["gaussian", "Gaussian, blurred"],
      ],
      read: (state) => state.view.footprint,
      write: (footprint) => ({ view: { footprint } }),
    }),
    heading("In motion"),
    select({
      label: "Frame rate",
      options: [
        [60, "at least 60 per second"],
        [30, "at least 30 per second"],
        [15, "at least 15 per second"],
        [5, "at least 5 per second"],
      ],
      ...motion("fps"),
    }),
    select({
      label: "Pixels",
      options: [
        ["auto", "Automatic"],
        [1, "Full resolution"],
        [0.5, "Half resolution"],
        [0.25, "Quarter resolution"],
      ],
      ...motion("size"),
    }),
    hint("When the motion stops, a picture of full quality follows."),
  ]);
}
