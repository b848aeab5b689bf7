// Tests a page of cvol export in a browser, from file://, without network and WebGL: pictures appear and equal those of
// one worker, gestures work, nothing is requested or refused.
//
// usage: test_page.mjs PAGE.html BROKEN.html, with CVOL_BROWSER_MODULES, CVOL_CHROMIUM and CVOL_SHOTS as
// tests/viewer/test_browser.mjs

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import path from "node:path";
import { pathToFileURL } from "node:url";

import { drag, middleOf, modules, openPage, openSection, settled } from "../viewer/browser.mjs";
import { shotPath, startBrowser, stateOf } from "../viewer/browser.mjs";

const [good, broken] = process.argv.slice(2).map((file) => pathToFileURL(path.resolve(file)).href);
const axe = readFileSync(modules.resolve("axe-core/axe.min.js"), "utf8");
const browser = await startBrowser();
const open = (address, options) => openPage(browser, address, { offline: true, ...options });
const tests = [];
const test = (name, fn) => tests.push([name, fn]);

const pictureOf = (page) =>
  page.evaluate(() => {
    const canvas = document.getElementById("canvas");
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    let [hash, bright] = [0, 0];
    for (let i = 0; i < data.length; i++) {
      hash = (Math.imul(hash, 31) + data[i]) | 0;
      bright += i % 4 < 3 && data[i] > 40;
    }
    return { hash, bright };
  });

for (const [width, height] of [[1280, 800], [360, 740]])
  test(`the picture appears at ${width} x ${height}, and no part asks for a server`, async () => {
    const page = await open(good, { viewport: { width, height } });
    assert.ok((await pictureOf(page)).bright > 10000);
    assert.match(await page.title(), /A <title>/);
    assert.equal(await page.locator("#caption").textContent(), "A caption");
    assert.equal(await page.locator('[data-section="compare"]').isVisible(), false);
    await page.screenshot({ path: shotPath(`page-${width}`) });
    if (width < 500) await page.locator("#drawer").click();
    const section = await openSection(page, "export");
    assert.equal(await section.getByText("Make the animation").isVisible(), false);
    await page.waitForFunction(() => document.querySelector(".command-text").value.startsWith("cvol render"));
    await page.screenshot({ path: shotPath(`page-${width}-export`) });
    return page;
  });

for (const [width, height] of [[360, 740], [1280, 800], [3840, 2160]])
  test(`no text of the panel is cut off at ${width} x ${height}`, async () => {
    const page = await open(good, { viewport: { width, height }, ready: false });
    await page.waitForFunction(() => window.cvol?.volumes.current()?.state === "ready");
    if (width < 500) await page.locator("#drawer").click();
    const cut = await page.evaluate(() => {
      for (const section of document.querySelectorAll(".section")) section.open = true;
      const nodes = [...document.querySelectorAll("#panel :is(.button, .swatch, label, summary, p):not(.unseen)")];
      const wide = nodes.filter((node) => node.clientWidth > 0 && node.scrollWidth > node.clientWidth);
      return [...wide.map((node) => node.textContent), ...(document.documentElement.scrollWidth > innerWidth ? ["the page"] : [])];
    });
    assert.deepEqual(cut, []);
    return page;
  });

test("the first picture is that of a coarse level, the last one that of the volume", async () => {
  const page = await open(good);
  const { first, volume, camera } = await page.evaluate(() => {
    const { store, volumes } = window.cvol;
    const [{ server, requested }] = window.cvolTimings;
    return { first: [server.level, requested], volume: volumes.current(), camera: store.state.view.camera };
  });
  assert.equal(first[0], 2);
  assert.equal(volume.partial, undefined);
  assert.deepEqual(camera.look_at, volume.home.look_at.map((x) => Number(x.toPrecision(6))));
  return page;
});

test("strips of several workers are the picture of one", async () => {
  const page = await open(good, { viewport: { width: 700, height: 500 } });
  const most = await page.evaluate(async () => {
    const { store, api } = window.cvol;
    const none = { surface: undefined, clip: undefined, window: undefined };
    const view = { ...store.state.view, ...none, width: 240, height: 300 };
    const { blob: strips } = await api.frame({ view, quality: "still" });
    const { blob: whole } = await api.frame({ view, quality: "still", rows: [0, 300] });
    return strips.data.reduce((largest, value, i) => Math.max(largest, Math.abs(value - whole.data[i])), 0);
  });
  assert.ok(most <= 1, `a pixel differs by ${most}`);
  return page;
});

