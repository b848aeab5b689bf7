// Tests the page of cvol export --site in a browser: files of several formats are opened from a disk's page and from a
// server's, ?url= opens a file of the server, and what cannot be opened gives a sentence.
//
// usage: test_site.mjs SITE_FOLDER FILES_FOLDER CVOL, with CVOL_BROWSER_MODULES, CVOL_CHROMIUM and CVOL_SHOTS as
// tests/viewer/test_browser.mjs. FILES_FOLDER has whole.cvol, box.nrrd, and the same samples in box.nii.gz, box.tif,
// box.mha and box.npy; nine.vdb has nine grids; matlab_bytes.mat has 9 x 7 x 5 bytes.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { existsSync, readFileSync, writeFileSync } from "node:fs";
import { createServer } from "node:http";
import path from "node:path";
import { pathToFileURL } from "node:url";

import { levelOf } from "../../web/page/arrival.js";
import { openPage, settled, shotPath, startBrowser } from "../viewer/browser.mjs";

const [site, folder, cvol] = process.argv.slice(2).map((name) => path.resolve(name));
const file = (name) => path.join(folder, name);
const browser = await startBrowser();
const tests = [];
const test = (name, fn) => tests.push([name, fn]);

// ---- a server ---------------------------------------------------------------------------------

const types = { ".html": "text/html; charset=utf-8", ".js": "text/javascript" };

// Names may begin with words for what the server does: `early-` ends after half of the file; `again-`, `chunked-` and
// `busy-` too, but they go on where the page asks, `chunked-` without the length at first, `busy-` after an answer 503;
// `huge-` announces too many bytes; `held-` waits after each level of a .cvol file until release() is called.
const asked = []; // headers Range
let release = () => {};
const released = () => new Promise((resolve) => (release = resolve));

// The least number of bytes after which a level is complete.
function endOf(level, bytes) {
  let [lo, hi] = [0, bytes.length];
  const has = (end) => levelOf(bytes.subarray(0, end)) > 0 && levelOf(bytes.subarray(0, end)) <= level;
  while (lo < hi) {
    const middle = (lo + hi) >> 1;
    if (has(middle)) hi = middle;
    else lo = middle + 1;
  }
  return lo;
}

async function sendHeld(answer, bytes) {
  let sent = 0;
  for (const level of [3, 2, 1]) {
    const end = endOf(level, bytes);
    answer.write(bytes.subarray(sent, end));
    sent = end;
    await released();
  }
  answer.end(bytes.subarray(sent));
}

function serve({ url, headers }, answer) {
  const name = path.basename(new URL(url, "http://x/").pathname) || "index.html";
  const word = /^(early|again|chunked|busy|huge|held)-/.exec(name)?.[1];
  const place = [path.join(site, name), file(word ? name.slice(word.length + 1) : name)].find((one) => existsSync(one));
  if (!place) return answer.writeHead(404).end();
  const bytes = readFileSync(place);
  const type = { "Content-Type": types[path.extname(name)] ?? "application/octet-stream" };
  const goes = ["again", "chunked", "busy"].includes(word);
  const from = goes ? Number(/^bytes=(\d+)-$/.exec(headers.range ?? "")?.[1] ?? 0) : 0;
  if (headers.range) asked.push(headers.range);
  if (from && word === "busy" && asked.length === 1) return answer.writeHead(503).end();
  if (from) {
    const range = `bytes ${from}-${bytes.length - 1}/${bytes.length}`;
    answer.writeHead(206, { ...type, ETag: '"a"', "Content-Range": range, "Content-Length": bytes.length - from });
    return answer.end(bytes.subarray(from));
  }
  const length = word === "huge" ? { "Content-Length": 4e12 } : word === "chunked" ? {} : { "Content-Length": bytes.length };
  answer.writeHead(200, { ...type, ...length, ETag: word === "chunked" ? 'W/"a-gzip"' : '"a"' });
  if (word === "held") return sendHeld(answer, bytes);
  if (word === "huge") return answer.write(bytes);
  if (!word) return answer.end(bytes);
  answer.write(bytes.subarray(0, bytes.length / 2), () => setTimeout(() => answer.destroy(), 300));
}

const listen = async () => {
  const server = createServer(serve);
  await new Promise((done) => server.listen(0, "127.0.0.1", done));
  return { server, address: `http://127.0.0.1:${server.address().port}/` };
};
const [own, other] = [await listen(), await listen()];

