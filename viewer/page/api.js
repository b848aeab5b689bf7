// The requests of doc/viewer-api.md, one function each. After a failure it throws an Error with the message of the
// server and the `status` of the answer, 0 if there was none.

const BASE = new URL("api/1/", document.baseURI);
const RELOAD_MS = 3000;
export const GONE = "The viewer does not answer: start cvol view again.";

const listeners = new Set();
let reached = true;

function setReached(now) {
  if (now === reached) return;
  reached = now;
  for (const listener of [...listeners]) listener(reached);
}

// Calls fn(true or false) when the server starts or stops to answer; returns a function that ends this.
export function onReach(fn) {
  listeners.add(fn);
  return () => listeners.delete(fn);
}

function failure(sentence, status) {
  const error = new Error(sentence);
  error.status = status;
  return error;
}

async function sentenceOf(response) {
  try {
    const { error } = await response.json();
    if (error) return error;
  } catch {
    // not JSON: use the status
  }
  return `The viewer answered with status ${response.status}.`;
}

async function ask(path, { method = "GET", body, text, signal } = {}) {
  const options = { method, signal, cache: "no-store", credentials: "omit" };
  if (body !== undefined) {
    options.body = JSON.stringify(body);
    options.headers = { "Content-Type": "application/json" };
  } else if (text !== undefined) {
    options.body = text;
  }
  let response;
  try {
    response = await fetch(new URL(path, BASE), options);
  } catch (error) {
    if (error.name === "AbortError") throw error;
    setReached(false);
    throw failure(GONE, 0);
  }
  setReached(true);
  if (!response.ok) throw failure(await sentenceOf(response), response.status);
  return response;
}

const json = async (path, options) => (await ask(path, options)).json();
const one = (id) => `volumes/${encodeURIComponent(id)}`;

async function bodyOf(response) {
  try {
    return await response.blob();
  } catch {
    setReached(false);
    throw failure(GONE, 0);
  }
}

// {blob, info}: a picture, and its header Cvol-Frame.
async function picture(path, request, { signal } = {}) {
  const response = await ask(path, { method: "POST", body: request, signal });
  const info = JSON.parse(response.headers.get("Cvol-Frame") ?? "{}");
  return { blob: await bodyOf(response), info };
}

function sliceAddress(id, axis, index, window) {
  const address = new URL(`${one(id)}/slice`, BASE);
  address.searchParams.set("axis", axis);
  address.searchParams.set("index", index);
  if (window) address.searchParams.set("window", window.join(","));
  return address.href;
}

export const api = {
  onReach,
  about: () => json("../1"),
  volumes: async () => (await json("volumes")).volumes,
  volume: (id) => json(one(id)),
  frame: (request, options) => picture("frame", request, options),
  difference: (request, options) => picture("difference", request, options),
  histogram: (id) => json(`${one(id)}/histogram`),
  transfer: (id, name) => json(`${one(id)}/transfer?name=${encodeURIComponent(name)}`),
  readTransfer: (id, text) => json(`${one(id)}/transfer`, { method: "POST", text }),
  sliceAddress,
  slice: async (id, axis, index, window, { signal } = {}) =>
    bodyOf(await ask(sliceAddress(id, axis, index, window), { signal })),
  value: (id, x, y, z, { signal } = {}) => json(`${one(id)}/value?x=${x}&y=${y}&z=${z}`, { signal }),
  pick: (view, x, y) => json("pick", { method: "POST", body: { view, x, y } }),
  copy: (id, wanted) => json(`${one(id)}/copy`, { method: "POST", body: wanted }),
  remove: (id) => ask(one(id), { method: "DELETE" }),
  film: (request) => json("films", { method: "POST", body: request }),
  filmState: (id) => json(`films/${encodeURIComponent(id)}`),
  filmAddress: (id) => new URL(`films/${encodeURIComponent(id)}/file`, BASE).href,
  removeFilm: (id) => ask(`films/${encodeURIComponent(id)}`, { method: "DELETE" }),
  command: (view) => json("command", { method: "POST", body: { view } }),
  status: () => json("status"),
  end: () => json("end", { method: "POST", body: {} }),
  // The same from a closing page, unless the page is only reloaded.
  endLater: () =>
    navigator.sendBeacon(
      new URL("end", BASE),
      new Blob([JSON.stringify({ unless_asked_ms: RELOAD_MS })], { type: "application/json" }),
    ),
};
