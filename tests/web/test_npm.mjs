// Packs the package of npm, installs it in an empty folder, and compares what it decodes and draws with the command.
//
// usage: node test_npm.mjs WEB_FOLDER CVOL SAMPLE.nii.gz FOLDER

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdirSync, readFileSync, rmSync, statSync, writeFileSync } from "node:fs";
import http from "node:http";
import { createRequire } from "node:module";
import path from "node:path";
import { pathToFileURL } from "node:url";

import { readPng } from "./png.mjs";

const [web, cvol, sample, folder] = process.argv.slice(2).map((name) => path.resolve(name));
rmSync(folder, { recursive: true, force: true });
mkdirSync(folder, { recursive: true });
const environment = { ...process.env, CVOL_CPU: "base" };
const quiet = { cwd: folder, stdio: ["ignore", "pipe", "inherit"], env: environment };
const run = (...words) => execFileSync(cvol, words, quiet);
const say = (sentence) => console.log(sentence);
const file = (name) => new Uint8Array(readFileSync(path.join(folder, name)));

// ---- the package ----------------------------------------------------------------------------------

const packed = execFileSync("npm", ["pack", "--silent", path.join(web, "npm")], { cwd: folder }).toString().trim();
writeFileSync(path.join(folder, "package.json"), '{ "private": true, "type": "module" }');
execFileSync("npm", ["install", "--silent", "--offline", "--no-audit", "--no-fund", `./${packed}`], { cwd: folder });
const installed = (name) => pathToFileURL(createRequire(path.join(folder, "x.js")).resolve(name)).href;
const { decode, openRange, render, CvolFile, Renderer } = await import(installed("cvol"));
const { CvolCodec } = await import(installed("cvol/zarrita"));
say(`the package has ${(statSync(path.join(folder, packed)).size / 1000).toFixed(0)} kB`);

// ---- samples --------------------------------------------------------------------------------------

run("compress", sample, "whole.cvol");
run("decompress", "whole.cvol", "box.nrrd", "--box", "60:141,80:150,60:131");
const KINDS = { default: [], lossless: ["--lossless"], bounded: ["--max-error", "2"], blocks8: ["--block", "8"] };
for (const [name, options] of Object.entries(KINDS)) run("compress", "box.nrrd", `${name}.cvol`, ...options);
const types = ["uint8", "int8", "uint16", "int16", "uint32", "int32", "float32", "float64"];
for (const type of types) {
  const bytes = 20 * 18 * 16 * (Number(type.match(/\d+$/)) / 8);
  writeFileSync(path.join(folder, `${type}.raw`), Buffer.from(Array.from({ length: bytes }, (_, i) => (i * i) % 61)));
  run("compress", `${type}.raw`, `${type}.cvol`, "--type", type, "--dims", "20x18x16", "--lossless");
}
for (const name of [...Object.keys(KINDS), ...types]) {
  run("decompress", `${name}.cvol`, "samples.raw");
  const { data, type, shape } = await decode(file(`${name}.cvol`));
  assert.equal(type, types.includes(name) ? name : "uint8");
  assert.deepEqual(shape, types.includes(name) ? [20, 18, 16] : [81, 70, 71]);
  assert.deepEqual(new Uint8Array(data.buffer), file("samples.raw"), `${name}: other samples`);
}
run("decompress", "default.cvol", "samples.raw", "--box", "3:20,5:6,7:30");
const part = await decode(file("default.cvol"), { box: [3, 5, 7, 20, 6, 30] });
assert.deepEqual(part.data, file("samples.raw"));
assert.deepEqual(part.shape, [17, 1, 23]);
const info = JSON.parse(run("info", "default.cvol", "--json"));
assert.ok(Math.abs(part.psnr - info.psnr_db) < 1e-6);
say(`samples of ${Object.keys(KINDS).length + types.length} files are equal`);

// The centres of samples stay where they are in the world.
const whole = await decode(file("whole.cvol"));
const coarse = await decode(file("whole.cvol"), { level: 2 });
assert.deepEqual(coarse.shape, whole.shape.map((n) => Math.ceil(n / 4)));
assert.deepEqual(coarse.spacing, whole.spacing.map((length) => 4 * length));
const [nx, ny] = whole.shape;
let [squares, most] = [0, 0];
coarse.data.forEach((value, i) => {
  const at = [i % coarse.shape[0], Math.floor(i / coarse.shape[0]) % coarse.shape[1], Math.floor(i / coarse.shape[0] / coarse.shape[1])];
  let [sum, count] = [0, 0];
  for (let k = 0; k < 64; k++) {
    const [x, y, z] = [at[0] * 4 + (k & 3), at[1] * 4 + ((k >> 2) & 3), at[2] * 4 + (k >> 4)];
    if (x < nx && y < ny && z < whole.shape[2]) [sum, count] = [sum + whole.data[x + nx * (y + ny * z)], count + 1];
  }
  squares += (value - sum / count) ** 2;
  most = Math.max(most, Math.abs(value - sum / count));
});
const apart = Math.sqrt(squares / coarse.data.length);
say(`level 2 differs from the means of the samples by ${apart.toFixed(2)} of 255 (rms), ${most.toFixed(0)} at most`);
assert.ok(apart < 3);