// ---- tests ------------------------------------------------------------------------------------

const disk = pathToFileURL(path.join(site, "index.html")).href;
const begin = (address, options) => openPage(browser, address, { ready: false, ...options });
// The page may ask for its own files, and for the file of ?url=.
const foreign = ({ complaints }) => {
  const allowed = [path.dirname(disk), own.address].map((start) => `asks for ${start}`);
  return complaints.filter((text) => !allowed.some((start) => text.startsWith(start)));
};
const sentenceOf = async (page) => {
  await page.waitForFunction(() => document.querySelector("#opening .sentence").textContent);
  return page.locator("#opening .sentence").textContent();
};
const bright = (page) =>
  page.evaluate(() => {
    const canvas = document.getElementById("canvas");
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    return data.reduce((count, value, i) => count + (i % 4 < 3 && value > 40), 0);
  });
const choose = (page, name) => page.locator("#opening input").setInputFiles(file(name));

for (const [width, height] of [[1280, 800], [360, 740]])
  test(`the page of a disk opens a .cvol at ${width} x ${height}, without a request`, async () => {
    const page = await begin(disk, { viewport: { width, height }, offline: true });
    await page.waitForSelector("#opening");
    await page.screenshot({ path: shotPath(`site-${width}-empty`) });
    await choose(page, "whole.cvol");
    await settled(page);
    assert.ok((await bright(page)) > 5000);
    assert.equal(await page.locator("#opening").isVisible(), false);
    await page.screenshot({ path: shotPath(`site-${width}-cvol`) });
    return page;
  });

// The largest difference of the saved file's samples from those that the command makes of the same file.
function compareSaved(name) {
  execFileSync(cvol, ["compress", file(name), file("native.cvol"), "--fast", "--background", "auto"], { stdio: "ignore" });
  execFileSync(cvol, ["verify", file("saved.cvol")], { stdio: "ignore" });
  const [saved, native] = ["saved", "native"].map((one) => {
    execFileSync(cvol, ["decompress", file(`${one}.cvol`), file(`${one}.raw`)], { stdio: "ignore" });
    return readFileSync(file(`${one}.raw`));
  });
  assert.equal(saved.length, native.length);
  return saved.reduce((largest, value, i) => Math.max(largest, Math.abs(value - native[i])), 0);
}

/** Writes the samples of box.nrrd, bytes of 80 x 70 x 70, as a file of FreeSurfer without directions. */
function writeMgh() {
  const header = Buffer.alloc(284);
  [1, 80, 70, 70, 1, 0].forEach((value, i) => header.writeInt32BE(value, 4 * i));
  execFileSync(cvol, ["decompress", file("whole.cvol"), file("box.raw"), "--box", "60:140,80:150,60:130"], { stdio: "ignore" });
  writeFileSync(file("box.mgh"), Buffer.concat([header, readFileSync(file("box.raw"))]));
}
writeMgh();

/** Noise, of which a ratio of 30 would leave less than 25 dB. */
function writeNoise() {
  let state = 1;
  const samples = Buffer.alloc(64 ** 3).map(() => (state = (state * 16807) % 2147483647) >> 8);
  const head = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 64 64 64\nencoding: raw\n\n";
  writeFileSync(file("noise.nrrd"), Buffer.concat([Buffer.from(head), samples]));
}
writeNoise();

for (const [address, where, name] of [
  [disk, "a disk", "box.nrrd"],
  [own.address, "a server", "box.nrrd"],
  [disk, "a disk", "box.tif"],
  [disk, "a disk", "box.mha"],
  [disk, "a disk", "box.npy"],
  [disk, "a disk", "box.mgh"],
  [disk, "a disk", "noise.nrrd"],
])
  test(`the page of ${where} compresses ${name} as the command does, and saves it`, async () => {
    const page = await begin(address);
    await choose(page, name);
    await settled(page);
    assert.ok((await bright(page)) > 5000);
    const [download] = await Promise.all([page.waitForEvent("download"), page.getByText(`Save ${name.split(".")[0]}.cvol`).click()]);
    await download.saveAs(file("saved.cvol"));
    const most = compareSaved(name);
    assert.ok(most <= 1, `a sample differs by ${most}`);
    await page.screenshot({ path: shotPath("site-saved") });
    return page;
  });

