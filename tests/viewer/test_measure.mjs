// Tests measuring and bookmarks in the viewer's page, on a volume of 0.5 x 0.8 x 2.5 mm samples with a box of one value.
//
// usage: test_measure.mjs, with CVOL, CVOL_BROWSER_MODULES (node_modules' folder), CVOL_CHROMIUM and CVOL_SHOTS (where
// screenshots go); CVOL_ONLY: a word of the tests to run.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import path from "node:path";

import { drag, middleOf, modules, openPage, openSection, settled, shotPath, startBrowser, startViewer, stateOf } from "./browser.mjs";

const axe = readFileSync(modules.resolve("axe-core/axe.min.js"), "utf8");
const [NX, NY, NZ] = [60, 50, 24];
const BLOCK = [20, 40, 15, 35, 8, 16]; // first samples, and behind the last ones
const folder = mkdtempSync(path.join(tmpdir(), "cvol-measure-"));
process.on("exit", () => rmSync(folder, { recursive: true }));

function makeVolume(name) {
  const samples = new Int16Array(NX * NY * NZ);
  for (let i = 0; i < samples.length; i++) {
    const [x, y, z] = [i % NX, Math.floor(i / NX) % NY, Math.floor(i / NX / NY)];
    const inside = [x, y, z].every((at, a) => at >= BLOCK[2 * a] && at < BLOCK[2 * a + 1]);
    samples[i] = inside ? 1000 : (x + y + z) % 7;
  }
  const header = `NRRD0004\ntype: short\ndimension: 3\nsizes: ${NX} ${NY} ${NZ}\nencoding: raw\nendian: little
space: left-posterior-superior\nspace directions: (0.5,0,0) (0,0.8,0) (0,0,2.5)\nspace units: "mm" "mm" "mm"\n\n`;
  writeFileSync(path.join(folder, `${name}.nrrd`), Buffer.concat([Buffer.from(header), Buffer.from(samples.buffer)]));
  execFileSync(process.env.CVOL, ["compress", `${name}.nrrd`, `${name}.cvol`, "--lossless", "--labels", "no"], { cwd: folder });
  return path.join(folder, `${name}.cvol`);
}

const tests = [];
const test = (name, fn) => tests.push([name, fn]);
let viewer, browser;
const open = (options = {}) => openPage(browser, viewer.address, options);
const SLICES = "#.page.layout='slices'&.page.sample=[30,25,12]";
const measures = async (page) => (await stateOf(page)).page.measures.list;
const figures = (page) => page.locator(".measure-figures dd").allTextContents();

// The point of the page at a sample's middle in the slice z.
async function placeIn(page, x, y) {
  const box = await page.locator(".slice-z .slice-frame").boundingBox();
  const [across, down] = [(x + 0.5) / NX, (y + 0.5) / NY];
  const { turned } = await page.evaluate(() => {
    const canvas = document.querySelector(".slice-z canvas");
    return { turned: canvas.style.transform };
  });
  const [flipX, flipY] = turned.match(/-?1/g).map((sign) => sign === "-1");
  return [box.x + box.width * (flipX ? 1 - across : across), box.y + box.height * (flipY ? 1 - down : down)];
}

test("a distance by two clicks in a slice, in the lengths of the file", async () => {
  const page = await open({ hash: SLICES });
  await openSection(page, "measure");
  await page.getByRole("button", { name: "Distance" }).click();
  await page.mouse.click(...(await placeIn(page, 10, 10)));
  await page.mouse.move(...(await placeIn(page, 30, 12)));
  assert.equal(await page.locator(".slice-z .mark-line").count(), 1, "the unfinished line follows the pointer");
  await page.mouse.click(...(await placeIn(page, 50, 10)));
  await page.locator(".measure-figures dd").waitFor();
  const [{ points }] = await measures(page);
  // A page's pixel is about 0.15 samples wide.
  points.flat().forEach((at, i) => assert.ok(Math.abs(at - [10, 10, 12, 50, 10, 12][i]) < 0.3, `${points}`));
  const [length] = await figures(page);
  assert.ok(Math.abs(parseFloat(length) - 20) < 0.2 && length.endsWith(" mm"), length); // 40 x 0.5
  assert.match(await page.locator(".slice-z .mark-text").textContent(), /^1: .* mm$/);
  assert.equal(await page.locator(".slice-y .mark-line").count(), 0, "the slice y 25 does not have it");
  return page;
});

