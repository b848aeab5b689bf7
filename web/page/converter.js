// A worker that makes a .cvol file from a file of another format (web/convert.c), once. The page puts the code of
// emscripten, which makes createConverter, before this one.

const FOLDER = "/files";

async function convert({ module, name, bytes }, progress) {
  const cvol = await createConverter({
    onProgress: progress,
    instantiateWasm(imports, done) {
      WebAssembly.instantiate(module, imports).then((instance) => done(instance, module));
      return {};
    },
  });
  cvol.FS.mkdir(FOLDER);
  cvol.FS.chdir(FOLDER);
  cvol.FS.writeFile(name, new Uint8Array(bytes), { canOwn: true });
  const failure = cvol.ccall("convert_file", "string", ["string"], [name]);
  if (failure) return { failure };
  const from = cvol._converted_bytes();
  return { bytes: cvol.HEAPU8.slice(from, from + cvol._converted_size()).buffer };
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
