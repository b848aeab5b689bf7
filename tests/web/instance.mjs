// Opens volumes in the WebAssembly of a build folder, in this process, by the code of the page's workers.

import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import path from "node:path";

const web = path.join(import.meta.dirname ?? path.dirname(new URL(import.meta.url).pathname), "..", "..", "web");

// A worker's function obey(message), with an instance of its own.
function startWorker(buildFolder) {
  globalThis.createCvol = createRequire(import.meta.url)(path.resolve(buildFolder, "cvol_web.js"));
  const code = readFileSync(path.join(web, "page", "worker.js"), "utf8");
  const { obey } = new Function(`${code}; return { obey };`)();
  return async (message) => {
    const [answer] = await obey({ id: 0, ...message });
    if (answer.failure) throw Object.assign(new Error(answer.failure), { stopped: answer.stopped });
    if (answer.bytes) answer.json = () => JSON.parse(new TextDecoder().decode(answer.bytes));
    return answer;
  };
}

const asker = (obey) => (method, where, body) =>
  obey({ method, path: `api/1${where}`, body: body && JSON.stringify(body) });

const compiled = new Map();
const compile = (buildFolder) => {
  if (!compiled.has(buildFolder)) compiled.set(buildFolder, WebAssembly.compile(readFileSync(path.join(buildFolder, "cvol_web.wasm"))));
  return compiled.get(buildFolder);
};

function openingOf(files) {
  const named = files.map((file) => ({ name: path.basename(file), bytes: readFileSync(file) }));
  const volumes = named.map(({ name }) => ({ file: name, name, time: -1, channel: -1 }));
  return { files: named, volumes, keepMb: 8 };
}

// The function ask(method, path, body) of one instance that has opened the files at a level.
export async function startInstance(buildFolder, files, level) {
  const obey = startWorker(buildFolder);
  await obey({ begin: await compile(buildFolder), open: { ...openingOf(files), level } });
  return asker(obey);
}

// files: paths. As in the page, one instance opens the volumes, another one their coarse levels; then this one gets the
// memory of the first. Returns the functions ask(method, path, body) of the first, the coarse one and the copy; each
// returns the answer of web/page/worker.js with `json()`.
export async function openInstances(buildFolder, ...files) {
  const module = await compile(buildFolder);
  const [first, second] = [startWorker(buildFolder), startWorker(buildFolder)];
  const opening = openingOf(files);
  await second({ begin: module, open: { ...opening, level: 2 } });
  const coarse = asker(second);
  const { memory } = await first({ begin: module, open: { ...opening, level: 0 }, lend: true });
  return { whole: asker(first), coarse, copy: () => second({ load: memory }).then(() => coarse) };
}