test("keys place points exactly: distances along all axes, and an angle", async () => {
  const page = await open({ hash: SLICES });
  const area = page.locator(".slice-x .slice-area");
  await area.focus();
  await page.keyboard.press("d");
  assert.ok(await page.getByRole("button", { name: "Distance", exact: true }).evaluate((node) => node.getBoundingClientRect().bottom < innerHeight), "the panel shows the tools");
  await page.keyboard.press("Enter");
  // 10 samples of 2.5 mm along z, 5 of 0.8 mm along y, 12 of 0.5 mm along x
  for (let i = 0; i < 10; i++) await page.keyboard.press("ArrowDown");
  for (let i = 0; i < 5; i++) await page.keyboard.press("ArrowLeft");
  for (let i = 0; i < 12; i++) await page.keyboard.press("PageUp");
  await page.keyboard.press("Enter");
  await page.locator(".measure-figures dd").waitFor();
  const [length] = await figures(page);
  const expected = Math.hypot(25, 4, 6);
  assert.ok(Math.abs(parseFloat(length) - expected) < 1e-3, `${length}, not ${expected}`);
  await page.keyboard.press("a");
  await page.evaluate(() => window.cvol.store.set({ page: { sample: [18, 10, 10] } }));
  await page.keyboard.press("Enter");
  await page.evaluate(() => window.cvol.store.set({ page: { sample: [10, 10, 10] } }));
  await page.keyboard.press("Enter");
  await page.evaluate(() => window.cvol.store.set({ page: { sample: [18, 15, 10] } }));
  await page.keyboard.press("Enter"); // 8 x 0.5 mm and 5 x 0.8 mm: 45 degrees
  await page.waitForFunction(() => document.querySelectorAll(".measure-figures dd").length === 2);
  assert.equal((await figures(page))[1], "45°");
  await page.keyboard.press("Escape");
  await page.keyboard.press("Enter"); // no tool: no point
  assert.equal((await measures(page)).length, 2);
  return page;
});

test("a box of one value, an ellipse, the faces, the table, deleting and undo", async () => {
  const page = await open({ hash: SLICES });
  const section = await openSection(page, "measure");
  await section.getByRole("button", { name: "Box", exact: true }).click();
  await drag(page, await placeIn(page, 22, 17), await placeIn(page, 37, 32));
  await page.locator(".measure-figures dd").first().waitFor();
  assert.deepEqual((await measures(page))[0].box, [22, 38, 17, 33, 12, 13]);
  // 16 x 16 samples of 1 cubic millimetre
  assert.deepEqual(await figures(page), ["1000 ± 0", "0 ± 0", "1000 ± 0", "1000 ± 0", "256", "0.256 ml, 256 mm³"]);
  await section.getByRole("button", { name: "Ellipse" }).click();
  await drag(page, await placeIn(page, 22, 17), await placeIn(page, 37, 32));
  await page.waitForFunction(() => document.querySelectorAll(".measure-figures dd").length === 12);
  const samples = Number((await figures(page))[10]);
  let inside = 0;
  for (let y = -15; y <= 15; y += 2) for (let x = -15; x <= 15; x += 2) inside += x * x + y * y <= 256;
  assert.equal(samples, inside);
  await page.keyboard.press("Escape");

  // The faces of the box: all of the block, then one sample more.
  await section.getByText("First and last samples").first().click();
  for (const [name, value] of [["x from", 20], ["x to", 39], ["y from", 15], ["y to", 34], ["z from", 8], ["z to", 15]]) {
    const input = section.getByLabel(`Box 1, ${name}`);
    await input.fill(String(value));
    await input.press("Enter");
  }
  await page.waitForFunction(() => document.querySelectorAll(".measure-figures dd")[4]?.textContent === "3200");
  assert.equal((await figures(page))[0], "1000 ± 0");
  await section.getByLabel("Box 1, z to").fill("16");
  await section.getByLabel("Box 1, z to").press("Enter");
  await page.waitForFunction(() => document.querySelectorAll(".measure-figures dd")[4]?.textContent === "3600");
  assert.ok(parseFloat((await figures(page))[0]) < 900);
  await page.locator("#undo").click();
  await page.waitForFunction(() => document.querySelectorAll(".measure-figures dd")[4]?.textContent === "3200");

  const [head, first, second] = (await section.getByLabel("As a table (CSV)").inputValue()).split("\n").map((line) => line.split(","));
  const of = (line, name) => line[head.indexOf(name)];
  assert.deepEqual(["kind", "file", "x0", "x1", "z1", "samples", "mean", "mean_error", "volume", "unit"].map((name) => of(first, name)),
    ["box", "block.cvol", "20", "39", "15", "3200", "1000", "0", "3200", "mm"]);
  assert.equal(of(second, "kind"), "ellipsoid");
  await page.screenshot({ path: shotPath("measure-slices") });

  await section.getByRole("button", { name: "Delete Box 1" }).click();
  assert.equal((await measures(page)).length, 1);
  assert.equal(await page.evaluate(() => document.activeElement.getAttribute("aria-label")), "Delete Ellipse 1");
  await page.locator("#undo").click();
  assert.equal((await measures(page)).length, 2);
  return page;
});

