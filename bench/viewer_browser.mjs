// Times from a drag to its new picture in a real browser, and from rest to full quality, by stages of page and
// server. Run by bench/viewer_browser.sh. Prints a Markdown table.
// usage: node viewer_browser.mjs VOLUME... ; environment: as tests/viewer/browser.mjs, SECONDS, STAGE

import { openPage, startBrowser, startViewer } from "../tests/viewer/browser.mjs";

const seconds = Number(process.env.SECONDS ?? 10);
const stage = Number(process.env.STAGE ?? 512);

const part = (values, share) => {
  const sorted = values.slice().sort((a, b) => a - b);
  return sorted.length ? sorted[Math.min(sorted.length - 1, Math.floor(share * sorted.length))] : NaN;
};
const ms = (value) => (Number.isFinite(value) ? value.toFixed(1) : "");
const most = (names) => {
  const counts = new Map();
  for (const name of names) counts.set(name, (counts.get(name) ?? 0) + 1);
  return [...counts].sort((a, b) => b[1] - a[1])[0]?.[0] ?? "";
};

// The size of the window for a picture of STAGE pixels a side.
async function sizeStage(page) {
  for (let i = 0; i < 3; i++) {
    const box = await page.locator("canvas").first().boundingBox();
    const window = page.viewportSize();
    await page.setViewportSize({
      width: Math.round(window.width + stage - box.width),
      height: Math.round(window.height + stage - box.height),
    });
    await page.waitForTimeout(300);
  }
  return page.locator("canvas").first().boundingBox();
}

// Moves the mouse evenly for a while and releases it; returns the times of the drag's pictures, of the still
// picture, and when the mouse came to rest.
async function drag(page, box) {
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.evaluate(() => {
    window.cvolTimings.length = 0;
    addEventListener("pointermove", () => (window.lastMove = performance.now()), true);
  });
  const begin = performance.now();
  while (performance.now() - begin < 1000 * seconds) {
    const t = (performance.now() - begin) / 1000;
    await page.mouse.move(x + 0.3 * box.width * Math.sin(1.3 * t), y + 0.1 * box.height * Math.cos(t));
    await page.waitForTimeout(8);
  }
  await page.mouse.up();
  await page.waitForFunction(() => window.cvolTimings.at(-1)?.quality === "still");
  const [timings, rested] = await page.evaluate(() => [window.cvolTimings.slice(), window.lastMove]);
  return { moving: timings.filter((t) => t.quality === "motion"), still: timings.at(-1), rested };
}

const rows = [];
const browser = await startBrowser();
for (const file of process.argv.slice(2)) {
  const viewer = await startViewer(file);
  const page = await openPage(browser, viewer.address);
  const box = await sizeStage(page);
  await drag(page, box); // adapts the picture size
  const { moving, still, rested } = await drag(page, box);
  const whole = moving.map((t) => t.shown - t.requested);
  const of = (name) => ms(part(moving.map((t) => t.server[name]), 0.5));
  rows.push([
    file.split("/").at(-1), `${box.width}x${box.height}`, moving.length, ms(part(whole, 0.5)), ms(part(whole, 0.95)),
    of("queue_ms"), of("render_ms"), of("encode_ms"),
    ms(part(moving.map((t) => t.received - t.requested - t.server.queue_ms - t.server.render_ms - t.server.encode_ms), 0.5)),
    ms(part(moving.map((t) => t.shown - t.received), 0.5)),
    most(moving.map((t) => `${t.server.quality}, ${t.width}x${t.height}`)),
    ms(still.shown - rested), ms(still.server.render_ms), ms(still.server.encode_ms),
  ]);
  await page.context().close();
  await viewer.end();
}
await browser.close();

const head = ["volume", "stage", "pictures", "whole ms, median", "95 %", "queue", "render", "encode", "send", "decode and draw",
  "mostly", "rest to still, ms", "its render", "its encode"];
for (const cells of [head, head.map((_, i) => (i < 2 || i === 10 ? "---" : "---:")), ...rows]) console.log(`| ${cells.join(" | ")} |`);
