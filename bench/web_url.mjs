// The page of cvol export --site opens a file of a server by ?url=, over a slow line: bytes and time until each picture
// is drawn. bench/web_url.sh starts it.
//
// usage: node web_url.mjs SITE_FOLDER FILE.cvol MBIT_PER_SECOND

import { openSync, readFileSync, readSync, statSync } from "node:fs";
import { createServer } from "node:http";
import path from "node:path";

import { openPage, startBrowser } from "../tests/viewer/browser.mjs";

const [site, file, rate] = process.argv.slice(2);
const PART = 16384; // bytes
const WAIT_MS = (PART * 8) / (Number(rate) * 1000);
const bytes = statSync(file).size;
const opened = openSync(file);
let [sent, begin] = [0, 0];
let free = 0; // when the line is free again

// All answers share the line.
async function sendSlowly(answer, from, to) {
  for (let at = from; at < to && !answer.destroyed; at += PART) {
    const part = Buffer.alloc(Math.min(PART, to - at));
    readSync(opened, part, 0, part.length, at);
    free = Math.max(free, performance.now()) + (part.length / PART) * WAIT_MS;
    const ahead = free - performance.now();
    if (ahead > 1) await new Promise((done) => setTimeout(done, ahead));
    if (answer.destroyed) return;
    answer.write(part);
    sent += part.length;
  }
  answer.end();
}

function serveFile({ headers }, answer) {
  const range = /^bytes=(\d+)-(\d*)$/.exec(headers.range ?? "");
  const [from, to] = range ? [Number(range[1]), range[2] ? Number(range[2]) + 1 : bytes] : [0, bytes];
  if (!range) [sent, begin] = [0, performance.now()];
  const told = range ? { "Content-Range": `bytes ${from}-${to - 1}/${bytes}` } : {};
  answer.writeHead(range ? 206 : 200, { "Content-Type": "application/octet-stream", "Content-Length": to - from, ...told });
  return sendSlowly(answer, from, to);
}

const server = createServer((request, answer) => {
  const name = path.basename(new URL(request.url, "http://x/").pathname) || "index.html";
  if (name === "volume.cvol") return serveFile(request, answer);
  if (!["index.html", "convert.js"].includes(name)) return answer.writeHead(404).end();
  answer.writeHead(200, { "Content-Type": name.endsWith("html") ? "text/html; charset=utf-8" : "text/javascript" });
  return answer.end(readFileSync(path.join(site, name)));
});
await new Promise((done) => server.listen(0, "127.0.0.1", done));
const browser = await startBrowser();
const address = `http://127.0.0.1:${server.address().port}/?url=volume.cvol`;
const page = await openPage(browser, address, { ready: false, viewport: { width: 844, height: 600 } });
page.setDefaultTimeout(600000);

const MB = (count) => (count / 1e6).toFixed(2);
const row = (what, since) =>
  console.log(`| ${what} | ${MB(sent)} | ${((performance.now() - since) / 1000).toFixed(1)} |`);

const isFinal = async () => {
  await window.cvol.volumes.refresh();
  const { partial, arrived_level: level = 0 } = window.cvol.volumes.current();
  const { frame, pending } = window.cvol.view3d;
  const isDrawn = frame?.view === window.cvol.store.state.view && frame.timing.quality === "still" && !pending;
  return !partial && !level && isDrawn;
};

// Waits for the picture of all that the view needs.
async function finalPicture(what, since) {
  while (!(await page.evaluate(isFinal))) await page.waitForTimeout(50);
  row(what, since);
}

console.log(`# ?url= of ${MB(bytes)} MB at ${rate} Mbit/s\n\n| drawn | MB sent in all | s since it was asked for |\n|---|---:|---:|`);
await page.waitForFunction(() => window.cvolTimings.length > 0);
row("the first picture", begin);
await finalPicture("the final picture", begin);
await page.screenshot({ path: path.join(process.env.CVOL_SHOTS, "url-whole-view.png") });
async function change(patch, what) {
  const since = performance.now();
  await page.evaluate((view) => window.cvol.store.set({ view }), patch);
  await finalPicture(what, since);
}
const { zoom } = await page.evaluate(() => window.cvol.store.state.view.camera);
await change({ camera: { zoom: 5 * zoom } }, "after a zoom to five times the size");
await page.screenshot({ path: path.join(process.env.CVOL_SHOTS, "url-zoom.png") });
await change({ camera: { azimuth: 0, elevation: 0 } }, "after a turn");
console.log(`\nThe whole file takes ${((bytes / PART) * (WAIT_MS / 1000)).toFixed(1)} s.`);
await browser.close();
server.close();
