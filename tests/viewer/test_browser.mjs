// Tests the viewer's page in a browser: after any input by mouse, keys and links it shows the server's picture.
//
// usage: test_browser.mjs VOLUME.cvol OTHER.cvol, with CVOL, CVOL_BROWSER_MODULES (node_modules' folder), CVOL_CHROMIUM
// and CVOL_SHOTS (where screenshots go); CVOL_ONLY: a word of the tests to run.

import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";

import { checkPicture, drag, middleOf, modules, openPage, openSection, TIMEOUT_MS, settled, shotPath, startBrowser, startViewer, stateOf } from "./browser.mjs";

const axe = readFileSync(modules.resolve("axe-core/axe.min.js"), "utf8");
const tests = [];
const test = (name, fn) => tests.push([name, fn]);
let viewer, browser;
const open = (options) => openPage(browser, viewer.address, options);

// ---- the view -----------------------------------------------------------------------------------

test("the page opens and shows the picture of the server", async () => {
  const page = await open();
  await checkPicture(page);
  assert.match(await page.title(), /cvol/);
  return page;
});

test("dragging turns, with shift it pans, the wheel zooms", async () => {
  const page = await open();
  let before = await checkPicture(page);
  const [x, y] = await middleOf(page.locator("#canvas"));
  const camera = async () => (await stateOf(page)).view.camera;
  const first = await camera();

  await drag(page, [x, y], [x + 90, y + 40]);
  before = await checkPicture(page, before);
  const turned = await camera();
  assert.notEqual(turned.azimuth, first.azimuth);
  assert.notEqual(turned.elevation, first.elevation);
  assert.equal(turned.zoom, first.zoom);

  await page.keyboard.down("Shift");
  await drag(page, [x, y], [x + 50, y - 30]);
  await page.keyboard.up("Shift");
  before = await checkPicture(page, before);
  assert.notDeepEqual((await camera()).look_at, turned.look_at);

  await page.mouse.move(x + 60, y - 20);
  await page.mouse.wheel(0, -240);
  await page.waitForFunction((zoom) => window.cvol.store.state.view.camera.zoom > zoom, turned.zoom);
  before = await checkPicture(page, before);

  await page.locator("#undo").click();
  before = await checkPicture(page, before);
  assert.equal((await camera()).zoom, turned.zoom);
  await page.locator("#redo").click();
  before = await checkPicture(page, before);
  await page.locator("#reset").click();
  await checkPicture(page, before);
  assert.deepEqual(await camera(), first);
  return page;
});

test("the scale bar has the length that it names", async () => {
  const page = await open();
  const diagonal = Math.hypot(150, 184.5, 157.5); // of the brain, in mm
  for (const viewport of [{ width: 1280, height: 800 }, { width: 390, height: 844 }]) {
    await page.setViewportSize(viewport);
    await settled(page);
    const [text, width, height] = await page.evaluate(() => [
      document.querySelector("#scale").textContent,
      parseFloat(getComputedStyle(document.querySelector("#scale"), "::after").width),
      document.querySelector("#canvas").getBoundingClientRect().height,
    ]);
    const { zoom } = (await stateOf(page)).view.camera;
    assert.match(text, /^\d+ mm \(assumed\)$/); // the file states no unit
    assert.ok(Math.abs((width * diagonal) / zoom / height - parseFloat(text)) < 0.02 * parseFloat(text));
  }
  return page;
});

test("the page shows motion pictures while the mouse is down, then a still picture", async () => {
  const page = await open();
  await page.evaluate(() => (window.cvolTimings.length = 0));
  const [x, y] = await middleOf(page.locator("#canvas"));
  await page.mouse.move(x, y);
  await page.mouse.down();
  for (let i = 1; i <= 12; i++) {
    await page.mouse.move(x + 6 * i, y);
    await page.waitForTimeout(20);
  }
  await page.waitForFunction(() => window.cvolTimings.some(({ quality }) => quality === "motion"));
  await page.mouse.up();
  await checkPicture(page);
  const qualities = await page.evaluate(() => window.cvolTimings.map(({ quality, requested, shown }) => [quality, shown >= requested]));
  assert.ok(qualities.every(([, right]) => right));
  assert.equal(qualities.at(-1)[0], "still");
  return page;
});

