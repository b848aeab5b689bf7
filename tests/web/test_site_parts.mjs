// Tests the page of cvol export --site with ?url= of a large file on a server that answers ranges: the page loads the
// bricks that its view needs, and its pictures are those of the whole file.
//
// usage: test_site_parts.mjs SITE_FOLDER FILES_FOLDER CVOL, with CVOL_BROWSER_MODULES, CVOL_CHROMIUM and CVOL_SHOTS as
// tests/viewer/test_browser.mjs. It makes files in FILES_FOLDER.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { closeSync, existsSync, mkdirSync, openSync, readFileSync, writeFileSync, writeSync } from "node:fs";
import { createServer } from "node:http";
import path from "node:path";

import { directions, projector, worldOf } from "../../viewer/page/state/camera.js";
import { bricksOf } from "../../web/page/bricks.js";
import { levelsOfView } from "../../web/page/needs.js";
import { branchOff } from "../../web/page/ranged.js";
import { openPage, settled, shotPath, startBrowser } from "../viewer/browser.mjs";

const [site, folder, cvol] = process.argv.slice(2).map((name) => path.resolve(name));
mkdirSync(folder, { recursive: true });
const file = (name) => path.join(folder, name);
const run = (...words) => execFileSync(cvol, words, { stdio: "ignore" });

// ---- files ------------------------------------------------------------------------------------

const SIDE = 288;

// Noisy shells around a centre, as bytes: a file of 1/4 has about 6 MB.
function writeVolume(name) {
  const out = openSync(name, "w");
  writeSync(out, `NRRD0004\ntype: uint8\ndimension: 3\nsizes: ${SIDE} ${SIDE} ${SIDE}\nencoding: raw\n\n`);
  let state = 1;
  const slice = Buffer.alloc(SIDE * SIDE);
  for (let z = 0; z < SIDE; z++) {
    for (let y = 0; y < SIDE; y++)
      for (let x = 0; x < SIDE; x++) {
        state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
        const radius = Math.hypot(x - 150, y - 140, z - 130);
        const value = radius > 135 ? 20 : 90 + 60 * Math.cos(radius / 6);
        slice[y * SIDE + x] = value + (state >>> 24) / 8;
      }
    writeSync(out, slice);
  }
  closeSync(out);
}

writeVolume(file("large.nrrd"));
run("compress", file("large.nrrd"), file("large.cvol"), "--ratio", "4", "--fast", "--background", "none");
run("compress", file("large.nrrd"), file("small-bricks.cvol"), "--ratio", "4", "--fast", "--background", "none", "--bricks",
  "32,32,32");
run("compress", file("large.nrrd"), file("bounded.cvol"), "--max-error", "8", "--fast");
const large = readFileSync(file("large.cvol"));

// ---- a server ---------------------------------------------------------------------------------

// Words before a name: `plain-`: it answers no ranges; `busy-`: it fails each first request of a range; `other-`: the
// file is another one after the heads of the shells; `damaged-`: a brick of it is.
let sent = 0;
let ranges = [];
const failedOnce = new Set();

function damaged(bytes) {
  const copy = Buffer.from(bytes);
  copy[Math.floor(0.9 * copy.length)] ^= 255;
  return copy;
}

function serve({ url, headers }, answer) {
  const name = path.basename(new URL(url, "http://x/").pathname) || "index.html";
  const word = /^(plain|busy|other|damaged)-/.exec(name)?.[1];
  const place = [path.join(site, name), file(word ? name.slice(word.length + 1) : name)].find((one) => existsSync(one));
  if (!place) return answer.writeHead(404).end();
  const bytes = word === "damaged" ? damaged(readFileSync(place)) : readFileSync(place);
  const type = { "Content-Type": name.endsWith("html") ? "text/html; charset=utf-8" : "application/octet-stream" };
  const range = word === "plain" ? null : /^bytes=(\d+)-(\d*)$/.exec(headers.range ?? "");
  if (!range) {
    answer.writeHead(200, { ...type, ETag: '"a"', "Content-Length": bytes.length });
    if (!name.endsWith(".cvol")) return answer.end(bytes);
    return sendSlowly(answer, bytes, word !== "plain" && bricksOf(bytes) !== null);
  }
  const [from, to] = [Number(range[1]), range[2] ? Number(range[2]) + 1 : bytes.length];
  if (word === "busy" && !failedOnce.has(from)) {
    failedOnce.add(from);
    return answer.writeHead(503).end();
  }
  ranges.push([from, to]);
  sent += to - from;
  const ETag = word === "other" && ranges.length > 3 ? '"b"' : '"a"';
  const told = { "Content-Range": `bytes ${from}-${to - 1}/${bytes.length}`, "Content-Length": to - from };
  answer.writeHead(206, { ...type, ...told, ETag });
  answer.end(bytes.subarray(from, to));
}

