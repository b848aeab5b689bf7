// Requests to workers in this page, which takes the place of viewer/page/state/transport.js. The page has what they need: the
// code of the workers and the WebAssembly in script elements, and the volumes from source.js, which is embedded.js or
// site.js.

import { levelsOfSlice, levelsOfView } from "./needs.js";
import { aborted, createPool } from "./pool.js";
import * as given from "./source.js";
import { createRungs, drawStrips } from "./strips.js";
import { unpackCode, unpackModule } from "./unpack.js";

const WORKERS = Math.max(2, Math.min(4, navigator.hardwareConcurrency || 2));
const COARSE = ["../1", "volumes"]; // requests that need only a coarse level of the volumes, like pictures in motion
const COARSE_AT_FIRST = /^frame$|\/(histogram|transfer\?.*)$/; // while a file arrives
const KEEP_MB = 8; // block cache of each worker

export const START = given.START;
export const TITLE = given.TITLE;
export const LINK_LASTS = true;

const SLICE = /\/slice\?(.*)$/;

const element = (id) => document.getElementById(id);
let module = null; // compiled once, while the workers start
let source = null;

async function makePool(of) {
  const volumes = await of;
  source ??= await unpackCode(element("cvol-worker").textContent);
  module ??= unpackModule(element("cvol-wasm").textContent);
  const more = { module, keepMb: KEEP_MB, onRanged: () => wantNow(), onPart: () => tell(changed) };
  return createPool(WORKERS, () => new Worker(source), { ...volumes, ...more });
}

const tell = (listeners) => {
  for (const fn of listeners) fn();
};

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
  tell(added);
});

// Calls fn() when there is more of a volume than before.
const changed = new Set();
export const onChanged = (fn) => changed.add(fn);

// What the last picture and the last slice across each axis need of a ranged file: functions of its bricks and its VOLUME.
const needs = new Map();
let described = null; // the VOLUME

async function wantNow() {
  const { ranged } = await making;
  if (!ranged || !needs.size) return;
  described ??= (await (await ask("volumes")).json()).volumes[0];
  const levels = [...needs.values()].map((levelsOf) => levelsOf(ranged.bricks, described));
  ranged.want(levels.reduce((all, one) => all.map((level, b) => Math.min(level, one[b]))));
}

function want(key, levelsOf) {
  needs.set(key, levelsOf);
  wantNow().catch(() => {}); // a request that fails says why
}

function wantSlice(query) {
  const { axis, index } = Object.fromEntries(new URLSearchParams(query));
  want(axis, (bricks) => levelsOfSlice(bricks, "xyz".indexOf(axis), Number(index)));
}

export async function ask(path, options) {
  const slice = SLICE.exec(path);
  if (slice) wantSlice(slice[1]);
  const answer = await send(path, options);
  const { partial, lost } = await making;
  return { answer, json: async () => adapt(path, answer, partial, lost, JSON.parse(new TextDecoder().decode(answer.bytes))) };
}

// The number of workers is that of threads. A volume of which only a coarse level is there changes soon, unless the rest
// cannot be loaded.
function adapt(path, { level, part }, partial, lost, object) {
  if (path === "../1") return { ...object, threads: WORKERS };
  if (path !== "volumes" || (level === 0 && !part)) return object;
  const more = part ? { whole_level: 0, arrived_part: part, partial } : lost ? { whole_level: level } : { whole_level: 0, partial: true, arrived_level: partial ? level : 0 };
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
  const { view, quality } = request;
  if (quality === "still") want("view", (bricks, volume) => levelsOfView(bricks, volume, view));
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
