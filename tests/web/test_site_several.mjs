// Tests what a page of cvol export shows of several volumes and files: series with the bar of times, files of channels, the
// slices of a DICOM series, a header with its samples, and a sentence for what it does not read.
//
// usage: test_site_several.mjs SITE_FOLDER FOLDER CVOL, with CVOL_BROWSER_MODULES, CVOL_CHROMIUM and CVOL_SHOTS as
// tests/viewer/test_browser.mjs

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdirSync, readFileSync, writeFileSync } from "node:fs";
import path from "node:path";
import { pathToFileURL } from "node:url";

import { openPage, settled, shotPath, startBrowser, stateOf } from "../viewer/browser.mjs";
import { dicomOf, niftiOf } from "./make_files.mjs";

const [site, folder, cvol] = process.argv.slice(2).map((name) => path.resolve(name));
mkdirSync(path.join(folder, "slices"), { recursive: true });
const file = (name) => path.join(folder, name);
const run = (...words) => execFileSync(cvol, words, { cwd: folder, stdio: ["ignore", "ignore", "inherit"] });
const browser = await startBrowser();
const tests = [];
const test = (name, fn) => tests.push([name, fn]);

// ---- files --------------------------------------------------------------------------------------

const DIMS = [56, 48, 40];
const TIMES = 5;
const SPACING = [2, 1.5, 1];
const SAMPLES = DIMS[0] * DIMS[1] * DIMS[2];

// A ball that moves along x.
const ballAt = (time) =>
  Buffer.from(
    Array.from({ length: SAMPLES }, (_, i) => {
      const [x, y, z] = [i % DIMS[0], Math.floor(i / DIMS[0]) % DIMS[1], Math.floor(i / DIMS[0] / DIMS[1])];
      return Math.round(220 * Math.exp(-((x - 16 - 5 * time) ** 2 + (y - 24) ** 2 + (z - 20) ** 2) / 120));
    }),
  );
const balls = Array.from({ length: TIMES }, (_, time) => ballAt(time));
writeFileSync(file("run.nii"), niftiOf(Buffer.concat(balls), [...DIMS, TIMES], [...SPACING, 1.5]));
run("compress", "run.nii", "run.cvol", "--fast");
balls.slice(0, 2).forEach((ball, i) => writeFileSync(file(`ball-${i}.nii`), niftiOf(ball, DIMS, SPACING)));
run("compress", "ball-0.nii", "ball-1.nii", "-o", "cell.cvol", "--as", "channels", "--channel-names", "DAPI,GFP", "--fast");
const SLICE = DIMS[0] * DIMS[1];
const slices = Array.from({ length: DIMS[2] }, (_, z) => {
  const name = `slices/${(7 * z) % DIMS[2]}`; // names in another order than the slices, without an ending
  writeFileSync(file(name), dicomOf(balls[0].subarray(z * SLICE, (z + 1) * SLICE), DIMS, SPACING, z));
  return name;
});
const scout = [10, 20, 30].map((z) => {
  const name = `slices/scout-${z}`;
  const series = { number: 7, description: "Scout" };
  writeFileSync(file(name), dicomOf(balls[1].subarray(z * SLICE, (z + 1) * SLICE), DIMS, SPACING, z, series));
  return name;
});
const JPEG = "1.2.840.10008.1.2.4.50";
writeFileSync(file("packed.dcm"), dicomOf(Buffer.alloc(SLICE), DIMS, SPACING, 0, { transfer: JPEG }));
writeFileSync(file("volume.h5"), Buffer.concat([Buffer.from("\x89HDF\r\n\x1a\n", "latin1"), Buffer.alloc(2000)]));
const header = `NRRD0004\ntype: uint8\ndimension: 3\nsizes: ${DIMS.join(" ")}\nencoding: raw\ndata file: ball.raw\n\n`;
writeFileSync(file("ball.nhdr"), header);
writeFileSync(file("ball.raw"), balls[0]);
run("export", "--html", "run.cvol", "-o", "run.html");
run("export", "--html", "cell.cvol", "-o", "cell.html");

// ---- pages --------------------------------------------------------------------------------------

const address = (name) => pathToFileURL(name).href;
const begin = (name, options) => openPage(browser, address(name), { ready: false, offline: true, ...options });
const index = path.join(site, "index.html");
const choose = (page, ...names) => page.locator("#opening input").setInputFiles(names.map(file));
const sentenceOf = async (page) => {
  await page.waitForFunction(() => document.querySelector("#opening .sentence").textContent);
  return page.locator("#opening .sentence").textContent();
};

