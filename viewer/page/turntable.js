// The volume turning round the vertical, until it is touched.

import { tidy } from "./camera.js";
import { store } from "./store.js";

const LATEST_MS = 250; // it goes on if a picture stays away

export function createTurntable(changed) {
  let on = false;
  let before = 0;
  let timer = 0;

  // At the pace of the pictures: what is not seen need not be asked for.
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
