// Turns the volume about the vertical until the user moves it.

import { tidy } from "../state/camera.js";
import { store } from "../state/store.js";

const LATEST_MS = 250; // continue after this time without a picture

export function createTurntable(changed) {
  let on = false;
  let before = 0;
  let timer = 0;

  // One step per picture.
  function turn() {
    clearTimeout(timer);
    if (!on) return;
    const now = performance.now();
    timer = setTimeout(turn, LATEST_MS);
    const { camera, mirror } = store.state.view;
    const degrees = (Math.min(200, now - before) / 1000) * store.state.page.turning;
    before = now;
    const azimuth = camera.azimuth + (mirror ? -degrees : degrees);
    store.set({ view: { camera: tidy({ ...camera, azimuth }) } }, { live: true });
  }

  function set(value) {
    if (on === value) return;
    on = value;
    if (on) {
      before = performance.now();
      turn();
    } else {
      clearTimeout(timer);
      store.set({});
    }
    changed(on);
  }
  return {
    get on() {
      return on;
    },
    // A picture was shown.
    next: () => on && requestAnimationFrame(turn),
    toggle: () => set(!on),
    stop: () => set(false),
  };
}