test("points and corners are dragged in slices, and typed", async () => {
  const list = [
    { kind: "distance", of: "0", points: [[10, 10, 12], [50, 10, 12]] },
    { kind: "box", of: "0", box: [20, 40, 15, 35, 12, 13] },
  ];
  const page = await open({ hash: `${SLICES}&.page.measures.list=${encodeURIComponent(JSON.stringify(list))}` });
  const section = await openSection(page, "measure");
  await page.waitForFunction(() => document.querySelectorAll(".slice-z .mark-spot").length === 2);
  await drag(page, await placeIn(page, 50, 10), await placeIn(page, 30, 10));
  const [, [x]] = (await measures(page))[0].points;
  assert.ok(Math.abs(x - 30) < 0.3, `${x}`);
  assert.deepEqual((await stateOf(page)).page.sample, [30, 25, 12], "the cross-hair stays");
  await page.locator("#undo").click();
  assert.deepEqual(await measures(page), list, "one step");
  // The corner at the ends behind the last samples
  await drag(page, await placeIn(page, 39.5, 34.5), await placeIn(page, 29.4, 24.6));
  assert.deepEqual((await measures(page))[1].box, [20, 30, 15, 25, 12, 13]);
  await page.waitForFunction(() => document.querySelectorAll(".measure-figures dd")[5]?.textContent === "100");
  await section.getByText("Points, in samples").click();
  const part = section.getByLabel("Distance 1, point 2, z");
  await part.fill("22");
  await part.press("Enter"); // 10 samples of 2.5 mm, 40 of 0.5 mm
  await page.waitForFunction(() => document.querySelector(".measure-figures dd")?.textContent === "32.016 mm");
  await part.fill("99");
  await part.press("Enter");
  assert.deepEqual((await measures(page))[0].points[1], [50, 10, 23.5]);
  return page;
});

