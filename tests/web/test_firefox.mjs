// Tests a page of cvol export in Firefox, from file://, without WebGL: the picture appears in full quality, and slices
// show.
//
// usage: test_firefox.mjs FIREFOX PAGE.html, with CVOL_SHOTS as tests/viewer/test_browser.mjs

import assert from "node:assert/strict";
import { mkdirSync } from "node:fs";
import path from "node:path";
import { pathToFileURL } from "node:url";

import { startFirefox } from "./firefox.mjs";

const [program, file] = process.argv.slice(2);
const { CVOL_SHOTS: shots = "screenshots" } = process.env;
mkdirSync(shots, { recursive: true });

const settled = `(() => { const { view3d, store } = window.cvol ?? {};
  return view3d?.frame?.view === store?.state.view && !view3d?.pending && view3d?.frame?.timing.quality === "still"; })()`;
const bright = `(() => { const canvas = document.getElementById("canvas");
  const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  let count = 0; for (let i = 0; i < data.length; i++) count += i % 4 < 3 && data[i] > 40; return count; })()`;

const firefox = await startFirefox(program, 1280, 800);
try {
  await firefox.open(pathToFileURL(path.resolve(file)).href);
  await firefox.until(settled);
  assert.equal(await firefox.run("document.createElement('canvas').getContext('webgl')"), null);
  const first = await firefox.run(bright);
  assert.ok(first > 10000, `${first} bright bytes`);
  const [coarse] = await firefox.run("window.cvolTimings.map(({ shown }) => shown)");
  console.log(`Firefox: the first picture after ${Math.round(coarse)} ms, ${first} bright bytes`);
  await firefox.shot(path.join(shots, "firefox.png"));
  await firefox.run('window.cvol.store.set({ page: { layout: "slices" } })');
  await firefox.until(`[...document.querySelectorAll("#stage-slices canvas")].every(({ width }) => width > 10)`);
  await firefox.until(settled);
  await firefox.shot(path.join(shots, "firefox-slices.png"));
} finally {
  await firefox.end();
}
console.log("Firefox: all passed");
