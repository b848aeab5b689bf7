// The volume turning round the vertical, until it is touched.

import { tidy } from "./camera.js";
import { store } from "./store.js";

export function createTurntable(changed) {
  let on = false;
  let before = 0;

  function turn(now) {
    if (!on) return;
    const { camera, mirror } = store.state.view;
    const degrees = (Math.min(200, now - before) / 1000) * store.state.page.turning;
    before = now;
    const azimuth = camera.azimuth + (mirror ? -degrees : degrees);
    store.set({ view: { camera: tidy({ ...camera, azimuth }) } }, { live: true });
    requestAnimationFrame(turn);
  }

  function set(value) {
    if (on === value) return;
    on = value;
    if (on) {
      before = performance.now();
      requestAnimationFrame(turn);
    } else {
      store.set({});
    }
    changed(on);
  }
  return {
    get on() {
      return on;
    },
    toggle: () => set(!on),
    stop: () => set(false),
  };
}
