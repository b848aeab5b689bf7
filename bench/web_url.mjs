// The page of cvol export --site opens a file of a server by ?url=, over a slow line: bytes and time until each level
// is drawn. bench/web_url.sh starts it.
//
// usage: node web_url.mjs SITE_FOLDER FILE.cvol MBIT_PER_SECOND

import { createReadStream, readFileSync, statSync } from "node:fs";
import { createServer } from "node:http";
import path from "node:path";

import { openPage, startBrowser } from "../tests/viewer/browser.mjs";

const [site, file, rate] = process.argv.slice(2);
const PART = 16384; // bytes
const WAIT_MS = (PART * 8) / (Number(rate) * 1000);
const bytes = statSync(file).size;
let [sent, begin] = [0, 0];

async function sendSlowly(answer) {
  answer.writeHead(200, { "Content-Type": "application/octet-stream", "Content-Length": bytes });
  [sent, begin] = [0, performance.now()];
  for await (const part of createReadStream(file, { highWaterMark: PART })) {
    answer.write(part);
    sent += part.length;
    const ahead = (sent / PART) * WAIT_MS - (performance.now() - begin);
    if (ahead > 1) await new Promise((done) => setTimeout(done, ahead));
  }
  answer.end();
}

const server = createServer(({ url }, answer) => {
  const name = path.basename(new URL(url, "http://x/").pathname) || "index.html";
  if (name === "volume.cvol") return sendSlowly(answer);
  if (!["index.html", "convert.js"].includes(name)) return answer.writeHead(404).end();
  answer.writeHead(200, { "Content-Type": name.endsWith("html") ? "text/html; charset=utf-8" : "text/javascript" });
  return answer.end(readFileSync(path.join(site, name)));
});
await new Promise((done) => server.listen(0, "127.0.0.1", done));
const browser = await startBrowser();
const address = `http://127.0.0.1:${server.address().port}/?url=volume.cvol`;
const page = await openPage(browser, address, { ready: false, viewport: { width: 844, height: 600 } });
page.setDefaultTimeout(600000);

const seconds = () => ((performance.now() - begin) / 1000).toFixed(1);
const MB = (count) => (count / 1e6).toFixed(2);
const row = (what) => console.log(`| ${what} | ${MB(Math.min(sent, bytes))} | ${seconds()} |`);
const drawn = (from) => page.waitForFunction((n) => window.cvolTimings.length > n, from);
console.log(`# ?url= of ${MB(bytes)} MB at ${rate} Mbit/s\n\n| drawn | MB sent | s |\n|---|---:|---:|`);
await drawn(0);
row("the first picture");
for (const level of [2, 1, 0]) {
  // A picture that was requested when the page knew of the level.
  await page.waitForFunction((n) => {
    if ((window.cvol.volumes.current()?.arrived_level ?? 0) > n) return false;
    window.knownSince ??= performance.now() - 30;
    return window.cvolTimings.some(({ requested }) => requested > window.knownSince);
  }, level);
  await page.evaluate(() => delete window.knownSince);
  row(level ? `level ${level}` : "the whole file");
}
console.log(`\nThe last byte arrives after ${((bytes / PART) * WAIT_MS / 1000).toFixed(1)} s.`);
await browser.close();
server.close();
