// Which values slices show as black and white: state.page.slices.windows[volume], or what most samples have.

import { robustRange } from "./histogram.js";

export function sliceWindows({ store, api, volumes }) {
  const fitted = new Map();
  const listeners = new Set();

  async function fit(volume) {
    if (fitted.has(volume.id)) return;
    fitted.set(volume.id, [volume.min, volume.max]);
    try {
      const histogram = await api.histogram(volume.id);
      // Air is most of many volumes: only the brightest few are left out
      fitted.set(volume.id, [histogram.min, robustRange(histogram, 0, 0.002)[1]]);
      for (const listener of listeners) listener();
    } catch {
      // All values, then
    }
  }

  return {
    subscribe: (fn) => listeners.add(fn),
    get() {
      const volume = volumes.current();
      if (volume?.state !== "ready") return null;
      fit(volume);
      return store.state.page.slices?.windows?.[volume.id] || fitted.get(volume.id);
    },
    set(window, live = false) {
      const volume = volumes.current();
      if (volume) store.set({ page: { slices: { windows: { [volume.id]: window } } } }, { live });
    },
  };
}
