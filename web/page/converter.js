// A worker that makes a .cvol file from a file of another format (web/convert.c), once. Of several DICOM series the page
// chooses one. The page puts the code of emscripten, which makes createConverter, before this one.

const FOLDER = "/files";
const OUT = "/converted.cvol";

// [{key, description, slices}, ...] of a folder of DICOM files.
function seriesOf(cvol, folder) {
  const list = cvol.ccall("convert_list_series", "string", ["string"], [folder]);
  return list.split("\x1e").slice(0, -1).map((record) => {
    const [key, description, slices] = record.split("\x1f");
    return { key, description, slices: Number(slices) };
  });
}

// name: of a file, or of a folder, of which all files are read. files: [{name: path, bytes}]; some have the samples of
// others, which are headers. choose(series) resolves with the key of one.
async function convert({ module, name, files }, progress, choose) {
  const cvol = await createConverter({
    onProgress: progress,
    instantiateWasm(imports, done) {
      WebAssembly.instantiate(module, imports).then((instance) => done(instance, module));
      return {};
    },
  });
  cvol.FS.mkdir(FOLDER);
  cvol.FS.chdir(FOLDER);
  for (const { name: path, bytes } of files) {
    const end = path.lastIndexOf("/");
    if (end > 0) cvol.FS.mkdirTree(`${FOLDER}/${path.slice(0, end)}`);
    cvol.FS.writeFile(path, new Uint8Array(bytes), { canOwn: true });
  }
  const series = files.length > 1 ? seriesOf(cvol, name) : [];
  const key = series.length > 1 ? await choose(series) : "";
  const failure = cvol.ccall("convert_file", "string", ["string", "string", "string"], [name, key, OUT]);
  if (failure) return { failure };
  cvol.FS.chmod(OUT, 0o600); // emscripten knows no umask
  return { bytes: cvol.FS.readFile(OUT).buffer };
}

async function convertSafely(data, ...functions) {
  try {
    return await convert(data, ...functions);
  } catch (error) {
    return { failure: `${data.name}: needs more memory than a page has (${error.message}): use cvol compress` };
  }
}

// Messages: what convert() needs, then the key of a series if it was asked for. Answers: {doing, fraction}, {series: of
// which one is to be chosen}, {failure} or {bytes}.
let chosen = null;
const progress = (doing, fraction) => self.postMessage({ doing, fraction });
const choose = (series) => {
  self.postMessage({ series });
  return new Promise((resolve) => (chosen = resolve));
};

if (typeof self !== "undefined")
  self.onmessage = async ({ data }) => {
    if (chosen) return chosen(data.key);
    const result = await convertSafely(data, progress, choose);
    self.postMessage(result, result.bytes ? [result.bytes] : []);
  };
