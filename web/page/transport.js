// Requests to workers in this page, which takes the place of viewer/page/state/transport.js. The page has what they need: the
// code of the workers and the WebAssembly in script elements, and the volumes from source.js, which is embedded.js or
// site.js.

import { aborted, createPool } from "./pool.js";
import * as given from "./source.js";
import { createRungs, drawStrips } from "./strips.js";
import { unpack } from "./unpack.js";

const WORKERS = Math.max(2, Math.min(4, navigator.hardwareConcurrency || 2));
const COARSE = ["../1", "volumes"]; // requests that need only a coarse level of the volumes, like pictures in motion
const COARSE_AT_FIRST = /^frame$|\/(histogram|transfer\?.*)$/; // while a file arrives
const KEEP_MB = 8; // block cache of each worker

export const START = given.START;
export const TITLE = given.TITLE;
export const LINK_LASTS = true;

const element = (id) => document.getElementById(id);
let module = null; // compiled once
let source = null;

async function makePool(of) {
  const volumes = await of;
  if (!module) ({ source, module } = await unpack(element("cvol-worker").textContent, element("cvol-wasm").textContent));
  return createPool(WORKERS, () => new Worker(source), { module, ...volumes, keepMb: KEEP_MB });
}

let making = makePool(given.firstVolumes());
const viewers = new Map(); // their rungs

function failure(sentence, status) {
  return Object.assign(new Error(sentence), { status });
}

// Asks the workers that have all volumes: those of before end when there is one more.
async function askPool(request, signal, isCoarse) {
  for (;;) {
    const pool = await making;
    if (signal?.aborted) throw aborted();
    try {
      return await pool.ask(request, signal, isCoarse(pool));
    } catch (error) {
      if (!pool.ended || signal?.aborted) throw error;
    }
  }
}

async function send(path, { method = "GET", body, text, signal } = {}) {
  const { pathname, search } = new URL(path, "http://page/api/1/");
  const content = body !== undefined ? JSON.stringify(body) : text;
  const request = { method, path: pathname.slice(1) + search, body: content };
  const isCoarse = ({ partial }) =>
    COARSE.includes(path) ||
    (path === "frame" && body.quality !== "still") ||
    (partial && COARSE_AT_FIRST.test(path));
  const answer = await askPool(request, signal, isCoarse);
  if (signal?.aborted) throw aborted();
  if (answer.status < 400) return answer;
  throw failure(JSON.parse(new TextDecoder().decode(answer.bytes)).error, answer.status);
}

export const onReach = () => () => {};

// Calls fn() when there is one more volume.
const added = new Set();
export const onAdded = (fn) => added.add(fn);
given.onVolumes(async (all) => {
  const before = making;
  making = before.then((pool) => (pool.end(), makePool(all)));
  await making;
  for (const fn of added) fn();
});

export async function ask(path, options) {
  const answer = await send(path, options);
  const { partial, lost } = await making;
  return { answer, json: async () => adapt(path, answer.level, partial, lost, JSON.parse(new TextDecoder().decode(answer.bytes))) };
}

// The number of workers is that of threads. A volume of which only a coarse level is there changes soon, unless the rest
// cannot be loaded.
function adapt(path, level, partial, lost, object) {
  if (path === "../1") return { ...object, threads: WORKERS };
  if (path !== "volumes" || level === 0) return object;
  const more = lost ? { whole_level: level } : { whole_level: 0, partial: true, arrived_level: partial ? level : 0 };
  return { volumes: object.volumes.map((volume) => ({ ...volume, ...more })) };
}

const pixelsOf = ({ bytes, size: [width, height] }) => new ImageData(new Uint8ClampedArray(bytes), width, height);

export const bodyOf = async ({ answer }) => pixelsOf(answer);

export async function picture(path, request, { signal } = {}) {
  const post = (body) => send(path, { method: "POST", body, signal });
  if (path !== "frame") {
    const answer = await post(request);
    return { blob: pixelsOf(answer), info: JSON.parse(answer.frame) };
  }
  if (!viewers.has(request.viewer)) viewers.set(request.viewer, createRungs());
  const { count } = await making;
  return drawStrips(request, { ask: post, workers: Math.max(1, count), rungs: viewers.get(request.viewer) });
}

export const address = () => null;

export async function fileOf(pixels) {
  const canvas = document.createElement("canvas");
  canvas.width = pixels.width;
  canvas.height = pixels.height;
  canvas.getContext("2d").putImageData(pixels, 0, 0);
  return new Promise((resolve) => canvas.toBlob(resolve, "image/png"));
}

export const endLater = () => {};

// Bytes of memory of all workers, for measurements.
window.cvolHeap = async () => (await making).heap();