test("the page draws a grid of OpenVDB", async () => {
  const bytes = readFileSync(file("nine.vdb"));
  const count = 8 + 4 + 8 + 1 + 36 + 4; // the place of the number of grids, behind no metadata
  assert.equal(bytes.readUInt32LE(count), 9);
  bytes.writeUInt32LE(1, count);
  writeFileSync(file("one.vdb"), bytes);
  const page = await begin(disk);
  await choose(page, "one.vdb");
  await settled(page);
  assert.ok((await bright(page)) > 5000);
  await page.screenshot({ path: shotPath("site-vdb") });
  return page;
});

test("the page reads an array of MATLAB", async () => {
  const page = await begin(disk);
  await choose(page, "matlab_bytes.mat");
  await settled(page);
  assert.deepEqual(await page.evaluate(() => window.cvol.volumes.current().dims), [9, 7, 5]);
  return page;
});

test("the grids of a file of OpenVDB are named, and the command that reads one", async () => {
  const page = await begin(disk);
  await choose(page, "nine.vdb");
  const sentence = await sentenceOf(page);
  assert.match(sentence, /nine\.vdb: has 9 grids: name one .*float, double, .*try cvol compress nine\.vdb/);
  return page;
});

test("another file is one more volume", async () => {
  const page = await begin(disk);
  await choose(page, "whole.cvol");
  await settled(page);
  await page.locator("#open-file").click();
  await choose(page, "box.nii.gz");
  await page.waitForFunction(() => window.cvol.store.state.view.volume === "1");
  await settled(page);
  assert.deepEqual(await page.locator("#chooser option").allTextContents(), ["whole.cvol", "box.cvol"]);
  await page.screenshot({ path: shotPath("site-two") });
  return page;
});

test("a file can be dropped, and labels stay labels", async () => {
  const page = await begin(disk);
  const data = [...readFileSync(file("labels.nrrd"))];
  await page.evaluate((bytes) => {
    const dataTransfer = new DataTransfer();
    dataTransfer.items.add(new File([new Uint8Array(bytes)], "labels.nrrd"));
    document.body.dispatchEvent(new DragEvent("drop", { dataTransfer, bubbles: true, cancelable: true }));
  }, data);
  await settled(page);
  assert.equal(await page.evaluate(() => window.cvol.volumes.current().labels.length), 8);
  await page.screenshot({ path: shotPath("site-labels") });
  return page;
});

// A ball of eight labels.
const [side, half] = [48, 24];
const labels = Buffer.alloc(side ** 3);
for (let z = 0; z < side; z++)
  for (let y = 0; y < side; y++)
    for (let x = 0; x < side; x++)
      if (Math.hypot(x - half, y - half, z - half) < half - 2)
        labels[(z * side + y) * side + x] = 1 + (x >= half) + 2 * (y >= half) + 4 * (z >= half);
const head = `NRRD0004\ntype: uint8\ndimension: 3\nsizes: ${side} ${side} ${side}\nencoding: raw\n\n`;
writeFileSync(file("labels.nrrd"), Buffer.concat([Buffer.from(head), labels]));

test("a page with labels has their names and colours", async () => {
  const run = (...words) => execFileSync(cvol, words, { stdio: "ignore" });
  writeFileSync(file("names.txt"), "1 Left 255 0 0 0\n2 Right 0 255 0 0\n");
  run("compress", file("labels.nrrd"), file("labels.cvol"), "--labels", "yes", "--label-table", file("names.txt"));
  run("export", "--html", file("labels.cvol"), "-o", file("labels.html"));
  const page = await begin(pathToFileURL(file("labels.html")).href);
  await settled(page);
  const labels = await page.evaluate(() => window.cvol.volumes.current().labels);
  assert.deepEqual(labels.slice(0, 2).map(({ name, colour }) => [name, colour]), [["Left", [1, 0, 0]], ["Right", [0, 1, 0]]]);
  assert.equal(labels[2].name, null);
  await page.screenshot({ path: shotPath("page-labels") });
  return page;
});