// The samples of a slice by the request of the page; the window is that of bytes.
const sliceOf = (page, id, z, time) =>
  page.evaluate(
    async ([volume, place, at]) => {
      const { data } = await window.cvol.api.slice(volume, "z", place, [0, 255], { time: at });
      return [...data].filter((_, i) => i % 4 === 0);
    },
    [id, z, time],
  );
const largest = (a, b) => a.reduce((most, value, i) => Math.max(most, Math.abs(value - b[i])), 0);
const wantedSlice = (name, z, ...words) => {
  run("decompress", name, "wanted.raw", ...words);
  return [...readFileSync(file("wanted.raw")).subarray(z * SLICE, (z + 1) * SLICE)];
};

async function checkSeries(page, id = "0") {
  await settled(page);
  const { times, time_values: values, time_unit: unit } = await page.evaluate(() => window.cvol.volumes.current());
  assert.deepEqual([times, values, unit], [TIMES, [0, 1.5, 3, 4.5, 6], "s"]);
  await page.waitForFunction(() => window.cvol.view3d && !document.getElementById("time").hidden);
  const slider = page.getByRole("slider", { name: "Time" });
  for (const time of [4, 2, 0]) {
    await slider.fill(String(time));
    await settled(page);
    assert.equal((await stateOf(page)).view.time, time);
    const most = largest(await sliceOf(page, id, 20, time), wantedSlice("run.cvol", 20, "--time", String(time)));
    assert.ok(most <= 1, `time ${time}: a sample differs by ${most}`);
  }
}

for (const [name, open] of [
  ["a page of --html", () => begin(file("run.html"))],
  ["a .cvol file", async () => {
    const page = await begin(index);
    await choose(page, "run.cvol");
    return page;
  }],
  ["a NIfTI file", async () => {
    const page = await begin(index);
    await choose(page, "run.nii");
    return page;
  }],
])
  test(`${name} of several times has a bar of times, and all of them`, async () => {
    const page = await open();
    await checkSeries(page);
    assert.equal(await page.locator("#chooser option").count(), 1, "one volume");
    await page.screenshot({ path: shotPath(`series-${name.replaceAll(" ", "-")}`) });
    return page;
  });

test("a series at 360 x 740 plays", async () => {
  const page = await begin(file("run.html"), { viewport: { width: 360, height: 740 } });
  await settled(page);
  await page.getByRole("button", { name: "Play" }).click();
  await page.waitForFunction((last) => window.cvol.store.state.view.time === last, TIMES - 1);
  await page.getByRole("button", { name: "Stop" }).click();
  await settled(page);
  await page.screenshot({ path: shotPath("series-360") });
  return page;
});

test("channels are shown together, in their colours and with their names", async () => {
  for (const open of [() => begin(file("cell.html")), async () => {
    const page = await begin(index);
    await choose(page, "cell.cvol");
    return page;
  }]) {
    const page = await open();
    await settled(page);
    const { channels } = (await stateOf(page)).view;
    assert.deepEqual(channels.map(({ volume, on }) => [volume, on]), [["0", true], ["1", true]]);
    const names = await page.evaluate(() => window.cvol.volumes.list().map(({ name, channel }) => [name, channel.name]));
    assert.deepEqual(names, [["cell.cvol, DAPI", "DAPI"], ["cell.cvol, GFP", "GFP"]]);
    assert.ok(largest(await sliceOf(page, "1", 20, 0), wantedSlice("cell.cvol", 20, "--channel", "1")) <= 1);
    await page.screenshot({ path: shotPath("channels") });
    assert.deepEqual(page.complaints, []);
  }
});

test("a time and a channel alone stay one volume", async () => {
  run("export", "--html", "run.cvol", "-o", "third.html", "--time", "3");
  const page = await begin(file("third.html"));
  await settled(page);
  assert.equal(await page.evaluate(() => window.cvol.volumes.current().times), 1);
  assert.ok(largest(await sliceOf(page, "0", 20, 0), wantedSlice("run.cvol", 20, "--time", "3")) <= 1);
  return page;
});

// ---- DICOM and headers --------------------------------------------------------------------------

async function checkBall(page, name, spacing = SPACING) {
  await settled(page);
  const volume = await page.evaluate(() => window.cvol.volumes.current());
  assert.deepEqual([volume.name, volume.dims, volume.spacing], [name, DIMS, spacing]);
  run("compress", "ball-0.nii", "native.cvol", "--fast", "--background", "auto");
  for (const z of [15, 20]) {
    const most = largest(await sliceOf(page, volume.id, z, 0), wantedSlice("native.cvol", z));
    assert.ok(most <= 1, `slice ${z}: a sample differs by ${most}`);
  }
}