// ---- errors ---------------------------------------------------------------------------------------

const fails = async (promise, sentence) => {
  const error = await Promise.resolve(promise).then(() => assert.fail("must fail"), (error) => error);
  assert.match(error.message, sentence);
};
await fails(decode(new Uint8Array(40)), /not a \.cvol file|signature/);
await fails(decode(file("default.cvol").subarray(0, 5000)), /ends|truncated|cut/i);
const damaged = file("default.cvol");
damaged.fill(0, 6000, 6016);
await fails(decode(damaged), /damaged|checksum/);
await fails(decode(file("default.cvol"), { box: [0, 0, 0, 82, 1, 1] }), /box 0 \.\. 82 on axis x does not lie within 0 \.\. 81/);
await fails(decode(file("default.cvol"), { level: 4 }), /level/);
for (const box of [[0, 0, 0, 2 ** 32 + 2, 1, 1], [0, 0, 0, 1.5, 2, 2], [0.5, 0, 0, 2, 2, 2], [0, 0, 0, NaN, 2, 2]])
  await fails(decode(file("default.cvol"), { box }), /box\[\d\] is .*, must be an integer/);
await fails(decode(file("default.cvol"), { level: 2.5 }), /level is 2\.5/);
await fails(decode(file("default.cvol"), { time: 1 }), /time/);
await fails(render(null, damaged), /damaged|checksum/);
await fails(render(null, file("default.cvol"), { colour: 3 }), /colour/);
assert.equal((await decode(file("default.cvol"))).shape[0], 81); // after failures, too

// ---- pictures -------------------------------------------------------------------------------------

const LOOKS = [
  [{ mode: "mip" }, ["--mode", "mip"]],
  [{ mode: "xray" }, ["--mode", "xray"]],
  [{ light: { on: false }, transfer: "bone" }, ["--light", "flat", "--transfer", "bone"]],
];
const renderer = await Renderer.create(file("whole.cvol"));
const camera = { azimuth: 40, elevation: 15, roll: 0, zoom: 1.5, look_at: [0, 0, 0] };
for (const [view, words] of LOOKS) {
  const at = ["--azimuth", "40", "--elevation", "15", "--zoom", "1.5", "--fit", "box", "--size", "200x160"];
  run("render", "whole.cvol", "-o", "native.png", ...at, ...words);
  const native = readPng(readFileSync(path.join(folder, "native.png")));
  const { data, width, height } = renderer.draw({ width: 200, height: 160, camera, ...view });
  assert.deepEqual([width, height], [200, 160]);
  let worst = 0;
  native.rgb.forEach((value, i) => {
    worst = Math.max(worst, Math.abs(value - data[4 * Math.floor(i / 3) + (i % 3)]));
  });
  say(`a picture (${JSON.stringify(view)}) differs by at most ${worst} of 255`);
  assert.ok(worst <= 1);
}
const lit = renderer.draw({ width: 120, height: 100 });
assert.deepEqual((await render(null, file("whole.cvol"), { width: 120, height: 100 })).data, lit.data);
assert.ok(lit.data.some((value, i) => i % 4 < 3 && value > 150), "the default picture must show the head");
renderer.close();
assert.throws(() => renderer.draw(), /closed/);

// ---- servers --------------------------------------------------------------------------------------

// kind: what the server does wrong.
const serve = (bytes, kind = "") =>
  new Promise((done) => {
    const log = { requests: 0, sent: 0, authorization: null };
    const server = http.createServer((request, response) => {
      log.requests++;
      log.authorization = request.headers.authorization ?? null;
      const range = kind === "no ranges" ? null : /^bytes=(\d+)-$/.exec(request.headers.range ?? "");
      const from = range ? Number(range[1]) : 0;
      const tag = `"${kind === "changes" ? log.requests : 1}"`;
      const headers = { ETag: tag, "Content-Length": bytes.length - from };
      if (range) headers["Content-Range"] = `bytes ${from}-${bytes.length - 1}/${bytes.length}`;
      if (request.url.includes("missing")) return response.writeHead(404).end();
      response.writeHead(range ? 206 : 200, headers);
      const piece = (at) => {
        if (response.destroyed) return;
        if (["cuts", "changes"].includes(kind) && log.requests === 1 && at > bytes.length / 3) return response.destroy();
        const next = bytes.subarray(at, at + 8192);
        log.sent += next.length;
        response.write(next);
        if (at + 8192 >= bytes.length) response.end();
        else setTimeout(piece, 2, at + 8192);
      };
      piece(from);
    });
    server.listen(0, "127.0.0.1", () => done({ url: `http://127.0.0.1:${server.address().port}/big.cvol`, log, close: () => server.close() }));
  });

