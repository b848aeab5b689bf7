// Reads .cvol files and draws them (README.md).

import createCvol from "./cvol.mjs";
import { arrive, isCvol } from "./arrival.mjs";
import { homeCamera } from "./camera.mjs";
import { DEFAULT_VIEW } from "./default_view.mjs";

const FILE = "/file.cvol";
const TYPES = {
  uint8: Uint8Array,
  int8: Int8Array,
  uint16: Uint16Array,
  int16: Int16Array,
  uint32: Uint32Array,
  int32: Int32Array,
  float32: Float32Array,
  float64: Float64Array,
};
// Bytes of the block cache of a renderer: pictures that follow each other are faster.
const KEEP_MB = 64;

// In Node the code is read from the package's folder, in browsers and workers it is fetched.
async function start() {
  if (typeof process === "undefined" || !process.versions?.node) return createCvol();
  const { readFile } = await import("node:fs/promises");
  return createCvol({ wasmBinary: await readFile(new URL("./cvol.wasm", import.meta.url)) });
}

const asBytes = (source) =>
  source instanceof Uint8Array
    ? source
    : ArrayBuffer.isView(source)
      ? new Uint8Array(source.buffer, source.byteOffset, source.byteLength)
      : new Uint8Array(source);

function check(cvol, sentence) {
  if (!sentence) return;
  throw new Error(sentence.replace(`${FILE}: `, ""));
}

// ---- decoding -----------------------------------------------------------------------------------

let decoder = null; // the promise of an instance: one file at a time is open in it

// A start that fails, because the network does, say, is tried again by the next call.
const startDecoder = () =>
  (decoder ??= start().catch((error) => {
    decoder = null;
    throw error;
  }));

function checkNumbers(numbers) {
  for (const [name, value] of Object.entries(numbers))
    if (!Number.isInteger(value) || value < -1 || value > 2 ** 31 - 1)
      throw new Error(`${name} is ${value}, must be an integer from 0 on`);
}

// Decodes samples. bytes: a .cvol file, or its beginning with a level; { level, box: [x0, y0, z0, x1, y1, z1], time,
// channel }.
export async function decode(bytes, { level = 0, box, time = 0, channel = 0 } = {}) {
  checkNumbers({ level, time, channel });
  if (box && box.length !== 6) throw new Error(`a box has six numbers, not ${box.length}`);
  if (box) checkNumbers(Object.fromEntries(box.map((at, i) => [`box[${i}]`, at])));
  const cvol = await startDecoder();
  cvol.FS.writeFile(FILE, asBytes(bytes));
  try {
    check(cvol, cvol.ccall("decode_open", "string", ["string", "number", "number", "number"], [FILE, time, channel, level]));
    const about = JSON.parse(cvol.ccall("decode_describe", "string", [], []));
    const factor = 2 ** about.level;
    const size = about.shape.map((n) => Math.ceil(n / factor));
    const [x0, y0, z0, x1, y1, z1] = box ?? [0, 0, 0, ...size];
    check(cvol, cvol.ccall("decode_box", "string", Array(6).fill("number"), [x0, y0, z0, x1, y1, z1]));
    const shape = [x1 - x0, y1 - y0, z1 - z0];
    const Samples = TYPES[about.type];
    const count = shape[0] * shape[1] * shape[2];
    const from = cvol._decode_samples();
    const data = new Samples(cvol.HEAPU8.slice(from, from + count * Samples.BYTES_PER_ELEMENT).buffer);
    // The centre of the first sample, in samples of the volume.
    const first = [x0, y0, z0].map((at) => at * factor + (factor - 1) / 2);
    const { origin, directions, spacing } = about;
    return {
      ...about,
      data,
      shape,
      spacing: spacing.map((length) => length * factor),
      origin: origin.map((at, i) => first.reduce((sum, s, a) => sum + s * spacing[a] * directions[3 * a + i], at)),
    };
  } finally {
    cvol._decode_close();
    cvol.FS.unlink(FILE);
  }
}

// ---- ranges of a file on a server ---------------------------------------------------------------

// Loads a file by HTTP: all of it or, with a level of 1 to 3, only its beginning with that level. { level, headers,
// signal, fetch, onProgress(bytes, total), limit (bytes) }.
export async function openRange(url, { level = 0, headers, signal, fetch, onProgress, limit = 2 ** 31 } = {}) {
  if (![0, 1, 2, 3].includes(level)) throw new Error(`level is ${level}, must be 0 to 3`);
  signal?.throwIfAborted();
  const address = addressOf(url);
  const name = nameOf(address);
  const stop = new AbortController();
  const abort = () => stop.abort(signal.reason);
  signal?.addEventListener("abort", abort);
  try {
    return await load(address, name, stop, { level, headers, fetch, onProgress, limit });
  } finally {
    signal?.removeEventListener("abort", abort);
  }
}

function addressOf(url) {
  try {
    return new URL(url, globalThis.location?.href);
  } catch {
    throw new Error(`${url}: is no address; outside of a page it must be a whole one`);
  }
}

function nameOf({ pathname }) {
  const name = pathname.split("/").pop();
  try {
    return decodeURIComponent(name);
  } catch {
    return name;
  }
}