writeFileSync(file("text.txt"), "not a volume\n".repeat(100));
writeFileSync(file("damaged.nrrd"), readFileSync(file("box.nrrd")).subarray(0, 5000));
writeFileSync(file("empty.nii"), "");
writeFileSync(file("scan.dcm"), Buffer.concat([Buffer.alloc(128), Buffer.from("DICM"), Buffer.alloc(200)]));
for (const [name, expected] of [
  ["text.txt", /^text\.txt: is not a volume in a format that this page reads$/],
  ["damaged.nrrd", /^damaged\.nrrd: .*/],
  ["empty.nii", /^empty\.nii: is empty$/],
  ["scan.dcm", /^scan\.dcm: is a DICOM file/],
])
  test(`${name} gives a sentence`, async () => {
    const page = await begin(disk);
    await choose(page, name);
    const sentence = await sentenceOf(page);
    console.log(sentence);
    assert.match(sentence, expected);
    assert.ok(!sentence.includes("\n") && sentence.length < 200);
    await page.screenshot({ path: shotPath(`site-${name}`) });
    await choose(page, "whole.cvol"); // it still works
    await settled(page);
    assert.equal(await page.locator("#opening .sentence").textContent(), "");
    return page;
  });

test("?url= opens a file of the server", async () => {
  const page = await begin(`${own.address}?url=whole.cvol`);
  await settled(page);
  assert.ok((await bright(page)) > 5000);
  return page;
});

const picture = (page) => page.evaluate(() => document.getElementById("canvas").toDataURL());
// The largest difference of a colour from that of a picture().
const difference = (page, expected) =>
  page.evaluate(async (url) => {
    const pixelsOf = (source, width, height) => {
      const context = Object.assign(document.createElement("canvas"), { width, height }).getContext("2d");
      context.drawImage(source, 0, 0);
      return context.getImageData(0, 0, width, height).data;
    };
    const canvas = document.getElementById("canvas");
    const image = Object.assign(new Image(), { src: url });
    await image.decode();
    const [now, then] = [canvas, image].map((source) => pixelsOf(source, canvas.width, canvas.height));
    return now.reduce((largest, value, i) => Math.max(largest, Math.abs(value - then[i])), 0);
  }, expected);

test("a file of the server is shown level by level", async () => {
  const all = await begin(`${own.address}?url=whole.cvol`);
  await settled(all);
  const expected = await picture(all);
  await all.context().close();

  const page = await begin(`${own.address}?url=held-whole.cvol`);
  const arrived = (level) =>
    page.waitForFunction((n) => (window.cvol.volumes.current()?.arrived_level ?? 0) === n, level);
  const still = (from) =>
    page.waitForFunction((n) => window.cvolTimings.slice(n).some(({ quality }) => quality === "still"), from);
  let before = 0;
  for (const level of [3, 2, 1]) {
    await arrived(level);
    await still(before);
    before = await page.evaluate(() => window.cvolTimings.length);
    assert.ok((await bright(page)) > 5000);
    assert.match(await page.locator("footer").textContent(), new RegExp(`loading: level ${level} is there`));
    await page.waitForFunction(() => /Point \d+ of [2-9]/.test(document.querySelector("#panel").textContent));
    await page.screenshot({ path: shotPath(`site-level-${level}`) });
    release();
  }
  await arrived(0);
  await still(before);
  await settled(page);
  assert.match(await page.locator("footer").textContent(), /PSNR [0-9.]+ dB/);
  const most = await difference(page, expected);
  console.log(`largest difference ${most}`);
  assert.ok(most <= 1, `a pixel differs by ${most} from that of the whole file`);
  return page;
});

for (const [word, requests] of [["again", 1], ["chunked", 1], ["busy", 2]])
  test(`an answer that ends early goes on where it ended: ${word}`, async () => {
    asked.length = 0;
    const page = await begin(`${own.address}?url=${word}-whole.cvol`);
    await page.waitForFunction(() => window.cvol.volumes.current()?.whole && !window.cvol.volumes.current().partial);
    await settled(page);
    assert.ok(asked.length >= requests); // the browser may ask again by itself
    assert.ok(Math.abs(Number(/\d+/.exec(asked[0])[0]) - readFileSync(file("whole.cvol")).length / 2) < 2);
    page.complaints = []; // the browser reports the first answers
    return page;
  });

test("a file can be chosen while another arrives, and after it", async () => {
  const page = await begin(`${own.address}?url=held-whole.cvol`);
  await page.waitForFunction(() => window.cvol.volumes.current()?.arrived_level === 3);
  await page.locator("#open-file").click();
  for (let k = 0; k < 3; k++) {
    release();
    await page.waitForTimeout(500);
  }
  await page.waitForFunction(() => document.getElementById("arriving").hidden);
  await choose(page, "box.nii.gz");
  await page.waitForFunction(() => window.cvol.volumes.list().length === 2);
  await settled(page);
  return page;
});

