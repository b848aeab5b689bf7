// Requests by HTTP to the server of cvol view. A page that draws its pictures itself has web/page/transport.js instead.
// After a failure functions throw an Error with the message of the server and the `status` of the answer, 0 if there
// was none.

const BASE = new URL("api/1/", document.baseURI);
const RELOAD_MS = 3000;
export const GONE = "The viewer does not answer: start cvol view again.";
// Links to a view stay valid after the program ends.
export const LINK_LASTS = false;
// The title of the page; "": the name of the volume.
export const TITLE = "";
// The view at first, as the part of a link after #.
export const START = "";

const listeners = new Set();
let reached = true;

function setReached(now) {
  if (now === reached) return;
  reached = now;
  for (const listener of [...listeners]) listener(reached);
}

// Calls fn() when there is one more volume: never in this page.
export const onAdded = () => {};
export const onChanged = () => {};

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

export async function ask(path, { method = "GET", body, text, signal } = {}) {
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

export async function bodyOf(response) {
  try {
    return await response.blob();
  } catch {
    setReached(false);
    throw failure(GONE, 0);
  }
}

// {blob, info}: a picture, and its header Cvol-Frame.
export async function picture(path, request, { signal } = {}) {
  const response = await ask(path, { method: "POST", body: request, signal });
  const info = JSON.parse(response.headers.get("Cvol-Frame") ?? "{}");
  return { blob: await bodyOf(response), info };
}

export const address = (path) => new URL(path, BASE);

// The file of a picture, to be saved.
export const fileOf = async (blob) => blob;

// Sends a request from a closing page, which the program obeys unless the page is only reloaded.
export const endLater = () =>
  navigator.sendBeacon(
    new URL("end", BASE),
    new Blob([JSON.stringify({ unless_asked_ms: RELOAD_MS })], { type: "application/json" }),
  );