async function load(address, name, stop, { level, headers, fetch, onProgress, limit }) {
  let loaded = 0;
  const arriving = arrive(address, name, {
    progress(bytes, total) {
      loaded = bytes;
      onProgress?.(bytes, total);
    },
    // With a level, only what is loaded counts.
    refuse(bytes) {
      const counted = level > 0 ? loaded : bytes;
      if (counted > limit) throw new Error(`${name}: has ${bytes} bytes, and the limit is ${limit}`);
    },
    options: { headers, signal: stop.signal, fetch },
  });
  const whole = arriving.whole;
  whole.catch(() => {}); // after a level, the rest is not wanted
  const head = await arriving.head;
  if (!isCvol(head)) {
    stop.abort();
    throw new Error(`${name}: is not a .cvol file`);
  }
  const coarse = level > 0 ? await arriving.level(level) : null;
  const bytes = new Uint8Array(coarse ?? (await whole));
  if (coarse) stop.abort();
  return new CvolFile(bytes, level);
}

// A file in memory, or the beginning of one, which decodes and draws this level or coarser ones.
export class CvolFile {
  constructor(bytes, level = 0) {
    this.bytes = asBytes(bytes);
    this.level = level;
  }

  decode({ level = this.level, ...options } = {}) {
    return decode(this.bytes, { level: Math.max(level, this.level), ...options });
  }
}

// ---- pictures -----------------------------------------------------------------------------------

// Draws one volume: pictures of the same renderer share what they need. Free it by close().
export class Renderer {
  #cvol = null;
  #volume = null;

  // source: bytes, or a CvolFile. { time, channel } for files of several volumes.
  static async create(source, { time = 0, channel = 0, name = "volume.cvol" } = {}) {
    const renderer = new Renderer();
    const { bytes, level } = source instanceof CvolFile ? source : new CvolFile(source);
    const cvol = (renderer.#cvol = await start());
    cvol.FS.writeFile(FILE, bytes);
    const types = ["string", "string", "number", "number", "number"];
    if (cvol.ccall("web_add", "number", types, [FILE, name, time, channel, level])) throw new Error("not enough memory");
    if (cvol.ccall("web_open", "number", ["number"], [KEEP_MB])) throw new Error("not enough memory");
    cvol.FS.unlink(FILE);
    const { volumes } = JSON.parse(new TextDecoder().decode(renderer.#ask("GET", "volumes").bytes));
    renderer.#volume = volumes[0];
    if (renderer.#volume.state !== "ready") throw new Error(renderer.#volume.error.replace(`${FILE}: `, ""));
    return renderer;
  }

  // What doc/viewer-api.md calls a VOLUME.
  get volume() {
    return this.#volume;
  }

  // view: fields of a VIEW (doc/viewer-api.md). What is not given is as in the viewer: studio light, the volume's own
  // transfer function, and a camera that fits it. Returns { width, height, data }: bytes R G B A, the top row first.
  draw(view = {}) {
    const { width = 512, height = 512 } = view;
    const [volume] = [this.#volume];
    const { light, camera, ...rest } = view;
    const home = homeCamera(volume, width, height);
    const asked = {
      volume: volume.id,
      mirror: volume.mirrored,
      camera: { ...home, ...camera },
      light: { ...DEFAULT_VIEW.light, on: volume.home?.lit ?? true, ...light },
      ...rest,
      width,
      height,
    };
    const { status, bytes } = this.#ask("POST", "frame", JSON.stringify({ view: asked }));
    if (status !== 200) throw new Error(JSON.parse(new TextDecoder().decode(bytes)).error);
    return { width, height, data: new Uint8ClampedArray(bytes.buffer, bytes.byteOffset, bytes.length) };
  }

  close() {
    this.#cvol = null;
  }

  #place(text) {
    const bytes = new TextEncoder().encode(text);
    const at = this.#cvol._malloc(bytes.length + 2);
    this.#cvol.HEAPU8.set(bytes, at);
    this.#cvol.HEAPU8.fill(0, at + bytes.length, at + bytes.length + 2);
    return [at, bytes.length];
  }

  #ask(method, path, body) {
    const cvol = this.#cvol;
    if (!cvol) throw new Error("the renderer is closed");
    const placed = [method, `api/1/${path}`, "", body ?? ""].map((text) => this.#place(text));
    const status = cvol._web_request(...placed.map(([at]) => at), body === undefined ? 0 : placed[3][1]);
    placed.forEach(([at]) => cvol._free(at));
    const from = cvol._web_answer_bytes();
    return { status, bytes: cvol.HEAPU8.slice(from, from + cvol._web_answer_size()) };
  }
}

// Draws a picture of a source onto a canvas (HTMLCanvasElement or OffscreenCanvas), in its size unless the view has
// one; without a canvas (null) it only returns the pixels. source: bytes, a CvolFile, or a Renderer.
export async function render(canvas, source, view = {}) {
  const renderer = source instanceof Renderer ? source : await Renderer.create(source);
  const size = canvas ? { width: canvas.width, height: canvas.height } : {};
  const picture = renderer.draw({ ...size, ...view });
  if (renderer !== source) renderer.close();
  if (canvas) {
    canvas.width = picture.width;
    canvas.height = picture.height;
    const context = canvas.getContext("2d");
    if (!context) throw new Error("the canvas has another context than 2d");
    context.putImageData(new ImageData(picture.data, picture.width, picture.height), 0, 0);
  }
  return picture;
}
