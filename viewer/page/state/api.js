// The requests of doc/viewer-api.md, one function each. transport.js sends them. After a failure it throws an Error
// with the message of the answer and its `status`, 0 if there was none.

import { address, ask, bodyOf, endLater, fileOf, onReach, picture } from "./transport.js";

const json = async (path, options) => (await ask(path, options)).json();
const one = (id) => `volumes/${encodeURIComponent(id)}`;

function slicePath(id, axis, index, window, { time, overlays }) {
  const query = new URLSearchParams({ axis, index });
  if (time) query.set("time", time);
  if (window) query.set("window", window.join(","));
  if (overlays) query.set("overlays", JSON.stringify(overlays));
  return `${one(id)}/slice?${query}`;
}

export const api = {
  onReach,
  about: () => json("../1"),
  volumes: async () => (await json("volumes")).volumes,
  volume: (id) => json(one(id)),
  // {blob, info}. The blob may be pixels (ImageData); fileOf makes a file of it.
  frame: (request, options) => picture("frame", request, options),
  difference: (request, options) => picture("difference", request, options),
  histogram: (id) => json(`${one(id)}/histogram`),
  transfer: (id, name) => json(`${one(id)}/transfer?name=${encodeURIComponent(name)}`),
  // The transfer function of overlay i; window null: automatic.
  overlayTransfer: (id, i, name, window) =>
    json(`${one(id)}/transfer?${new URLSearchParams({ overlay: i, name, ...(window && { window: window.join(",") }) })}`),
  readTransfer: (id, text) => json(`${one(id)}/transfer`, { method: "POST", text }),
  slice: async (id, axis, index, window, { signal, ...more } = {}) =>
    bodyOf(await ask(slicePath(id, axis, index, window, more), { signal })),
  value: (id, x, y, z, { signal, time = 0 } = {}) =>
    json(`${one(id)}/value?x=${x}&y=${y}&z=${z}${time ? `&time=${time}` : ""}`, { signal }),
  // Reads a time before it is shown.
  open: (id, time) => json(`${one(id)}/open`, { method: "POST", body: { time } }),
  pick: (view, x, y) => json("pick", { method: "POST", body: { view, x, y } }),
  // The figures of a distance, an angle or a region.
  measure: (id, body) => json(`${one(id)}/measure`, { method: "POST", body }),
  copy: (id, wanted) => json(`${one(id)}/copy`, { method: "POST", body: wanted }),
  remove: (id) => ask(one(id), { method: "DELETE" }),
  film: (request) => json("films", { method: "POST", body: request }),
  filmState: (id) => json(`films/${encodeURIComponent(id)}`),
  filmAddress: (id) => address(`films/${encodeURIComponent(id)}/file`).href,
  removeFilm: (id) => ask(`films/${encodeURIComponent(id)}`, { method: "DELETE" }),
  command: (view) => json("command", { method: "POST", body: { view } }),
  status: () => json("status"),
  end: () => json("end", { method: "POST", body: {} }),
  // The same from a closing page, unless the page is only reloaded.
  endLater,
  fileOf,
};