test("two fingers zoom, one turns", async () => {
  const page = await open({ hasTouch: true, viewport: { width: 390, height: 800 } });
  let before = await checkPicture(page);
  const session = await page.context().newCDPSession(page);
  const [x, y] = await middleOf(page.locator("#canvas"));
  const touch = (type, ...points) => session.send("Input.dispatchTouchEvent", { type, touchPoints: points.map(([px, py], id) => ({ x: px, y: py, id })) });
  const camera = async () => (await stateOf(page)).view.camera;
  const first = await camera();
  await touch("touchStart", [x - 30, y], [x + 30, y]);
  for (let i = 1; i <= 5; i++) await touch("touchMove", [x - 30 - 8 * i, y], [x + 30 + 8 * i, y]);
  await touch("touchEnd");
  await page.waitForFunction((zoom) => window.cvol.store.state.view.camera.zoom > 1.5 * zoom, first.zoom);
  before = await checkPicture(page, before);
  await touch("touchStart", [x, y]);
  for (let i = 1; i <= 5; i++) await touch("touchMove", [x + 10 * i, y]);
  await touch("touchEnd");
  await checkPicture(page, before);
  assert.notEqual((await camera()).azimuth, first.azimuth);
  return page;
});

test("two pages of one viewer", async () => {
  const [left, right] = [await open(), await open({ viewport: { width: 700, height: 600 } })];
  const before = [await checkPicture(left), await checkPicture(right)];
  const [a, b] = [await middleOf(left.locator("#canvas")), await middleOf(right.locator("#canvas"))];
  await Promise.all([
    drag(left, a, [a[0] + 120, a[1]], { steps: 20 }),
    drag(right, b, [b[0], b[1] - 100], { steps: 20 }),
  ]);
  await checkPicture(left, before[0]);
  await checkPicture(right, before[1]);
  assert.deepEqual(right.complaints, []);
  return left;
});

test("links open the same view", async () => {
  const page = await open();
  const before = await checkPicture(page);
  await page.evaluate(() =>
    window.cvol.store.set({
      view: { mode: "composite", camera: { azimuth: 40, elevation: 25, zoom: 1.4 }, light: { on: true }, clip: { box: [null, 120, null, null, null, null] }, transfer: "bone" },
    }),
  );
  const after = await checkPicture(page, before);
  const section = await openSection(page, "export");
  const link = await section.getByLabel("Opens this view again").inputValue();
  await page.waitForFunction((address) => location.href === address, link);
  const again = await open({ hash: new URL(link).hash });
  const restored = await checkPicture(again);
  assert.deepEqual((await stateOf(again)).view, (await stateOf(page)).view);
  assert.equal(restored.hash, after.hash);
  assert.deepEqual(again.complaints, []);
  return page;
});

// ---- panels -------------------------------------------------------------------------------------

test("the transfer function's points", async () => {
  const page = await open();
  let before = await checkPicture(page);
  const section = await openSection(page, "transfer");
  const handles = section.locator(".transfer-editor [role=slider]");
  const count = await handles.count();
  assert.ok(count >= 2, `${count} points`);
  const handle = handles.nth(count - 1);
  await handle.focus();
  for (let i = 0; i < 4; i++) await page.keyboard.press("ArrowDown");
  before = await checkPicture(page, before);
  assert.ok(Array.isArray((await stateOf(page)).view.transfer));

  await handles.nth(1).scrollIntoViewIfNeeded();
  const [x, y] = await middleOf(handles.nth(1));
  await drag(page, [x, y], [x + 30, y - 25]);
  before = await checkPicture(page, before);
  await page.locator("#undo").click();
  await checkPicture(page, before);
  return page;
});

test("key m cycles through the modes", async () => {
  const page = await open();
  // Without the empty space around the object, where the minimum of every ray is black.
  await page.evaluate(() => {
    const { dims } = window.cvol.volumes.current();
    const box = dims.flatMap((n) => [Math.round(0.4 * n), Math.round(0.6 * n)]);
    window.cvol.store.set({ view: { clip: { box, planes: [] } } });
  });
  let before = await checkPicture(page);
  // Shading is composite with light; the page may ask for the window of other modes first.
  const now = () => stateOf(page).then(({ view }) => view.mode + view.light.on);
  for (const mode of ["composite", "iso", "xray", "mip", "min"]) {
    const last = await now();
    await page.keyboard.press("m");
    await page.waitForFunction((old) => window.cvol.store.state.view.mode + window.cvol.store.state.view.light.on !== old, last);
    assert.equal((await stateOf(page)).view.mode, mode);
    before = await checkPicture(page, before);
  }
  return page;
});

