// A page of cvol export in Chromium, from file://, without network: sizes, the time to the first picture, pictures in
// motion and at rest at 512 x 512, and memory. bench/web.sh starts it.
//
// usage: node web.mjs PAGE.html VIEWER.html CVOL_WEB.wasm REPEATS

import { readFileSync, statSync } from "node:fs";
import { cpus } from "node:os";
import { pathToFileURL } from "node:url";
import { gzipSync } from "node:zlib";

import { openPage, settled, startBrowser } from "../tests/viewer/browser.mjs";

const [file, viewer, wasm, repeats] = process.argv.slice(2);
const FRAMES = 90;
const BUDGET_MS = 55; // of 15 frames per second, without what the page adds

const median = (values) => [...values].sort((a, b) => a - b)[values.length >> 1];
const range = (values) => `${Math.round(Math.min(...values))} | ${Math.round(median(values))}`;
const browser = await startBrowser();
const first = [];
const rest = [];
let page = null;
for (let k = 0; k < Number(repeats); k++) {
  await page?.context().close();
  page = await openPage(browser, pathToFileURL(file).href, { viewport: { width: 844, height: 600 }, offline: true });
  const shown = await page.evaluate(() => window.cvolTimings.map(({ shown: at, quality }) => [at, quality]));
  first.push(shown[0][0]);
  rest.push(shown.find(([, quality]) => quality === "still")[0]);
}

// Pictures one after the other from a turning camera.
const draw = (request, count, degrees) =>
  page.evaluate(
    async ([fields, frames, turn]) => {
      const { store, api } = window.cvol;
      const { volume, camera, light } = store.state.view;
      const times = [];
      const qualities = {};
      for (let k = 0; k < frames; k++) {
        const turned = { ...camera, azimuth: camera.azimuth + turn * k };
        const view = { volume, light, width: 512, height: 512, camera: turned };
        const begin = performance.now();
        const { blob, info } = await api.frame({ view, viewer: "bench", ...fields });
        (await createImageBitmap(blob)).close();
        times.push(performance.now() - begin);
        qualities[info.quality] = (qualities[info.quality] ?? 0) + 1;
      }
      return { times, qualities };
    },
    [request, count, degrees],
  );
await settled(page);
await draw({ quality: "motion", budget_ms: BUDGET_MS }, FRAMES, 2); // the browser compiles hot code again
const motion = await draw({ quality: "motion", budget_ms: BUDGET_MS }, FRAMES, 2);
const still = await draw({ quality: "still" }, 7, 7);
const heap = await page.evaluate(() => window.cvolHeap());
await browser.close();

const zip = (name) => gzipSync(readFileSync(name), { level: 9 }).length / 1000;
const seconds = motion.times.reduce((sum, ms) => sum + ms, 0) / 1000;
console.log(`# cvol export --html, ${cpus().length} cores, ${cpus()[0].model}\n`);
console.log("| | least | median |\n|---|---|---|");
console.log(`| first picture after opening, ms | ${range(first)} |`);
console.log(`| full quality after opening, ms | ${range(rest)} |`);
console.log(`| picture in motion, 512 x 512, ms | ${range(motion.times)} |`);
console.log(`| picture at rest, 512 x 512, ms | ${range(still.times)} |`);
const qualities = Object.entries(motion.qualities).map(([name, count]) => `${count} ${name}`);
const MB = (bytes) => `${(bytes / 1e6).toFixed(2)} MB`;
console.log(`\n${(FRAMES / seconds).toFixed(1)} pictures per second in motion: ${qualities.join(", ")}`);
console.log(`Page ${MB(statSync(file).size)}, without volumes ${MB(statSync(viewer).size)}`);
console.log(`WebAssembly ${zip(wasm).toFixed(0)} kB by gzip, its memory ${MB(heap)}`);
