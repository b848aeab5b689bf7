// How finely pictures are drawn, at rest and while something moves.

import { bind, hint, make, select, slider } from "./controls.js";

const heading = (text) => ({ element: make("h3", {}, text) });

export function mountQuality(panel) {
  const motion = (name) => ({
    undo: false,
    read: (state) => state.page.motion[name],
    write: (value) => ({ page: { motion: { [name]: value } } }),
  });
  bind(panel, [
    heading("At rest"),
    slider({
      label: "Step",
      title: "Distance of samples along a ray, in samples; 0: the engine's own",
      min: 0,
      max: 4,
      step: 0.25,
      initial: 0,
      read: (state) => state.view.step,
      // The finest step there is; a slider that is nearly at 0 is at 0.
      write: (step) => ({ view: { step: step < 1 / 64 ? 0 : step } }),
    }),
    slider({
      label: "Rays a pixel",
      title: "Lines and columns of rays for one of the picture",
      min: 0.25,
      max: 4,
      step: 0.25,
      initial: 1,
      read: (state) => state.view.oversample,
      write: (oversample) => ({ view: { oversample } }),
    }),
    select({
      label: "Between samples",
      options: [
        ["linear", "Straight lines"],
        ["catmull-rom", "Catmull-Rom, cubic"],
        ["b-spline", "B-spline, smoothest"],
        ["gaussian", "Gaussian, blurred"],
      ],
      read: (state) => state.view.footprint,
      write: (footprint) => ({ view: { footprint } }),
    }),
    heading("While it moves"),
    select({
      label: "At least",
      options: [
        [60, "60 pictures a second"],
        [30, "30 pictures a second"],
        [15, "15 pictures a second"],
        [5, "5 pictures a second"],
      ],
      ...motion("fps"),
    }),
    select({
      label: "Pixels",
      options: [
        ["auto", "As many as time allows"],
        [1, "All of the screen's"],
        [0.5, "Half as many lines"],
        [0.25, "A quarter of the lines"],
      ],
      ...motion("size"),
    }),
    hint("At rest the whole quality follows at once."),
  ]);
}
