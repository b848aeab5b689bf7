// Opens volumes in the WebAssembly of a build folder, in this process, by the code of the page's workers.

import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import path from "node:path";

const web = path.join(import.meta.dirname ?? path.dirname(new URL(import.meta.url).pathname), "..", "..", "web");

// files: paths. Returns ask(method, path, body), which returns the answer of web/page/worker.js with `text()`.
export async function openInstance(buildFolder, ...files) {
  globalThis.createCvol = createRequire(import.meta.url)(path.resolve(buildFolder, "cvol_web.js"));
  const { obey } = new Function(`${readFileSync(path.join(web, "page", "worker.js"), "utf8")}; return { obey };`)();
  const module = await WebAssembly.compile(readFileSync(path.join(buildFolder, "cvol_web.wasm")));
  const named = files.map((file) => ({ name: path.basename(file), bytes: readFileSync(file) }));
  const volumes = named.map(({ name }) => ({ file: name, name, time: -1, channel: -1 }));
  const [opened] = await obey({ id: 0, open: { module, files: named, volumes, keepMb: 8 } });
  if (opened.failure) throw new Error(opened.failure);
  return async (method, where, body) => {
    const [answer] = await obey({ id: 1, method, path: `api/1${where}`, body: body && JSON.stringify(body) });
    if (answer.failure) throw new Error(answer.failure);
    answer.json = () => JSON.parse(new TextDecoder().decode(answer.bytes));
    return answer;
  };
}