// After the coarse level so slowly that a page that asks for ranges can stop it.
async function sendSlowly(answer, bytes, hasRanges) {
  const PART = 32768;
  for (let at = 0; at < bytes.length && !answer.destroyed; at += PART) {
    answer.write(bytes.subarray(at, at + PART));
    sent += Math.min(PART, bytes.length - at);
    await new Promise((done) => setTimeout(done, hasRanges && at > 1e6 ? 500 : 3));
  }
  answer.end();
}

const server = createServer(serve);
await new Promise((done) => server.listen(0, "127.0.0.1", done));
const address = `http://127.0.0.1:${server.address().port}/`;

// ---- tests ------------------------------------------------------------------------------------

const browser = await startBrowser();
const tests = [];
const test = (name, fn) => tests.push([name, fn]);

async function begin(name, hash = "") {
  [sent, ranges] = [0, []];
  failedOnce.clear();
  return openPage(browser, `${address}?url=${name}`, { hash, ready: false, viewport: { width: 640, height: 420 } });
}

// Waits until the picture, and slices if there are any, show all that the view needs.
async function loaded(page) {
  for (let partial = true; partial; ) {
    await page.waitForFunction(() => window.cvol?.volumes.current()?.arrived_part > 0);
    await settled(page);
    partial = await page.evaluate(async () => {
      await window.cvol.volumes.refresh();
      return window.cvol.volumes.current().partial;
    });
  }
  await settled(page);
  await page.waitForFunction(() => {
    const part = String(window.cvol.volumes.current().arrived_part);
    return [...document.querySelectorAll(".slice[data-shown]")].every(({ dataset }) => dataset.shown.split(" ")[3] === part);
  });
}

async function whole(page) {
  await page.waitForFunction(() => {
    const volume = window.cvol?.volumes.current();
    return volume?.whole && !volume.partial && !volume.arrived_level && document.getElementById("arriving").hidden;
  });
  await settled(page);
}

const pixelsOf = (page, selector = "#canvas") =>
  page.evaluate((one) => {
    const canvas = document.querySelector(one);
    return [...canvas.getContext("2d", { alpha: false }).getImageData(0, 0, canvas.width, canvas.height).data];
  }, selector);

const differenceOf = (a, b) => {
  assert.equal(a.length, b.length);
  return {
    most: a.reduce((most, value, i) => Math.max(most, Math.abs(value - b[i])), 0),
    mean: a.reduce((sum, value, i) => sum + Math.abs(value - b[i]), 0) / a.length,
  };
};

// A link to the camera, which does not depend on what the page finds when it opens a file.
const cameraOf = (page) =>
  page.evaluate(() => {
    const { camera } = window.cvol.store.state.view;
    return `#${Object.entries(camera).map(([key, value]) => `camera.${key}=${JSON.stringify(value)}`).join("&")}`;
  });

const sentenceOf = async (page) => {
  await page.waitForFunction(() => document.querySelector("#opening .sentence").textContent);
  return page.locator("#opening .sentence").textContent();
};

test("bricks have the ranges that the index says", async () => {
  for (const name of ["large.cvol", "small-bricks.cvol"]) {
    const bytes = readFileSync(file(name));
    const bricks = bricksOf(new Uint8Array(bytes));
    bricks.heads().forEach(([from, to], k) => assert.ok(bricks.isHead(k, bytes.subarray(from, to))));
    assert.equal(bytes.length - bricks.end, 24, "after the shells there is only ENDS");
    const none = new Uint8Array(bricks.count).fill(3);
    assert.deepEqual(bricks.rangesOf(none), []);
    const [[from, to], ...others] = bricks.rangesOf(new Uint8Array(bricks.count));
    assert.deepEqual([to, others], [bricks.end, []]);
    assert.ok(from > bricks.begin);
  }
  assert.equal(bricksOf(new Uint8Array(readFileSync(file("bounded.cvol")))), null);
  assert.equal(bricksOf(new Uint8Array(large.subarray(0, 400))), null);
});