test("a drag turns, a tap picks a value, slices show", async () => {
  const page = await open(good);
  const before = await pictureOf(page);
  const [x, y] = await middleOf(page.locator("#canvas"));
  await drag(page, [x, y], [x + 90, y + 40]);
  await settled(page);
  assert.notEqual((await pictureOf(page)).hash, before.hash);
  await page.mouse.click(x, y);
  await page.waitForFunction(() => window.cvol.store.state.page.sample !== null);
  const section = await openSection(page, "slices");
  await section.getByText("Show slices").click();
  await page.waitForFunction(() => {
    return [...document.querySelectorAll("#stage-slices canvas")].every(({ width }) => width > 10);
  });
  await page.screenshot({ path: shotPath("page-slices") });
  return page;
});

test("a link opens its view", async () => {
  const page = await open(good, { hash: "#camera.azimuth=90&mode='mip'" });
  const { view } = await stateOf(page);
  assert.equal(view.camera.azimuth, 90);
  assert.equal(view.mode, "mip");
  return page;
});

test("measuring and bookmarks need no server", async () => {
  const list = [
    { kind: "distance", of: "0", points: [[10, 10, 10], [40, 50, 10]] },
    { kind: "ellipsoid", of: "0", box: [60, 120, 80, 130, 90, 91] },
  ];
  const page = await open(good, { hash: `#.page.measures.list=${encodeURIComponent(JSON.stringify(list))}` });
  const section = await openSection(page, "measure");
  await page.waitForFunction(() => document.querySelectorAll(".measure-figures dd").length === 7);
  const [length, mean] = await section.locator(".measure-figures dd").allTextContents();
  const { spacing } = await page.evaluate(() => window.cvol.volumes.current());
  const expected = Math.hypot(30 * spacing[0], 40 * spacing[1]);
  assert.ok(Math.abs(parseFloat(length) - expected) < 1e-3 && length.includes(" mm"), `${length}, not ${expected} mm`);
  assert.match(mean, /^[\d.]+ ± [\d.]+$/);
  await page.locator("#canvas").focus();
  await page.keyboard.press("s");
  await openSection(page, "bookmarks");
  assert.deepEqual(await page.locator(".bookmark-list .link").allTextContents(), ["View 1"]);
  await page.screenshot({ path: shotPath("page-measure") });
  return page;
});

test("Save PNG saves the picture", async () => {
  const page = await open(good);
  const section = await openSection(page, "export");
  const [download] = await Promise.all([page.waitForEvent("download"), section.getByText("Save PNG").click()]);
  const file = readFileSync(await download.path());
  assert.equal(file.toString("latin1", 1, 4), "PNG");
  return page;
});

test("axe finds no serious violation", async () => {
  const page = await open(good);
  const { violations } = await page.evaluate(`${axe}; axe.run()`);
  assert.deepEqual(violations.filter(({ impact }) => ["serious", "critical"].includes(impact)).map(({ id }) => id), []);
  return page;
});

test("a damaged file gives a sentence", async () => {
  const page = await open(broken, { ready: false });
  await page.waitForFunction(() => !document.getElementById("notice").hidden);
  assert.match(await page.locator("#notice").textContent(), /broken\.cvol/);
  return page;
});

test("a browser that is too old gives a sentence", async () => {
  const page = await (await browser.newContext()).newPage();
  await page.addInitScript(() => delete globalThis.DecompressionStream);
  await page.goto(good);
  assert.match(await page.locator("#notice").textContent(), /newer browser/);
  assert.equal(await page.locator("#notice").isVisible(), true);
  return Object.assign(page, { complaints: [] });
});

let failed = 0;
for (const [name, fn] of tests) {
  const begin = Date.now();
  try {
    const page = await fn();
    assert.deepEqual(page.complaints, []);
    await page.context().close();
    console.log(`${((Date.now() - begin) / 1000).toFixed(1)} s  ${name}`);
  } catch (error) {
    failed++;
    console.log(`FAILED: ${name}\n${error.stack}`);
  }
}
await browser.close();
console.log(failed ? `${failed} failed` : "all passed");
process.exit(failed ? 1 : 0);
