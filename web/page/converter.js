// A worker that makes a .cvol file from a file of another format (web/convert.c), once. The page puts the code of
// emscripten, which makes createConverter, before this one.

const FOLDER = "/files";
const OUT = "/converted.cvol";

// name: of a file, or of a folder, of which all files are read. files: [{name: path, bytes}]; some have the samples of
// others, which are headers.
async function convert({ module, name, files }, progress) {
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
  const failure = cvol.ccall("convert_file", "string", ["string", "string"], [name, OUT]);
  if (failure) return { failure };
  cvol.FS.chmod(OUT, 0o600); // emscripten knows no umask
  return { bytes: cvol.FS.readFile(OUT).buffer };
}

async function convertSafely(data, progress) {
  try {
    return await convert(data, progress);
  } catch (error) {
    return { failure: `${data.name}: needs more memory than a page has (${error.message}): use cvol compress` };
  }
}

if (typeof self !== "undefined")
  self.onmessage = async ({ data }) => {
    const result = await convertSafely(data, (doing, fraction) => self.postMessage({ doing, fraction }));
    self.postMessage(result, result.bytes ? [result.bytes] : []);
  };