test("clipping", async () => {
  const page = await open();
  let before = await checkPicture(page);
  const section = await openSection(page, "clip");
  const end = section.locator("input[type=range]").nth(1);
  await end.focus();
  for (let i = 0; i < 3; i++) await page.keyboard.press("PageDown");
  before = await checkPicture(page, before);
  assert.ok((await stateOf(page)).view.clip.box);
  await section.getByLabel("Clip plane", { exact: true }).check();
  before = await checkPicture(page, before);
  assert.equal((await stateOf(page)).view.clip.planes.length, 1);
  await section.getByRole("button", { name: "Flip" }).click();
  before = await checkPicture(page, before);
  await section.getByRole("button", { name: "Whole volume" }).click();
  await section.getByLabel("Clip plane", { exact: true }).uncheck();
  await checkPicture(page, before);
  return page;
});

test("slices with one cross-hair", async () => {
  const page = await open();
  const section = await openSection(page, "slices");
  await section.getByLabel("Show slices").check();
  const canvases = page.locator("#stage-slices canvas");
  await canvases.first().waitFor();
  assert.equal(await canvases.count(), 3);
  const colours = () =>
    page.evaluate(() =>
      [...document.querySelectorAll("#stage-slices canvas")].map((canvas) => {
        const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
        return new Set(data.filter((_, i) => i % 4 === 0)).size;
      }),
    );
  await page.waitForFunction(
    () =>
      [...document.querySelectorAll("#stage-slices canvas")].every((canvas) => {
        const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
        return new Set(data.filter((_, i) => i % 4 === 0)).size > 20;
      }),
  );
  assert.ok((await colours()).every((n) => n > 20));
  const box = await canvases.first().boundingBox();
  await page.mouse.click(box.x + box.width * 0.45, box.y + box.height * 0.4);
  await page.waitForFunction(() => window.cvol.store.state.page.sample !== null);
  const { sample } = (await stateOf(page)).page;
  const readout = page.locator(".slices-readout");
  await page.waitForFunction((at) => document.querySelector(".slices-readout").textContent.includes(` at ${at.join(", ")}`), sample);
  const reply = await page.evaluate((at) => window.cvol.api.value(window.cvol.volumes.current().id, ...at), sample);
  assert.ok((await readout.textContent()).replace("\u2212", "-").includes(String(Math.round(reply.meaning ?? reply.value))), await readout.textContent());
  await settled(page);
  await page.screenshot({ path: shotPath("slices") });
  return page;
});

test("comparison with another file, and the difference picture", async () => {
  const page = await open();
  const section = await openSection(page, "compare");
  await section.getByLabel("Side by side").check();
  const second = page.locator("#stage-compare canvas");
  await second.waitFor();
  const brightness = () =>
    page.waitForFunction(() => {
      const canvas = document.querySelector("#stage-compare canvas");
      if (canvas.width < 2) return false;
      const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
      return data.filter((value, i) => i % 4 < 3 && value > 40).length > 100;
    });
  await brightness();
  await settled(page);
  await page.screenshot({ path: shotPath("compare") });
  await section.getByLabel("Difference", { exact: true }).check();
  await page.getByText(/PSNR of the pictures \d/).first().waitFor();
  await page.screenshot({ path: shotPath("difference") });
  await section.getByLabel("Off", { exact: true }).check();
  await checkPicture(page);
  return page;
});

test("export of pictures, commands and films", async () => {
  const page = await open();
  const section = await openSection(page, "export");
  await section.getByLabel("Width").fill("120");
  await section.getByLabel("Height").fill("90");
  const [download] = await Promise.all([page.waitForEvent("download"), section.getByRole("button", { name: "Save PNG" }).click()]);
  assert.match(download.suggestedFilename(), /120x90\.png$/);
  const png = readFileSync(await download.path());
  assert.deepEqual([png.readUInt32BE(16), png.readUInt32BE(20)], [120, 90]);
  await page.waitForFunction(() => /^cvol render .* --size 120x90/.test(document.querySelector(".command-text").value));
  await section.getByLabel("Pictures", { exact: true }).fill("3");
  await section.getByRole("button", { name: "Make the animation" }).click();
  const film = section.getByText("Save the animation");
  await film.waitFor();
  const bytes = await page.evaluate(async (href) => (await (await fetch(href)).arrayBuffer()).byteLength, await film.getAttribute("href"));
  assert.ok(bytes > 100, `${bytes} bytes`);
  return page;
});