test("chosen slices of a DICOM series are one volume, in the order of their places", async () => {
  const page = await begin(index);
  await choose(page, ...slices);
  await checkBall(page, "0.cvol");
  await page.screenshot({ path: shotPath("site-dicom") });
  return page;
});

test("a dropped folder is a DICOM series, without what lies next to its slices", async () => {
  const page = await begin(index);
  const given = slices.map((name) => [path.basename(name), [...readFileSync(file(name))]]);
  await page.evaluate((files) => {
    const entryOf = ([name, bytes]) => ({ name, isFile: true, file: (done) => done(new File([new Uint8Array(bytes)], name)) });
    const folderOf = (name, entries) => {
      const parts = [entries.slice(0, 3), entries.slice(3), []]; // readers give parts
      return { name, isFile: false, createReader: () => ({ readEntries: (done) => done(parts.shift()) }) };
    };
    const entries = [...files.map(entryOf), entryOf(["notes.txt", [65, 66]]), entryOf([".hidden", [65]])];
    const event = new Event("drop", { bubbles: true, cancelable: true });
    event.dataTransfer = { items: [{ webkitGetAsEntry: () => folderOf("patient", [folderOf("ct", entries)]) }] };
    document.body.dispatchEvent(event);
  }, given);
  await checkBall(page, "patient.cvol");
  return page;
});

test("one of several DICOM series is chosen", async () => {
  const page = await begin(index);
  await choose(page, ...scout, ...slices);
  const buttons = page.locator("#opening .choices button");
  await buttons.first().waitFor();
  assert.deepEqual(await buttons.allTextContents(), ["Series (1), 40 slices", "Scout (7), 3 slices", "Cancel"]);
  await page.screenshot({ path: shotPath("site-choose-series") });
  assert.equal(await page.getByRole("button", { name: "Choose files" }).isDisabled(), true);
  await buttons.last().click();
  await page.waitForFunction(() => !document.querySelector("#opening .buttons button").disabled);
  assert.equal(await page.evaluate(() => window.cvol.volumes.list().length), 0);
  await choose(page, ...scout, ...slices);
  await buttons.nth(1).click();
  await settled(page);
  assert.deepEqual(await page.evaluate(() => window.cvol.volumes.current().dims), [...DIMS.slice(0, 2), 3]);
  await page.locator("#open-file").click();
  await choose(page, ...scout, ...slices);
  await buttons.first().waitFor();
  await page.keyboard.press("Enter"); // the largest has the focus
  await page.waitForFunction(() => window.cvol.volumes.list().length === 2);
  const dims = await page.evaluate(() => window.cvol.volumes.list().map((volume) => volume.dims));
  assert.deepEqual(dims, [[...DIMS.slice(0, 2), 3], DIMS]);
  return page;
});

test("a header and its samples are one volume; several files are several", async () => {
  const page = await begin(index);
  await choose(page, "ball.raw", "ball.nhdr");
  await checkBall(page, "ball.cvol", [1, 1, 1]);
  await page.locator("#open-file").click();
  await choose(page, "ball-0.nii", "run.cvol");
  await page.waitForFunction(() => window.cvol.volumes.list().length === 3);
  await settled(page);
  const names = await page.evaluate(() => window.cvol.volumes.list().map(({ name, times }) => [name, times]));
  assert.deepEqual(names, [["ball.cvol", 1], ["ball-0.cvol", 1], ["run.cvol", TIMES]]);
  return page;
});

for (const [name, expected] of [
  ["volume.h5", /^volume\.h5: is an HDF5 file, .*run cvol compress volume\.h5/],
  ["packed.dcm", /^packed\.dcm: is compressed \(transfer syntax 1\.2\.840\.10008\.1\.2\.4\.50\).*try cvol compress packed/],
])
  test(`${name} gives a sentence`, async () => {
    const page = await begin(index);
    await choose(page, name);
    const sentence = await sentenceOf(page);
    console.log(sentence);
    assert.match(sentence, expected);
    await page.screenshot({ path: shotPath(`site-${name}`) });
    return page;
  });

let failed = 0;
for (const [name, fn] of tests) {
  if (process.env.ONLY && !name.includes(process.env.ONLY)) continue;
  const start = Date.now();
  try {
    const page = await fn();
    if (page) {
      const foreign = page.complaints.filter((text) => !text.startsWith(`asks for ${address(site)}`));
      assert.deepEqual(foreign, []);
      await page.context().close();
    }
    console.log(`${((Date.now() - start) / 1000).toFixed(1)} s  ${name}`);
  } catch (error) {
    failed++;
    console.log(`FAILED: ${name}\n${error.stack}`);
  }
}
await browser.close();
console.log(failed ? `${failed} failed` : "all passed");
process.exit(failed ? 1 : 0);
