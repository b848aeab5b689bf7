// Shared by the page's browser tests: starts a viewer and a browser, and opens pages. Any complaint of a page fails
// the test.

import { spawn } from "node:child_process";
import { mkdirSync } from "node:fs";
import { createRequire } from "node:module";
import path from "node:path";

export const TIMEOUT_MS = 60000; // a generous limit: only a missing event fails
const { CVOL, CVOL_BROWSER_MODULES, CVOL_CHROMIUM = "/usr/bin/chromium", CVOL_SHOTS = "screenshots" } = process.env;

export const modules = createRequire(path.join(path.resolve(CVOL_BROWSER_MODULES), "x.js"));
const { chromium } = modules("playwright-core");

mkdirSync(CVOL_SHOTS, { recursive: true });
export const shotPath = (name) => path.join(CVOL_SHOTS, `${name}.png`);

// Starts the program; resolves with its address. end() resolves with its exit status.
export async function startViewer(...files) {
  const child = spawn(CVOL, ["view", "--no-browser", "--json", ...files], { stdio: ["ignore", "pipe", "inherit"] });
  process.on("exit", () => child.kill()); // no process remains after a failure
  const ended = new Promise((resolve) => child.on("exit", (code, signal) => resolve(code ?? signal)));
  let text = "";
  for await (const chunk of child.stdout) {
    text += chunk;
    if (text.includes("}")) break;
  }
  return {
    address: JSON.parse(text).address,
    pid: child.pid,
    end() {
      child.kill("SIGINT");
      return ended;
    },
  };
}

export const startBrowser = () =>
  chromium.launch({
    executablePath: CVOL_CHROMIUM,
    args: ["--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--force-color-profile=srgb"],
  });

// Opens a page in its own context. page.complaints lists its warnings, errors and unexpected requests.
export async function openPage(browser, address, { hash = "", ready = true, ...options } = {}) {
  const context = await browser.newContext({ viewport: { width: 1280, height: 800 }, reducedMotion: "reduce", ...options });
  const page = await context.newPage();
  page.setDefaultTimeout(TIMEOUT_MS);
  page.complaints = [];
  const complain = (text) => page.complaints.push(text);
  page.on("console", (message) => {
    // The browser reports failed responses by itself; the response handler below records the relevant ones. It also
    // warns that the tests read the canvas too often.
    const own = /^(Failed to load resource|Canvas2D: Multiple readback)/.test(message.text());
    if (["error", "warning"].includes(message.type()) && !own) complain(`${message.type()}: ${message.text()}`);
  });
  page.on("pageerror", (error) => complain(`exception: ${error.stack}`));
  page.on("requestfailed", (request) => {
    if (request.failure().errorText !== "net::ERR_ABORTED") complain(`${request.url()}: ${request.failure().errorText}`);
  });
  page.on("response", (response) => {
    // 409: the page asked for a newer picture
    if (response.status() >= 400 && response.status() !== 409) complain(`${response.url()}: ${response.status()}`);
  });
  page.on("request", (request) => {
    const url = request.url();
    if (!url.startsWith(address) && !/^(blob|data):/.test(url)) complain(`asks for ${url}`);
  });
  await page.goto(address + hash);
  await page.waitForFunction(() => window.cvol); // the script of a page of one file starts after the page has loaded
  if (ready) await settled(page);
  return page;
}

// Waits until the canvas shows the still picture of the current view, in the size of the stage, and no picture is on
// its way: "Redo" soon after "Undo" returns to the view on the canvas while that of "Undo" still comes. The page
// learns of a new size only with the next frame.
export async function settled(page) {
  await page.waitForFunction(() => {
    const { view3d, store } = window.cvol ?? {};
    const canvas = document.getElementById("canvas");
    const { width, height } = canvas.parentElement.getBoundingClientRect();
    const fits = (pixels, length) => Math.abs(pixels - Math.round(length) * devicePixelRatio) < 1;
    return (
      view3d?.frame?.view === store.state.view &&
      !view3d.pending &&
      view3d.frame.timing.quality === "still" &&
      fits(canvas.width, width) &&
      fits(canvas.height, height)
    );
  });
}

export const stateOf = (page) => page.evaluate(() => window.cvol.store.state);

// A hash of the canvas' pixels, and the number of bytes that differ from the server's picture of the same view.
export const pictureOf = (page) =>
  page.evaluate(async () => {
    const { requestView } = await import(new URL("state/view.js", document.baseURI).href);
    const canvas = document.getElementById("canvas");
    const { width, height } = canvas;
    const bytesOf = (context) => context.getImageData(0, 0, width, height).data;
    const seen = bytesOf(canvas.getContext("2d"));
    const view = requestView(window.cvol.store.state.view, width, height);
    const { blob } = await window.cvol.api.frame({ view, quality: "still", format: "png" });
    const other = new OffscreenCanvas(width, height).getContext("2d", { alpha: false });
    other.drawImage(await createImageBitmap(blob), 0, 0);
    const drawn = bytesOf(other);
    let [hash, differing, bright] = [0, 0, 0];
    for (let i = 0; i < seen.length; i++) {
      hash = (Math.imul(hash, 31) + seen[i]) | 0;
      differing += seen[i] !== drawn[i];
      bright += i % 4 < 3 && seen[i] > 40;
    }
    return { width, height, hash, differing, bright };
  });

// Waits for the still picture, and checks that it equals the server's.
export async function checkPicture(page, before = null) {
  await settled(page);
  const picture = await pictureOf(page);
  if (picture.differing) throw new Error(`${picture.differing} bytes of the canvas differ from the server's picture`);
  if (!(picture.bright > 100)) throw new Error(`the picture is empty; ${JSON.stringify((await stateOf(page)).view)}`);
  if (before && before.hash === picture.hash && before.width === picture.width) throw new Error(`the picture must change; ${JSON.stringify((await stateOf(page)).view)}`);
  return picture;
}

export async function drag(page, from, to, { steps = 6, button = "left" } = {}) {
  await page.mouse.move(...from);
  await page.mouse.down({ button });
  await page.mouse.move(...to, { steps });
  await page.mouse.up({ button });
}

export async function middleOf(locator) {
  const box = await locator.boundingBox();
  return [box.x + box.width / 2, box.y + box.height / 2];
}

export async function openSection(page, name) {
  const section = page.locator(`[data-section="${name}"]`);
  if (!(await section.evaluate((node) => node.open))) await section.locator("> summary").click();
  return section;
}