// ---- keys ---------------------------------------------------------------------------------------

test("keyboard control", async () => {
  const page = await open();
  let before = await checkPicture(page);
  const focused = () => page.evaluate(() => document.activeElement.id || document.activeElement.tagName);
  for (let i = 0; i < 30 && (await focused()) !== "canvas"; i++) await page.keyboard.press("Tab");
  assert.equal(await focused(), "canvas");
  const outline = await page.evaluate(() => {
    const ring = (node) => getComputedStyle(node).outlineStyle !== "none" || getComputedStyle(node).boxShadow !== "none";
    return ring(document.activeElement) || ring(document.activeElement.parentElement) || getComputedStyle(document.activeElement.parentElement, "::after").content !== "none";
  });
  assert.ok(outline, "the focused element must have an outline");
  for (const key of ["ArrowRight", "ArrowUp", "Shift+ArrowLeft", "+", ",", "2", "p"]) {
    await page.keyboard.press(key);
    before = await checkPicture(page, before);
  }
  await page.keyboard.press("z");
  before = await checkPicture(page, before);
  await page.keyboard.press("Shift+z");
  before = await checkPicture(page, before);
  await page.keyboard.press("r");
  await checkPicture(page, before);
  await page.keyboard.press("?");
  await page.waitForFunction(() => document.getElementById("help").open);
  await page.screenshot({ path: shotPath("help") });
  await page.keyboard.press("Escape");
  await page.waitForFunction(() => !document.getElementById("help").open);
  assert.equal(await focused(), "canvas");

  // The Tab key reaches every control, and no control traps the focus.
  await page.evaluate(() => document.querySelectorAll("details.section").forEach((section) => (section.open = true)));
  const count = () => page.evaluate(
    () => [...document.querySelectorAll("#panel :is(button, input, select, textarea, a[href], summary)")].filter((node) => !node.disabled && node.tabIndex >= 0 && !node.closest("[inert]") && node.type !== "radio" && node.checkVisibility()).length,
  );
  let wanted = await count();
  const reached = new Set();
  const controls = "#panel :is(button, input, select, textarea, a[href], summary)";
  for (let i = 0; i < wanted + 80; i++) {
    await page.keyboard.press("Tab");
    const which = await page.evaluate(() => {
      const all = [...document.querySelectorAll("#panel :is(button, input, select, textarea, a[href], summary)")];
      const node = document.activeElement;
      return node.type === "radio" ? -1 : all.indexOf(node);
    });
    if (which >= 0) reached.add(which);
    if (reached.size >= wanted && reached.size >= (wanted = await count())) break; // some controls appear late
  }
  const missed = await page.evaluate(
    ([found, selector]) => [...document.querySelectorAll(selector)].filter((node, i) => !found.includes(i) && !node.disabled && node.tabIndex >= 0 && !node.closest("[inert]") && node.type !== "radio" && node.checkVisibility()).map((node) => node.outerHTML),
    [[...reached], controls],
  );
  assert.deepEqual(missed, [], "controls that the Tab key does not reach");
  return page;
});

// ---- series -------------------------------------------------------------------------------------

test("a series has times", async () => {
  const series = await startViewer(process.env.CVOL_SERIES);
  const page = await openPage(browser, series.address, { hash: "#time=7", viewport: { width: 360, height: 740 }, bypassCSP: true });
  const time = () => page.evaluate(() => window.cvol.store.state.view.time);
  assert.equal(await time(), 2, "a link beyond the last time shows the last one");
  let before = await checkPicture(page);
  assert.match(await page.locator("#time").innerText(), /2\s*of 2\s*5 s/);
  await page.screenshot({ path: shotPath("series-360") });
  await page.locator("#time input").fill("0");
  before = await checkPicture(page, before);
  await page.setViewportSize({ width: 1280, height: 800 });
  before = await checkPicture(page, before);
  await page.locator("#canvas").focus();
  await page.keyboard.press("k");
  before = await checkPicture(page, before);
  assert.equal(await time(), 1);
  await page.evaluate(() => window.cvol.store.set({ page: { layout: "slices", playing: 20 } }));
  await page.keyboard.press(" "); // shows 2, then 0
  await page.waitForFunction(() => window.cvol.view3d.frame.view.time === 0);
  await page.screenshot({ path: shotPath("series-1280") });
  await page.keyboard.press(" ");
  await checkPicture(page);
  const now = await time();
  await page.waitForFunction((t) => location.hash.includes("time=") || t === 0, now);
  await page.waitForFunction((t) => document.querySelector(".slice-x").dataset.shown.split(" ")[1] === String(t), now);
  const section = await openSection(page, "compare");
  await section.getByLabel("Difference").check();
  await section.getByLabel("Time").fill("1");
  await section.getByLabel("Time").press("Enter");
  await page.evaluate(() => window.cvol.store.set({ view: { time: 2 } }, { undo: false }));
  await page.getByText(/PSNR of the pictures/).first().waitFor({ state: "attached" });
  await page.evaluate(() => window.cvol.store.set({ view: { time: 1 } }, { undo: false }));
  await page.getByText(/the pictures are equal/).first().waitFor({ state: "attached" });
  await page.screenshot({ path: shotPath("series-compared") });
  assert.deepEqual(await violations(page), []);
  await page.context().close();
  assert.equal(await series.end(), 0);
  return page;
});