test("an ellipse has handles: sides change it, the middle moves it", async () => {
  const list = [{ kind: "ellipsoid", of: "0", box: [20, 40, 15, 35, 8, 17] }];
  const page = await open({ hash: `${SLICES}&.page.measures.list=${encodeURIComponent(JSON.stringify(list))}` });
  await openSection(page, "measure");
  await page.waitForFunction(() => document.querySelectorAll(".slice-z .mark-handle").length === 5);
  const box = async () => (await measures(page))[0].box;
  await drag(page, await placeIn(page, 39.5, 24.5), await placeIn(page, 45.4, 30));
  assert.deepEqual(await box(), [20, 46, 15, 35, 8, 17], "only the side that was dragged");
  await drag(page, await placeIn(page, 32.5, 24.5), await placeIn(page, 27.5, 20.5));
  assert.deepEqual(await box(), [15, 41, 11, 31, 8, 17]);
  assert.deepEqual((await stateOf(page)).page.sample, [30, 25, 12], "the cross-hair stays");
  await page.locator("#undo").click();
  await page.locator("#undo").click();
  assert.deepEqual(await measures(page), list, "two steps");
  await page.screenshot({ path: shotPath("measure-handles") });
  // A click on a handle moves nothing but the cross-hair.
  await page.mouse.click(...(await placeIn(page, 19.5, 24.5)));
  assert.deepEqual(await measures(page), list);
  const [x, y, z] = (await stateOf(page)).page.sample;
  assert.ok(Math.abs(x - 19.5) <= 1 && Math.abs(y - 24.5) <= 1 && z === 12, `${x} ${y} ${z}`);
  return page;
});

test("points on the drawn surface, lines that follow the camera, and a reload", async () => {
  const page = await open();
  const section = await openSection(page, "measure");
  await page.evaluate(() => window.cvol.store.set({ view: { mode: "iso", surface: { value: 500 }, camera: { azimuth: 0, elevation: 90, roll: 0, look_at: [0, 0, 0] } } }));
  await settled(page);
  await section.getByRole("button", { name: "Distance" }).click();
  // From the top the block is 10 x 16 mm wide; its edges are at the ends of its samples.
  const place = (x, y) =>
    page.evaluate(async ([px, py]) => {
      const { projector, worldOf } = await import(new URL("state/camera.js", document.baseURI).href);
      const { store, volumes, view3d } = window.cvol;
      const box = document.getElementById("canvas").getBoundingClientRect();
      const at = projector(store.state.view, volumes.current(), view3d.size.width, view3d.size.height)(worldOf(volumes.current(), [px, py, 15.5]));
      return [box.x + at.x, box.y + at.y];
    }, [x, y]);
  await page.mouse.click(...(await place(22, 25)));
  await page.waitForFunction(() => document.querySelectorAll("#overlay .mark-spot").length === 1);
  await page.waitForTimeout(400); // not a double click
  await page.mouse.click(...(await place(37, 25)));
  await page.locator(".measure-figures dd").waitFor();
  const [length] = await figures(page);
  assert.ok(Math.abs(parseFloat(length) - 7.5) < 0.1, length); // 15 x 0.5 mm
  await page.keyboard.press("Escape");
  const line = () => page.locator("#overlay .mark-line").getAttribute("d");
  const before = await line();
  await page.evaluate(() => window.cvol.store.set({ view: { camera: { azimuth: 30, elevation: 35 } } }));
  await settled(page);
  await page.waitForFunction((d) => document.querySelector("#overlay .mark-line").getAttribute("d") !== d, before);
  await section.getByLabel("Show in the pictures").uncheck();
  await page.waitForFunction(() => !document.querySelector("#overlay .mark-line"));
  await section.getByLabel("Show in the pictures").check();

  const list = await measures(page);
  await page.waitForFunction(() => location.hash.includes("measures"));
  await page.reload();
  await settled(page);
  assert.deepEqual(await measures(page), list);
  await openSection(page, "measure");
  await page.locator(".measure-figures dd").waitFor();
  assert.equal((await figures(page))[0], length);
  await page.screenshot({ path: shotPath("measure-volume") });
  return page;
});