// All bricks are wanted, and each range takes the time of its bytes. opens(loaded share of the bytes): whether the part of
// level 2 is open then. Returns the levels of the parts.
async function partsOf(opens) {
  const first = large.subarray(0, bricksOf(new Uint8Array(large)).heads()[0][0]); // with level 3
  const now = performance.now;
  const asked = [];
  let [clock, used] = [0, first.length];
  performance.now = () => clock;
  try {
    const fetchRange = (from, to) => new Promise((resolve) => asked.push({ from, to, resolve }));
    const answer = async () => {
      const { from, to, resolve } = asked.shift();
      clock += to - from;
      used += to - from;
      resolve(new Uint8Array(large.subarray(from, to)));
      await new Promise((done) => setImmediate(done));
    };
    const fail = (error) => assert.fail(error.message);
    const branched = branchOff({ bytes: () => new Uint8Array(first), total: large.length, fetchRange, fail }, () => {});
    while (asked.length) await answer();
    const ranged = await branched;
    const parts = [];
    ranged.want(new Uint8Array(ranged.bricks.count));
    for (let level = 3; level > 0; ) {
      let part = null;
      ranged.next().then((got) => (part = got));
      await new Promise((done) => setImmediate(done));
      while (!part) await answer();
      parts.push((level = part.level));
      while (level === 2 && !opens(used / large.length)) await answer();
    }
    return parts;
  } finally {
    performance.now = now;
  }
}

test("a part that takes longer to open than the rest takes to arrive is left out", async () => {
  assert.deepEqual(await partsOf(() => true), [3, 2, 1, 0]);
  assert.deepEqual(await partsOf((share) => share > 0.9), [3, 2, 0]);
});

// Random numbers from 0 to 1.
function createRandom(seed) {
  let state = seed;
  return () => (state = (Math.imul(state, 1664525) + 1013904223) >>> 0) / 2 ** 32;
}

test("what is in the picture is wanted, and as fine as its pixels are", async () => {
  const seed = 5;
  const random = createRandom(seed);
  const bricks = bricksOf(new Uint8Array(large));
  let [seen, coarse] = [0, 0];
  for (let k = 0; k < 300; k++) {
    const volume = { dims: bricks.dims, spacing: [0.5 + random(), 1, 1.5] };
    const camera = {
      azimuth: 360 * random(),
      elevation: 180 * random() - 90,
      roll: 360 * random(),
      zoom: 0.05 * 400 ** random(),
      fov: k % 2 ? 5 + 100 * random() : 0,
      look_at: volume.dims.map((n, a) => n * volume.spacing[a] * (random() - 0.5)),
    };
    const [width, height] = [200 + 600 * random(), 200 + 600 * random()];
    const view = { camera, mirror: k % 3 === 0, width, height, mode: "composite" };
    const levels = levelsOfView(bricks, volume, view);
    const project = projector(view, volume, width, height);
    for (let i = 0; i < 300; i++) {
      const sample = volume.dims.map((n) => Math.floor(n * random()));
      const world = worldOf(volume, sample);
      const at = project(world);
      if (!at || at.x < 0 || at.y < 0 || at.x > width || at.y > height) continue;
      const place = sample.map((s, a) => Math.floor(s / bricks.sides[a]));
      const level = levels[place[0] + bricks.grid[0] * (place[1] + bricks.grid[1] * place[2])];
      // The pixels of a sample as wide as the largest spacing: 2.86 samples in a pixel suffice for level 1.
      const { right } = directions(camera, view.mirror);
      const next = project(world.map((w, a) => w + right[a] * Math.max(...volume.spacing)));
      const across = Math.hypot(next.x - at.x, next.y - at.y);
      const most = 1.0001 / 2.86 / 2 ** (level - 1);
      assert.ok(level === 0 || across <= most, `seed ${seed}, view ${k}: level ${level}, ${across} pixels a sample`);
      seen++;
      coarse += level > 0;
    }
  }
  assert.ok(seen > 1000 && coarse > 100);
});

// Light comes from what is not in the picture, too, which is there at a coarse level: only unlit pictures are the same.
const UNLIT = "&light.on=false";
const ZOOMED = "#camera.zoom=9&camera.azimuth=20";