test("channels are shown together", async () => {
  const cell = await startViewer(process.env.CVOL_CHANNELS);
  const page = await openPage(browser, cell.address, { bypassCSP: true });
  await page.waitForFunction(() => window.cvol.volumes.list().every(({ state }) => state === "ready"));
  let before = await checkPicture(page);
  const list = page.locator(".channel-list");
  assert.equal((await list.innerText()).replaceAll(/\s+/g, " ").trim(), "DAPI GFP");
  await list.getByLabel("Show DAPI").uncheck();
  before = await checkPicture(page, before);
  assert.ok(await list.getByLabel("Show GFP").isDisabled(), "one channel is always shown");
  await list.getByLabel("GFP", { exact: true }).check();
  assert.equal((await checkPicture(page)).hash, before.hash, "choosing a channel changes no picture");
  await page.getByLabel("Preset").selectOption("hot");
  before = await checkPicture(page, before);
  await list.getByLabel("Colour of GFP").fill("#ff8000");
  before = await checkPicture(page, before);
  await page.screenshot({ path: shotPath("channels") });
  await page.waitForFunction(() => location.hash.includes("hot"));
  const again = await openPage(browser, cell.address, { hash: await page.evaluate(() => location.hash) });
  assert.equal((await checkPicture(again)).hash, before.hash);
  assert.deepEqual(again.complaints, []);
  await page.keyboard.press("m"); // lit
  assert.deepEqual(await violations(page), []);
  await Promise.all([page, again].map((one) => one.context().close()));
  assert.equal(await cell.end(), 0);
  return page;
});

// ---- overlays -----------------------------------------------------------------------------------

// Writes an NRRD file of 24 samples along each axis, over the sample scan.
function writeField(path, type, more, valueAt) {
  const side = 24;
  const samples = new Uint16Array(side ** 3);
  for (let i = 0; i < samples.length; i++) {
    const place = [0, 1, 2].map((axis) => -88 + (176 / (side - 1)) * (Math.floor(i / side ** axis) % side));
    samples[i] = valueAt(...place);
  }
  const step = 176 / (side - 1);
  const head = [
    ...["NRRD0004", `type: ${type}`, "dimension: 3", `sizes: ${side} ${side} ${side}`, "encoding: raw", "endian: little"],
    ...["space: right-anterior-superior", `space directions: (${step},0,0) (0,${step},0) (0,0,${step})`],
    ...["space origin: (-88,-88,-88)", ...more],
  ];
  writeFileSync(path, Buffer.concat([Buffer.from(`${head.join("\n")}\n\n`), Buffer.from(samples.buffer)]));
  return path;
}

