// The black and white values of slices: state.page.slices.windows[volume], or a range of most samples.

import { robustRange } from "../transfer/histogram.js";

export function sliceWindows({ store, api, volumes }) {
  const fitted = new Map();
  const listeners = new Set();

  async function fit(volume) {
    if (fitted.has(volume.id)) return;
    fitted.set(volume.id, [volume.min, volume.max]);
    try {
      const histogram = await api.histogram(volume.id);
      // Many volumes consist mostly of air: leave out only the few brightest samples.
      fitted.set(volume.id, [histogram.min, robustRange(histogram, 0, 0.002)[1]]);
      for (const listener of listeners) listener();
    } catch {
      // Keep the window of all values.
    }
  }

  const own = (volume) => store.state.page.slices?.windows?.[volume?.id];

  return {
    subscribe: (fn) => listeners.add(fn),
    get() {
      const volume = volumes.current();
      if (volume?.state !== "ready") return null;
      fit(volume);
      return own(volume) || fitted.get(volume.id);
    },
    /** The window that the user has set, or null. */
    chosen: () => own(volumes.current()) ?? null,
    set(window, live = false) {
      const volume = volumes.current();
      if (volume) store.set({ page: { slices: { windows: { [volume.id]: window } } } }, { live });
    },
  };
}
