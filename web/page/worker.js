// A worker with one WebAssembly instance (web/instance.c): it opens the volumes, or gets the memory of an instance that
// has them, then answers requests one after the other. The page puts the code of emscripten, which makes createCvol,
// before this one.

const FOLDER = "/volumes";
let cvol = null;

async function begin(module) {
  cvol = await createCvol({
    instantiateWasm(imports, done) {
      WebAssembly.instantiate(module, imports).then((instance) => done(instance, module));
      return {};
    },
  });
}

// The address of a text in the instance's memory, which the caller frees. Zero bytes separate parts.
function place(text) {
  const bytes = new TextEncoder().encode(text);
  const at = cvol._malloc(bytes.length + 2);
  cvol.HEAPU8.set(bytes, at);
  cvol.HEAPU8.fill(0, at + bytes.length, at + bytes.length + 2);
  return [at, bytes.length];
}

// The bytes of a file of which there are pieces: the others are 0.
function joinPieces({ size, pieces }) {
  const all = new Uint8Array(size);
  for (const { from, bytes } of pieces) all.set(bytes, from);
  return all;
}

// Files in the instance's memory file system, which its memory does not have. files: [{name, bytes}], or [{name, size,
// pieces: [{from, bytes}]}]
function putFiles(files) {
  if (!cvol.FS.analyzePath(FOLDER).exists) cvol.FS.mkdir(FOLDER);
  cvol.FS.chdir(FOLDER);
  for (const file of files) {
    const bytes = file.pieces ? joinPieces(file) : new Uint8Array(file.bytes);
    cvol.FS.writeFile(file.name, bytes, { canOwn: true });
  }
}

// Gives the volumes of the last file the levels of their bricks, which the instance keeps.
function setBricks(levels) {
  const at = cvol._malloc(levels.length);
  cvol.HEAPU8.set(levels, at);
  cvol._web_set_bricks(at, levels.length);
}

// volumes: [{file (its name), name, time, channel, labels, brickLevels}]; time and channel -1: all; labels, if there are
// any: [[value, name or null, [r, g, b] or null], ...] in rising order; brickLevels: of a file of which bricks have
// levels. level: of all volumes. ready: all of them are open; else error is the first sentence. lossy: none lacks a
// residual, which labels and exact values have. series: later times are read from the files.
function open({ files, volumes, keepMb, level }) {
  putFiles(files);
  const types = ["string", "string", "number", "number", "number"];
  for (const { file, name, time, channel, labels = [], brickLevels } of volumes) {
    let failed = cvol.ccall("web_add", "number", types, [file, name, time, channel, level]);
    if (brickLevels) setBricks(brickLevels);
    for (const [value, text, colour] of labels) {
      const given = [value, text ?? "", ...(colour ?? [-1, 0, 0])];
      failed ||= cvol.ccall("web_add_label", "number", ["number", "string", "number", "number", "number"], given);
    }
    if (failed) throw new Error(`not enough memory for ${name}`);
  }
  if (cvol.ccall("web_open", "number", ["number"], [keepMb])) throw new Error("not enough memory for the volumes");
  const { bytes } = answer({ method: "GET", path: "api/1/volumes" });
  const made = JSON.parse(new TextDecoder().decode(bytes)).volumes;
  const series = made.some(({ times }) => times > 1);
  if (!series) for (const { name } of files) cvol.FS.unlink(name);
  const ready = made.every(({ state }) => state === "ready");
  const error = made.find(({ state }) => state !== "ready")?.error;
  return { ready, error, lossy: made.every(({ residual_missing: part }) => !part), series };
}

// Continues from the memory of another instance, which is not changed; files: of a series.
function load(memory, files) {
  if (!cvol._web_memory_grow(memory.byteLength)) throw new Error("not enough memory for the volumes");
  cvol.HEAPU8.set(new Uint8Array(memory));
  cvol.HEAPU8.fill(0, memory.byteLength);
  if (files) putFiles(files);
  return { memory };
}

// {status, type, bytes, frame (the header Cvol-Frame), size ([width, height] of pixels)}
function answer({ method, path, body }) {
  const [name, search = ""] = path.split("?");
  const query = [...new URLSearchParams(search)].map(([key, value]) => `${key}=${value}\0`).join("");
  const placed = [method, name, query, body ?? ""].map(place);
  const status = cvol._web_request(...placed.map(([at]) => at), body === undefined ? 0 : placed[3][1]);
  placed.forEach(([at]) => cvol._free(at));
  const from = cvol._web_answer_bytes();
  const header = (key) => cvol.ccall("web_answer_header", "string", ["string"], [key]);
  return {
    status,
    type: cvol.ccall("web_answer_type", "string", [], []),
    bytes: cvol.HEAPU8.slice(from, from + cvol._web_answer_size()).buffer,
    frame: header("Cvol-Frame"),
    size: header("Cvol-Size").split(" ").map(Number),
  };
}

let ready = null;

// Messages: {begin: module}, {open: what open() needs, lend: true if the answer has the memory}, {load: memory, files},
// and requests. An answer has {heap (bytes of memory)} and what the functions above return, or {failure: sentence,
// stopped: whether the program has broken off}.
async function obey({ id, begin: module, open: what, lend, load: memory, files, ...request }) {
  try {
    let result = {};
    if (module) ready = begin(module);
    await ready;
    if (what) result = open(what);
    if (memory) result = load(memory, files);
    if (lend) result = { ...result, memory: cvol.HEAPU8.slice(0, cvol._web_memory_used()).buffer };
    else if (request.path) result = answer(request);
    const given = result.bytes ?? result.memory;
    return [{ id, ...result, heap: cvol.HEAPU8.length }, given ? [given] : []];
  } catch (error) {
    const stopped = error instanceof WebAssembly.RuntimeError || error instanceof RangeError;
    return [{ id, failure: error.message || String(error), stopped }, []];
  }
}

if (typeof self !== "undefined") self.onmessage = async ({ data }) => self.postMessage(...(await obey(data)));
