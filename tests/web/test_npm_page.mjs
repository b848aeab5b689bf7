// The package of npm in a browser: as a module of a page it draws, on a canvas and in a worker, what it draws in Node.
//
// usage: test_npm_page.mjs FOLDER, that of test_npm.mjs, with CVOL_BROWSER_MODULES and CVOL_CHROMIUM as
// tests/viewer/test_browser.mjs

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import http from "node:http";
import { createRequire } from "node:module";
import path from "node:path";
import { pathToFileURL } from "node:url";

import { startBrowser } from "../viewer/browser.mjs";

const folder = path.resolve(process.argv[2]);
const TYPES = { ".mjs": "text/javascript", ".wasm": "application/wasm" };
const PAGE = "<!doctype html><meta charset=utf-8><title>cvol</title><canvas width=200 height=160></canvas>";
const WORKER = `
import { decode, render } from "/node_modules/cvol/index.mjs";
self.onmessage = async ({ data: bytes }) => {
  const { data } = await render(new OffscreenCanvas(200, 160), bytes);
  self.postMessage({ pixels: Array.from(data), shape: (await decode(bytes)).shape });
};`;
const server = http.createServer((request, response) => {
  const { pathname } = new URL(request.url, "http://x");
  if (pathname === "/") return response.writeHead(200, { "Content-Type": "text/html" }).end(PAGE);
  if (pathname === "/worker.mjs") return response.writeHead(200, { "Content-Type": TYPES[".mjs"] }).end(WORKER);
  if (pathname.includes("..")) return response.writeHead(404).end();
  try {
    const bytes = readFileSync(path.join(folder, pathname));
    response.writeHead(200, { "Content-Type": TYPES[path.extname(pathname)] ?? "application/octet-stream" }).end(bytes);
  } catch {
    response.writeHead(404).end();
  }
});
await new Promise((done) => server.listen(0, "127.0.0.1", done));

const { render } = await import(pathToFileURL(createRequire(path.join(folder, "x.js")).resolve("cvol")).href);
const wanted = Array.from((await render(null, readFileSync(path.join(folder, "whole.cvol")), { width: 200, height: 160 })).data);

const browser = await startBrowser();
const page = await browser.newPage();
const errors = [];
page.on("pageerror", (error) => errors.push(error.message));
await page.goto(`http://127.0.0.1:${server.address().port}/`);
const found = await page.evaluate(async () => {
  const { openRange, render } = await import("/node_modules/cvol/index.mjs");
  const canvas = document.querySelector("canvas");
  const loaded = await openRange("/whole.cvol");
  await render(canvas, loaded);
  const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  const worker = new Worker("/worker.mjs", { type: "module" });
  const answer = new Promise((done, failed) => ((worker.onmessage = ({ data }) => done(data)), (worker.onerror = failed)));
  worker.postMessage(loaded.bytes);
  return { pixels: Array.from(data), worker: await answer };
});
assert.deepEqual(errors, []);
assert.deepEqual(found.pixels, wanted);
assert.deepEqual(found.worker.pixels, wanted);
assert.equal(found.worker.shape.length, 3);
console.log("the package draws the same on a canvas, in a worker and in Node");
await browser.close();
server.close();