const bytes = file("whole.cvol");
for (const kind of ["", "no ranges", "cuts"]) {
  const server = await serve(bytes, kind);
  const loaded = await openRange(server.url, { headers: { Authorization: "Bearer x" } });
  assert.deepEqual(loaded.bytes, bytes, `a server: ${kind}`);
  assert.equal(server.log.authorization, "Bearer x");
  const beginning = await openRange(server.url, { level: 2 });
  assert.deepEqual((await beginning.decode()).data, coarse.data);
  assert.ok(beginning.bytes.length < bytes.length / 2, `${beginning.bytes.length} of ${bytes.length} bytes`);
  if (!kind) say(`level 2 takes ${beginning.bytes.length} of ${bytes.length} bytes`);
  server.close();
}
// A file that is there at once, and a lossless one, whose levels lack the residual.
const small = await serve(file("default.cvol"));
assert.deepEqual((await (await openRange(small.url, { level: 2 })).decode()).shape, [21, 18, 18]);
await fails(openRange(small.url, { level: 4 }), /level is 4, must be 0 to 3/);
await fails(openRange(small.url, { onProgress: () => assert.fail("stop") }), /stop/);
assert.ok(small.log.requests <= 2);
small.close();
const exact = await serve(file("lossless.cvol"));
assert.deepEqual((await (await openRange(exact.url, { level: 1 })).decode()).shape, [41, 35, 36]);
exact.close();
await fails(openRange("big.cvol"), /big\.cvol: is no address/);
const changing = await serve(bytes, "changes");
await fails(openRange(changing.url), /big\.cvol: the file has changed/);
changing.close();
const server = await serve(bytes);
await fails(openRange(server.url.replace("big", "missing")), /missing\.cvol: the server answers 404/);
await fails(openRange(server.url, { limit: 1000 }), /the limit is 1000/);
await fails(openRange(server.url, { signal: AbortSignal.abort(new Error("stopped")) }), /stopped/);
server.close();
await fails(openRange(server.url), /big\.cvol: the server does not answer/);
const page = await serve(new Uint8Array(Buffer.from("<html>no volume here</html>")));
await fails(openRange(page.url), /is not a \.cvol file/);
page.close();
say("ranges: equal files, levels, and sentences");

// ---- Zarr -----------------------------------------------------------------------------------------

const python = `
import sys, numpy as np
sys.path.insert(0, sys.argv[1])
from cvol.codecs import Cvol
rng = np.random.default_rng(5)
chunks = {"plain": rng.integers(0, 200, (5, 6, 7)).astype("u1"), "four": rng.normal(0, 1, (2, 4, 5, 6)).astype("f4"),
          "two": rng.integers(-9, 9, (8, 9)).astype("i2"), "wide": rng.integers(-5, 5, (3, 4, 5)).astype("i8")}
for name, chunk in chunks.items():
    open(name + ".chunk", "wb").write(Cvol(lossless=True).encode(chunk))
    open(name + ".raw", "wb").write(chunk.tobytes())
`;
const library = path.join(path.dirname(cvol), "libcvol.so.0");
const source = path.join(path.dirname(new URL(import.meta.url).pathname), "..", "..", "python");
const has = (words) => {
  try {
    execFileSync("/usr/bin/python3", words, { stdio: "ignore" });
    return true;
  } catch {
    return false;
  }
};
if (has(["-c", "import numcodecs, numpy"])) {
  const words = ["-B", "-c", python, source];
  execFileSync("/usr/bin/python3", words, { cwd: folder, env: { ...environment, CVOL_LIBRARY: library } });
  for (const [name, shape] of [["plain", [5, 6, 7]], ["four", [2, 4, 5, 6]], ["two", [8, 9]], ["wide", [3, 4, 5]]]) {
    const chunk = await CvolCodec.fromConfig({ lossless: true }, { shape }).decode(file(`${name}.chunk`));
    assert.deepEqual(new Uint8Array(chunk.data.buffer), file(`${name}.raw`), name);
    assert.deepEqual(chunk.shape, shape);
    assert.equal(chunk.stride.at(-1), 1);
  }
  const broken = file("four.chunk");
  broken[20] ^= 1;
  await fails(new CvolCodec({}, { shape: [2, 4, 5, 6] }).decode(broken), /damaged header/);
  await fails(new CvolCodec({}, { shape: [5, 6, 8] }).decode(file("plain.chunk")), /volumes of 7,6,5 samples \(x, y, z\), not 8,6,5/);
  say("chunks of Zarr are equal");
} else {
  say("skipped: there is no numcodecs for chunks of Zarr");
}
assert.equal(new CvolFile(bytes).level, 0);
