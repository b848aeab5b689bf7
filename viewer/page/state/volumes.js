// The list of volumes; polls while one of them is not ready.

import { api } from "./api.js";
import { withJoinedHomes } from "./channels.js";
import { store } from "./store.js";

const POLL_MS = 300;

const listeners = new Set();
let all = [];
let told = ""; // by the program
let timer = 0;

const unsettled = ({ state, partial }) => partial || state === "reading" || state === "compressing";

async function refresh() {
  clearTimeout(timer);
  const now = await api.volumes();
  const text = JSON.stringify(now);
  const changed = text !== told;
  told = text;
  if (changed) all = withJoinedHomes(now);
  clearTimeout(timer);
  if (all.some(unsettled)) timer = setTimeout(() => refresh().catch(() => {}), POLL_MS);
  if (changed) for (const listener of [...listeners]) listener(volumes);
}

export const volumes = {
  list: () => all,
  get: (id) => all.find((volume) => volume.id === id),
  current: () => all.find((volume) => volume.id === store.state.view.volume),
  // Calls fn(volumes) after a change; returns a function that ends this.
  subscribe(fn) {
    listeners.add(fn);
    return () => listeners.delete(fn);
  },
  // Refreshes at once; call after a copy was requested or removed.
  refresh,
};