test("bookmarks: saved, shown, kept for the file, in the address, deleted", async () => {
  const page = await open();
  const section = await openSection(page, "bookmarks");
  const view = async () => (await stateOf(page)).view;
  const names = () => section.locator(".bookmark-list .link").allTextContents();
  await page.keyboard.press("1"); // the front: all angles are 0, unlike those of the first view
  await settled(page);
  const front = await view();
  assert.equal(front.camera.azimuth, 0);
  await section.getByLabel("Name of this view").fill("The 'front' & more");
  await section.getByLabel("Name of this view").press("Enter");
  const clip = { box: [null, 30, null, null, null, null], planes: [[0, 0, 1, 2]] };
  const list = [{ kind: "distance", of: "0", points: [[1, 2, 3], [4, 5, 6]] }];
  await page.evaluate(([clipped, measured]) =>
    window.cvol.store.set({
      view: { camera: { azimuth: 50, elevation: 12, zoom: 2 }, transfer: "bone", clip: clipped, light: { on: false } },
      page: { layout: "slices", sample: [10, 11, 12], measures: { list: measured } },
    }), [clip, list]);
  await settled(page);
  const other = await view();
  await page.locator("#canvas").focus();
  await page.keyboard.press("s");
  assert.deepEqual(await names(), ["The 'front' & more", "View 1"]);

  await section.getByRole("button", { name: "The 'front' & more", exact: true }).click();
  await settled(page);
  assert.deepEqual(await view(), front);
  assert.equal((await stateOf(page)).page.layout, "single");
  assert.deepEqual(await measures(page), list, "measurements that came later stay");
  await page.locator("#canvas").focus();
  await page.keyboard.press("]");
  await settled(page);
  assert.deepEqual(await view(), other);
  assert.deepEqual((await stateOf(page)).page.sample, [10, 11, 12]);
  await page.locator("#undo").click();
  assert.deepEqual(await view(), front);
  assert.deepEqual(await names(), ["The 'front' & more", "View 1"], "undo does not lose bookmarks");
  await page.screenshot({ path: shotPath("bookmarks") });

  // The address alone, in a browser that knows nothing: both bookmarks.
  await page.waitForFunction(() => location.hash.includes("bookmarks") && location.hash.includes("camera.azimuth=0"));
  const sent = await open({ hash: new URL(page.url()).hash });
  assert.deepEqual((await stateOf(sent)).view, front);
  assert.deepEqual(await sent.locator(".bookmark-list .link").allTextContents(), ["The 'front' & more", "View 1"]);
  assert.deepEqual(sent.complaints, []);

  // The link to one view.
  await section.getByRole("button", { name: "Copy the link to View 1" }).click();
  const address = await section.getByLabel("Link to the view").inputValue();
  const one = await open({ hash: new URL(address).hash });
  assert.deepEqual((await stateOf(one)).view, other);
  assert.deepEqual(await measures(one), list);

  // Another name: Escape keeps the old one, a name that is there gets a number.
  const rename = async (from, to, key) => {
    await section.getByRole("button", { name: `Rename ${from}`, exact: true }).click();
    const input = section.getByLabel(`Name of ${from}`);
    assert.ok(await input.evaluate((node) => node === document.activeElement));
    await input.fill(to);
    await input.press(key);
  };
  await rename("View 1", "s", "Escape");
  assert.deepEqual(await names(), ["The 'front' & more", "View 1"]);
  await rename("View 1", "The 'front' & more", "Enter");
  assert.deepEqual(await names(), ["The 'front' & more", "The 'front' & more 2"]);
  assert.equal(await page.evaluate(() => document.activeElement.getAttribute("aria-label")), "Rename The 'front' & more 2");
  await page.screenshot({ path: shotPath("bookmarks-renamed") });
  await rename("The 'front' & more 2", "View 1", "Tab"); // it leaves the field
  assert.deepEqual(await names(), ["The 'front' & more", "View 1"]);

  // The same browser without the address: from its storage.
  await page.goto(viewer.address);
  await settled(page);
  await openSection(page, "bookmarks");
  assert.deepEqual(await names(), ["The 'front' & more", "View 1"]);
  await section.getByRole("button", { name: "View 1", exact: true }).click();
  await settled(page);
  assert.deepEqual(await view(), other);

  const [saved] = await Promise.all([page.waitForEvent("download"), section.getByRole("button", { name: "Save as a file" }).click()]);
  await section.getByRole("button", { name: "Delete The 'front' & more" }).click();
  assert.deepEqual(await names(), ["View 1"]);
  assert.equal(await page.evaluate(() => document.activeElement.getAttribute("aria-label")), "Delete View 1");
  await section.getByRole("button", { name: "Restore" }).click();
  assert.deepEqual(await names(), ["View 1", "The 'front' & more"]);
  for (const name of ["Delete View 1", "Delete The 'front' & more"]) await section.getByRole("button", { name }).click();
  assert.deepEqual(await names(), []);
  await section.getByLabel("File of bookmarks").setInputFiles(await saved.path());
  await page.waitForFunction(() => document.querySelectorAll(".bookmark-list .link").length === 2);
  await section.getByLabel("File of bookmarks").setInputFiles({ name: "text.json", mimeType: "application/json", buffer: Buffer.from("{}") });
  await section.getByText("text.json is not a file of bookmarks").waitFor();
  assert.ok(await page.evaluate(() => document.documentElement.scrollHeight <= innerHeight), "only the panel scrolls");
  await page.evaluate(axe);
  const found = await page.evaluate(() => window.axe.run(document, { runOnly: ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa"] }));
  assert.deepEqual(found.violations.filter(({ impact }) => ["serious", "critical"].includes(impact)).map(({ id }) => id), []);
  for (const name of ["Delete View 1", "Delete The 'front' & more"]) await section.getByRole("button", { name }).click();
  await page.goto(viewer.address);
  await settled(page);
  await openSection(page, "bookmarks");
  assert.deepEqual(await names(), []);
  return page;
});

test("axe finds no serious violation with measurements, and sizes fit", async () => {
  const list = JSON.stringify([
    { kind: "distance", of: "0", points: [[10, 10, 12], [50, 40, 12]] },
    { kind: "box", of: "0", box: BLOCK },
    { kind: "ellipsoid", of: "0", box: [2, 18, 20, 45, 12, 13] },
  ]).replaceAll('"', "'");
  for (const scheme of ["dark", "light"])
    for (const [width, height] of [[1280, 800], [360, 740]]) {
      const page = await open({ hash: `${SLICES}&.page.measures.list=${encodeURIComponent(list)}`, colorScheme: scheme, viewport: { width, height } });
      if (width < 600) await page.locator("#drawer").click();
      await openSection(page, "measure");
      await page.waitForFunction(() => document.querySelectorAll(".measure-figures dd").length === 13);
      await page.getByRole("button", { name: "Distance", exact: true }).scrollIntoViewIfNeeded();
      await page.getByRole("button", { name: "Angle" }).click();
      await page.evaluate(axe);
      const found = await page.evaluate(() => window.axe.run(document, { runOnly: ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa"] }));
      const serious = found.violations.filter(({ impact }) => ["serious", "critical"].includes(impact));
      assert.deepEqual(serious.map(({ id, nodes }) => `${id}: ${nodes.map(({ html }) => html)}`), [], `${scheme} ${width}`);
      const wide = await page.evaluate(() => document.documentElement.scrollWidth);
      assert.ok(wide <= width, `${wide} pixels wide`);
      await page.screenshot({ path: shotPath(`measure-${scheme}-${width}`) });
      assert.deepEqual(page.complaints, []);
      await page.context().close();
    }
});

async function main() {
  viewer = await startViewer(makeVolume("block"));
  browser = await startBrowser();
  let failed = 0;
  for (const [name, run] of tests) {
    if (process.env.CVOL_ONLY && !name.includes(process.env.CVOL_ONLY)) continue;
    const start = performance.now();
    try {
      const page = await run();
      if (page) assert.deepEqual(page.complaints, []);
      console.log(`${((performance.now() - start) / 1000).toFixed(1)} s  ${name}`);
    } catch (error) {
      failed++;
      console.log(`FAILED: ${name}\n${error.stack}`);
      for (const [i, page] of browser.contexts().flatMap((context) => context.pages()).entries())
        await page.screenshot({ path: shotPath(`failed-${failed}-${i}`) }).catch(() => {});
    }
    for (const context of browser.contexts()) await context.close();
  }
  await browser.close();
  const status = await viewer.end();
  if (status) console.log(`FAILED: the viewer ended with ${status}`);
  process.exit(failed || status ? 1 : 0);
}

main();
