// An instance of the WebAssembly in Node for bench/web_native.py: prints how long it took to open the volume, then answers
// each line, a request for a frame, by a line with its time.
//
// usage: node web_native.mjs WEB_FOLDER VOLUME.cvol

import { createInterface } from "node:readline";

import { startInstance } from "../tests/web/instance.mjs";

const [web, file] = process.argv.slice(2);
const say = (object) => console.log(JSON.stringify(object));
const begin = performance.now();
const ask = await startInstance(web, [file], 0);
say({ opening_ms: performance.now() - begin });
for await (const line of createInterface({ input: process.stdin })) {
  const { status, frame, json } = await ask("POST", "/frame", JSON.parse(line));
  if (status !== 200) throw new Error(json().error);
  say({ render_ms: JSON.parse(frame).render_ms });
}
