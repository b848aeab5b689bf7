// Base64 and gzip of the page's parts.

export function bytesOf(text) {
  const letters = atob(text);
  const bytes = new Uint8Array(letters.length);
  for (let i = 0; i < letters.length; i++) bytes[i] = letters.charCodeAt(i);
  return bytes;
}

const unzipped = (text) => new Response(new Blob([bytesOf(text)]).stream().pipeThrough(new DecompressionStream("gzip")));

// The URL of a worker's code.
export async function unpackCode(text) {
  return URL.createObjectURL(new Blob([await unzipped(text).text()], { type: "text/javascript" }));
}

export async function unpackModule(text) {
  return WebAssembly.compile(await unzipped(text).arrayBuffer());
}
