// A worker with one WebAssembly instance (web/instance.c): it opens the volumes, then answers requests one after the
// other. The page puts the code of emscripten, which makes createCvol, before this one.

const FOLDER = "/volumes";
let cvol = null;

// The address of a text in the instance's memory, which the caller frees. Zero bytes separate parts.
function place(text) {
  const bytes = new TextEncoder().encode(text);
  const at = cvol._malloc(bytes.length + 2);
  cvol.HEAPU8.set(bytes, at);
  cvol.HEAPU8.fill(0, at + bytes.length, at + bytes.length + 2);
  return [at, bytes.length];
}

// module: a compiled WebAssembly module. files: [{name, bytes}]. volumes: [{file (its name), name, time, channel}].
async function open({ module, files, volumes, keepMb }) {
  cvol = await createCvol({
    instantiateWasm(imports, done) {
      WebAssembly.instantiate(module, imports).then((instance) => done(instance, module));
      return {};
    },
  });
  cvol.FS.mkdir(FOLDER);
  cvol.FS.chdir(FOLDER);
  for (const { name, bytes } of files) cvol.FS.writeFile(name, new Uint8Array(bytes), { canOwn: true });
  for (const { file, name, time, channel } of volumes)
    if (cvol.ccall("web_add", "number", ["string", "string", "number", "number"], [file, name, time, channel]))
      throw new Error(`not enough memory for ${name}`);
  if (cvol.ccall("web_open", "number", ["number"], [keepMb])) throw new Error("not enough memory for the volumes");
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
    heap: cvol.HEAPU8.length,
  };
}

let ready = null;

async function obey({ id, open: what, ...request }) {
  try {
    if (what) ready = open(what);
    await ready;
    const result = what ? {} : answer(request);
    return [{ id, ...result }, result.bytes ? [result.bytes] : []];
  } catch (error) {
    return [{ id, failure: error.message || String(error) }, []];
  }
}

if (typeof self !== "undefined") self.onmessage = async ({ data }) => self.postMessage(...(await obey(data)));