test("overlays of values and of labels", async () => {
  const spots = writeField(shotPath("spots").replace(".png", ".nrrd"), "ushort", [], (x, y, z) =>
    Math.round(9000 * Math.exp(-((x + 38) ** 2 + (y + 22) ** 2 + (z - 54) ** 2) / 700)),
  );
  const names = ["Segment0_LabelValue:=4", "Segment0_Name:=Front", "Segment0_Color:=1 0.5 0"];
  const parts = writeField(shotPath("parts").replace(".png", ".seg.nrrd"), "ushort", names, (x, y, z) =>
    Math.hypot(x, y - 50, z - 10) < 34 ? 4 : Math.hypot(x, y + 50, z - 10) < 34 ? 9 : Math.hypot(x - 30, y, z - 30) < 20 ? 17 : 0,
  );
  const fused = await startViewer(process.argv[2], process.argv[3], "--overlay", spots, "--overlay", parts, "--overlay-opacity", "0.9");
  const quick = "#light.on=false"; // this test draws many pictures
  const page = await openPage(browser, fused.address, { bypassCSP: true, viewport: { width: 700, height: 420 }, hash: quick });
  let before = await checkPicture(page);
  const section = await openSection(page, "overlays");
  const [values, labels] = [0, 1].map((i) => section.locator(".overlay-item").nth(i));
  assert.match(await values.innerText(), /^Overlay spots\.nrrd/);
  assert.match((await labels.innerText()).replaceAll(/\s+/g, " "), /parts\.seg\.nrrd.* 3 of 3 labels.* 4 Front 9 17/);
  assert.equal(await labels.getByLabel("Opacity", { exact: true }).last().inputValue(), "0.9");
  await page.screenshot({ path: shotPath("overlays") });

  // Each control changes the picture, which stays that of the server.
  const changes = [
    () => labels.getByLabel("Show Front").uncheck(),
    () => labels.getByRole("button", { name: "None" }).click(),
    () => values.getByLabel("Colours").selectOption("viridis"),
    () => values.getByLabel("From").fill("6000").then(() => page.keyboard.press("Enter")),
    () => values.getByRole("button", { name: "Fit" }).click(),
    () => values.getByLabel("Opacity", { exact: true }).last().fill("0.4").then(() => page.keyboard.press("Enter")),
    () => labels.getByRole("button", { name: "All" }).click(),
    () => values.getByRole("checkbox").uncheck(),
    () => labels.getByLabel("Show label 17").uncheck(),
  ];
  for (const change of changes) {
    await change();
    before = await checkPicture(page, before);
  }
  assert.equal((await labels.innerText()).match(/\d of 3 labels/)[0], "2 of 3 labels");
  await page.locator("#undo").click();
  assert.deepEqual((await stateOf(page)).view.overlays[1].labels, null);
  await page.locator("#redo").click();
  before = await checkPicture(page);

  // Links, the command line and slices have them too, and another volume keeps the settings.
  await page.waitForFunction(() => location.hash.includes("overlays="));
  const again = await openPage(browser, fused.address, { viewport: page.viewportSize(), hash: await page.evaluate(() => location.hash) });
  assert.equal((await checkPicture(again)).hash, before.hash);
  assert.deepEqual(again.complaints, []);
  await again.context().close();
  await openSection(page, "export");
  await page.waitForFunction(() => /--overlay \S*parts.seg.nrrd .*--overlay-labels 4,9/.test(document.querySelector(".command-text").value));
  assert.ok(!(await page.locator(".command-text").inputValue()).includes("spots.nrrd"));
  await page.evaluate(() => window.cvol.store.set({ page: { layout: "slices" } }));
  const coloured = () =>
    page.waitForFunction(() => {
      const canvas = document.querySelector(".slice-z canvas");
      if (canvas.width < 2) return false;
      const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
      return data.some((value, i) => i % 4 === 0 && Math.abs(value - data[i + 2]) > 60);
    });
  await coloured();
  await page.screenshot({ path: shotPath("overlays-slices") });
  await page.evaluate(() => window.cvol.store.set({ page: { layout: "single" } }));
  const settings = (await stateOf(page)).view.overlays;
  await page.locator("#chooser select").selectOption({ index: 1 });
  await page.waitForFunction(() => window.cvol.store.state.view.volume === "1");
  await checkPicture(page, before);
  assert.deepEqual((await stateOf(page)).view.overlays, settings);
  assert.deepEqual(await violations(page), []);
  for (const colorScheme of ["light", "dark"]) {
    const small = await openPage(browser, fused.address, { viewport: { width: 360, height: 740 }, colorScheme, bypassCSP: true, hash: quick });
    await small.evaluate(() => window.cvol.store.set({ page: { open: { look: false, transfer: false } } }));
    await small.locator("#drawer").click();
    await checkPicture(small);
    assert.deepEqual(await violations(small), []);
    await small.screenshot({ path: shotPath(`overlays-360-${colorScheme}`) });
    assert.deepEqual(small.complaints, []);
  }
  await Promise.all(browser.contexts().map((context) => context.close()));
  assert.equal(await fused.end(), 0);
  return page;
});

