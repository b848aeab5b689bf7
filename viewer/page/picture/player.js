// Plays a series: shows one time after the other, from the last one again from the first. The next time is shown when
// the picture of the last one is on the canvas; the program reads the one after that in advance.

import { api } from "../state/api.js";
import { store } from "../state/store.js";
import { volumes } from "../state/volumes.js";

// changed(on): it starts or stops.
export function createPlayer(changed) {
  let on = false;
  let timer = 0;
  let due = 0; // when the next time may be shown

  const after = (time, steps) => {
    const { times } = volumes.current();
    return (time + steps + times) % times;
  };

  function readAhead(time) {
    const { volume, channels } = store.state.view;
    const shown = channels ? channels.filter(({ on }) => on).map((channel) => channel.volume) : [volume];
    for (const id of shown) api.open(id, time).catch(() => {}); // the picture of this time reports the failure
  }

  function step() {
    if (!on || volumes.current()?.state !== "ready") return;
    const now = performance.now();
    const period = 1000 / store.state.page.playing;
    due = Math.max(now, due + period);
    const time = after(store.state.view.time, 1);
    store.set({ view: { time } }, { undo: false, live: true });
    readAhead(after(time, 1));
  }

  function set(value) {
    if (on === value || (value && !(volumes.current()?.times > 1))) return;
    on = value;
    clearTimeout(timer);
    changed(on);
    if (on) {
      due = performance.now();
      step();
    } else {
      store.set({}); // a still picture, and the link
    }
  }

  return {
    get on() {
      return on;
    },
    // A picture of this view was shown.
    next(view) {
      if (!on || view.time !== store.state.view.time) return;
      clearTimeout(timer);
      timer = setTimeout(step, Math.max(0, due + 1000 / store.state.page.playing - performance.now()));
    },
    toggle: () => set(!on),
    stop: () => set(false),
    // Shows another time.
    show(time, live = false) {
      set(false);
      if (volumes.current()?.times > 1) store.set({ view: { time } }, { undo: false, live });
    },
    // Shows the time before or after.
    move(steps) {
      if (volumes.current()?.times > 1) this.show(after(store.state.view.time, steps));
    },
  };
}