test("what arrived of a file stays, and others open", async () => {
  const page = await begin(`${own.address}?url=early-whole.cvol`);
  assert.match(await sentenceOf(page), /^early-whole\.cvol: the server's answer ends early/);
  const whole = readFileSync(file("whole.cvol"));
  const level = levelOf(whole.subarray(0, whole.length / 2));
  await page.waitForFunction(
    (text) => document.querySelector("footer").textContent.includes(text),
    `ends early: level ${level}`,
  );
  await choose(page, "box.nii.gz");
  await page.waitForFunction(() => window.cvol.volumes.list().length === 2);
  await settled(page);
  page.complaints = [];
  return page;
});

test("a lossless file is shown level by level, at last exactly; labels only as a whole", async () => {
  const run = (...words) => execFileSync(cvol, words, { stdio: "ignore" });
  run("decompress", file("whole.cvol"), file("large.nii"), "--box", "60:220,80:240,60:220"); // smaller files are packed
  run("compress", file("large.nii"), file("exact.cvol"), "--lossless", "--fast");
  assert.equal(levelOf(readFileSync(file("exact.cvol"))), 1);
  const page = await begin(`${own.address}?url=held-exact.cvol`);
  for (const level of [3, 2, 1]) {
    await page.waitForFunction((n) => window.cvol.volumes.current()?.arrived_level === n, level);
    await page.waitForFunction((n) => window.cvolTimings.some(({ server }) => server.level === n), level);
    assert.match(await page.locator("footer").textContent(), new RegExp(`loading: level ${level} is there`));
    release();
  }
  await page.waitForFunction(() => !window.cvol.volumes.current().partial && window.cvol.volumes.current().whole);
  await settled(page);
  assert.match(await page.locator("footer").textContent(), /exact/);
  const samples = await page.evaluate(async () => {
    const { data } = await window.cvol.api.slice("0", "z", 80, [0, 255]);
    return [...data].filter((_, i) => i % 4 === 0);
  });
  run("decompress", file("exact.cvol"), file("exact.raw"));
  assert.deepEqual(samples, [...readFileSync(file("exact.raw")).subarray(80 * 160 * 160, 81 * 160 * 160)]);

  run("export", "--html", file("exact.cvol"), "-o", file("exact.html"));
  const alone = await begin(pathToFileURL(file("exact.html")).href);
  await settled(alone);
  const levels = await alone.evaluate(() => window.cvolTimings.map(({ server }) => server.level));
  assert.deepEqual([levels[0], levels.at(-1)], [2, 0], "the first picture of a page with it is coarse, too");

  run("compress", file("labels.nrrd"), file("numbers.cvol"), "--labels", "yes");
  assert.equal(levelOf(readFileSync(file("numbers.cvol"))), 0);
  return page;
});

for (const [query, expected] of [
  ["missing.cvol", /^missing\.cvol: the server answers 404 Not Found$/],
  ["huge-whole.cvol", /^huge-whole\.cvol: has 4\.00 TB, a page opens at most 1\.00 GB: use cvol compress$/],
  ["early-whole.cvol", /^early-whole\.cvol: the server's answer ends early/],
  [`${other.address}whole.cvol`, /^whole\.cvol: .* does not allow other pages to read it \(CORS\)$/],
])
  test(`?url=${path.basename(query)} of ${query.includes(":") ? "another" : "the"} server gives a sentence`, async () => {
    const page = await begin(`${own.address}?url=${query}`);
    assert.match(await sentenceOf(page), expected);
    page.complaints = []; // the browser reports failed requests
    return page;
  });

let failed = 0;
for (const [name, fn] of tests) {
  if (process.env.ONLY && !name.includes(process.env.ONLY)) continue;
  const start = Date.now();
  try {
    const page = await fn();
    assert.deepEqual(foreign(page), []);
    await page.context().close();
    console.log(`${((Date.now() - start) / 1000).toFixed(1)} s  ${name}`);
  } catch (error) {
    failed++;
    console.log(`FAILED: ${name}\n${error.stack}`);
  }
}
await browser.close();
for (const { server } of [own, other]) server.close();
console.log(failed ? `${failed} failed` : "all passed");
process.exit(failed ? 1 : 0);