// ---- accessibility, sizes -----------------------------------------------------------------------

async function violations(page) {
  const found = await page.evaluate(async (source) => {
    if (!window.axe) new Function(source)(); // no script tag: the page's policy forbids foreign scripts
    const { violations } = await window.axe.run(document, { resultTypes: ["violations"] });
    return violations.map(({ id, impact, help, nodes }) => ({ id, impact, help, at: nodes.slice(0, 3).map(({ target, any }) => `${target} ${any[0]?.message ?? ""}`) }));
  }, axe);
  return found.filter(({ impact }) => ["serious", "critical"].includes(impact)).map((v) => JSON.stringify(v));
}

for (const width of [360, 1280])
  for (const colorScheme of ["light", "dark"])
    test(`axe finds no serious violation at ${width} pixels, ${colorScheme}`, async () => {
      const page = await open({ viewport: { width, height: width < 500 ? 740 : 900 }, colorScheme, bypassCSP: true });
      const found = await violations(page);
      await page.evaluate(() => {
        document.querySelectorAll("details.section").forEach((section) => (section.open = true));
        window.cvol.store.set({ view: { light: { on: true } }, page: { layout: "slices" } });
      });
      if (width < 500) await page.locator("#drawer").click();
      await settled(page);
      found.push(...(await violations(page)));
      await page.evaluate(() => window.cvol.store.set({ page: { layout: "compare" } }));
      await settled(page);
      found.push(...(await violations(page)));
      await page.screenshot({ path: shotPath(`sections-${width}-${colorScheme}`) });
      await page.evaluate(() => window.cvol.store.set({ page: { layout: "single" } }));
      assert.deepEqual([...new Set(found)], []);
      return page;
    });

for (const [width, height] of [[360, 740], [1280, 800], [2560, 1440]])
  test(`nothing is clipped at ${width} x ${height}`, async () => {
    const page = await open({ viewport: { width, height }, colorScheme: width === 1280 ? "light" : "dark" });
    await checkPicture(page);
    await page.screenshot({ path: shotPath(`page-${width}x${height}`) });
    const wide = await page.evaluate(() => document.documentElement.scrollWidth > innerWidth);
    assert.equal(wide, false, "the page must not scroll sideways");
    const { width: w, height: h } = await page.locator("#canvas").boundingBox();
    assert.ok(w * h > 0.2 * width * height, `the picture has ${w} x ${h}`);
    return page;
  });

// ---- end of the viewer --------------------------------------------------------------------------

test("a page reports that its viewer ended", async () => {
  const other = await startViewer(process.argv[2]);
  const page = await openPage(browser, other.address);
  assert.equal(await other.end(), 0);
  const [x, y] = await middleOf(page.locator("#canvas"));
  await drag(page, [x, y], [x + 50, y]);
  await page.getByText(/does not answer/).first().waitFor({ state: "attached" });
  assert.ok(!page.complaints.some((text) => text.startsWith("exception")), page.complaints.join("\n"));
  page.complaints = [];
  return page;
});

// ---- run ----------------------------------------------------------------------------------------

const only = process.env.CVOL_ONLY ?? "";
const failed = [];
viewer = await startViewer(...process.argv.slice(2));
browser = await startBrowser();
for (const [name, fn] of tests) {
  if (!name.includes(only)) continue;
  const start = performance.now();
  let timer;
  try {
    const late = new Promise((_, reject) => (timer = setTimeout(() => reject(new Error("timeout")), 2 * TIMEOUT_MS)));
    const page = await Promise.race([fn(), late]);
    assert.deepEqual(page.complaints, []);
  } catch (error) {
    failed.push(name);
    console.log(`FAILED: ${name}\n${error.stack}`);
    let k = 0;
    for (const context of browser.contexts())
      for (const page of context.pages()) await page.screenshot({ path: shotPath(`failed-${failed.length}-${++k}`) }).catch(() => {});
  }
  clearTimeout(timer);
  console.log(`${((performance.now() - start) / 1000).toFixed(1)} s  ${name}`);
  await Promise.all(browser.contexts().map((context) => context.close()));
}
await browser.close();
const status = await viewer.end();
if (status !== 0) failed.push(`the viewer ended with status ${status}`);
console.log(failed.length ? `${failed.length} failed: ${failed.join("; ")}` : "all passed");
process.exit(failed.length ? 1 : 0);