for (const [name, light] of [
  ["large.cvol", UNLIT],
  ["small-bricks.cvol", ""],
])
  test(`only the bricks of a view are loaded: ${name}${light}`, async () => {
    const page = await begin(name, ZOOMED + light);
    await loaded(page);
    const share = sent / readFileSync(file(name)).length;
    const seen = await pixelsOf(page);
    await page.screenshot({ path: shotPath(`site-parts-${name}`) });
    const all = await begin(`plain-${name}`, (await cameraOf(page)) + light);
    await whole(all);
    const { most, mean } = differenceOf(seen, await pixelsOf(all));
    console.log(`${name}: ${(100 * share).toFixed(0)} % of the bytes, pixels differ by at most ${most}, ${mean.toFixed(4)} in the mean`);
    await all.screenshot({ path: shotPath(`site-parts-${name}-whole`) });
    await all.context().close();
    assert.ok(share < 0.6);
    assert.ok(light ? most === 0 : mean < 2);
    return page;
  });

test("slices load their bricks; the rest on demand", async () => {
  const page = await begin("small-bricks.cvol", `${ZOOMED}&.page.layout='slices'`);
  await loaded(page);
  const share = sent / readFileSync(file("small-bricks.cvol")).length;
  const names = ["x", "y", "z"].map((axis) => `.slice-${axis} canvas`);
  const slices = [];
  for (const one of names) slices.push(await pixelsOf(page, one));
  await page.screenshot({ path: shotPath("site-parts-slices") });
  await page.getByText("Load all").click();
  await page.waitForFunction(() => document.getElementById("arriving").hidden);
  await loaded(page);
  for (const [k, one] of names.entries()) assert.deepEqual(differenceOf(slices[k], await pixelsOf(page, one)).most, 0, one);
  console.log(`${(100 * share).toFixed(0)} % of the bytes for a view and three slices`);
  assert.ok(share < 0.8);
  const bytes = readFileSync(file("small-bricks.cvol")).length;
  assert.ok(sent < 1.1 * bytes, `${sent} bytes sent of ${bytes}`);
  return page;
});

test("turning the view loads what it needs then", async () => {
  const page = await begin("small-bricks.cvol", ZOOMED + UNLIT);
  await loaded(page);
  const before = sent;
  const part = await page.evaluate(() => window.cvol.volumes.current().arrived_part);
  await page.evaluate(() => {
    const { camera } = window.cvol.store.state.view;
    window.cvol.store.set({ view: { camera: { ...camera, azimuth: camera.azimuth + 90 } } });
  });
  await page.waitForFunction((n) => window.cvol.volumes.current().arrived_part > n, part);
  await loaded(page);
  assert.ok(sent > before + 100000);
  const seen = await pixelsOf(page);
  const all = await begin("plain-small-bricks.cvol", (await cameraOf(page)) + UNLIT);
  await whole(all);
  const { most } = differenceOf(seen, await pixelsOf(all));
  await all.context().close();
  assert.equal(most, 0);
  return page;
});

test("requests that fail once are made again", async () => {
  const page = await begin("busy-large.cvol", ZOOMED);
  await loaded(page);
  assert.ok(failedOnce.size > 5);
  page.complaints = [];
  return page;
});

test("files whose bricks have no levels are loaded whole", async () => {
  const page = await begin("bounded.cvol", ZOOMED);
  await whole(page);
  assert.deepEqual(ranges, []);
  return page;
});

test("a file that changes gives a sentence", async () => {
  const page = await begin("other-small-bricks.cvol", ZOOMED);
  assert.match(await sentenceOf(page), /^other-small-bricks\.cvol: the file has changed: load the page again$/);
  return page;
});

test("a damaged brick gives a sentence", async () => {
  const page = await begin("damaged-large.cvol");
  assert.match(await sentenceOf(page), /damaged-large\.cvol: .*is damaged/);
  return page;
});

let failed = 0;
for (const [name, fn] of tests) {
  if (process.env.ONLY && !name.includes(process.env.ONLY)) continue;
  const start = Date.now();
  try {
    const page = await fn();
    const foreign = (page?.complaints ?? []).filter((text) => !text.startsWith(`asks for ${address}`));
    assert.deepEqual(foreign, []);
    await page?.context().close();
    console.log(`${((Date.now() - start) / 1000).toFixed(1)} s  ${name}`);
  } catch (error) {
    failed++;
    console.log(`FAILED: ${name}\n${error.stack}`);
  }
}
await browser.close();
server.close();
console.log(failed ? `${failed} failed` : "all passed");
process.exit(failed ? 1 : 0);
