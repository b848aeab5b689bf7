// Base64 and gzip of the page's parts.

export function bytesOf(text) {
  const letters = atob(text);
  const bytes = new Uint8Array(letters.length);
  for (let i = 0; i < letters.length; i++) bytes[i] = letters.charCodeAt(i);
  return bytes;
}

const unzipped = (text) => new Response(new Blob([bytesOf(text)]).stream().pipeThrough(new DecompressionStream("gzip")));

// {source: URL of a worker's code, module: WebAssembly}, both from gzip in base64.
export async function unpack(code, wasm) {
  const text = await unzipped(code).text();
  const source = URL.createObjectURL(new Blob([text], { type: "text/javascript" }));
  return { source, module: await WebAssembly.compile(await unzipped(wasm).arrayBuffer()) };
}
