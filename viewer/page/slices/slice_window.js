// The black and white values of slices: state.page.slices.windows[volume], or a range of most samples.

import { robustRange } from "../transfer/histogram.js";

const BRIGHTEST = 0.002; // of the samples

/** Many volumes consist mostly of air: leave out only the few brightest samples, of those above the air if these are few. */
export function fittedWindow({ min, max, bins }) {
  const total = bins.reduce((sum, count) => sum + count, 0);
  const first = bins.findIndex((count) => count !== bins[0]); // bins of one summary are equal
  const others = first < 0 ? 0 : total - first * bins[0];
  const few = others > 0 && others < 10 * BRIGHTEST * total;
  const counted = few ? bins.map((count, i) => (i < first ? 0 : count)) : bins;
  return [min, robustRange({ min, max, bins: counted }, 0, BRIGHTEST)[1]];
}

export function sliceWindows({ store, api, volumes }) {
  const fitted = new Map();
  const listeners = new Set();

  async function fit(volume) {
    if (fitted.has(volume.id)) return;
    fitted.set(volume.id, [volume.min, volume.max]);
    try {
      const histogram = await api.histogram(volume.id);
      fitted.set(volume.id, fittedWindow(histogram));
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
