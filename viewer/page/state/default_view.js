// The view of doc/viewer-api.md as the page begins.

export const DEFAULT_VIEW = {
  volume: null,
  time: 0,
  channels: null, // see channels.js
  overlays: null, // see overlays.js
  mode: "composite",
  camera: { azimuth: 0, elevation: 0, roll: 0, zoom: 1, fov: 0, look_at: [0, 0, 0] },
  mirror: false,
  transfer: "auto",
  opacity_scale: 1,
  window: null,
  light: {
    // studio light, as in src/render/look/studio.c
    on: true,
    direction: [-0.55, 0.65, 0.9],
    ambient: 0.3,
    diffuse: 0.6,
    specular: 0.1,
    shininess: 24,
    gradient_opacity: 0,
    fill: 0.2,
    occlusion: 0.75,
    shadows: 0.6,
    samples: 0,
    in_view: true,
    keeps_brightness: true,
  },
  // null: the middle of the value range
  surface: { value: null, colour: [0.9, 0.85, 0.75] },
  clip: { box: null, planes: [] },
  background: [0, 0, 0],
  step: 0,
  oversample: 1,
  footprint: "linear",
};

// Light that is scattered once, as in src/render/look/studio.c.
export const CINEMATIC_LIGHT = {
  ambient: 0.35,
  diffuse: 0.65,
  specular: 0.15,
  shininess: 32,
  fill: 0.1,
  occlusion: 1,
  shadows: 1,
  samples: 64,
};
