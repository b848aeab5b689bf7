// Compares libcvol as WebAssembly with the command: samples of every kind of file are equal, and pictures of the base
// instruction set differ by at most 1 of 255.
//
// usage: node test_instance.mjs WEB_FOLDER CVOL SAMPLE.nii.gz FOLDER

import assert from "node:assert/strict";
import { execFileSync, execSync } from "node:child_process";
import { mkdirSync, readFileSync, writeFileSync } from "node:fs";
import path from "node:path";

import { openInstances } from "./instance.mjs";
import { readPng } from "./png.mjs";

const [web, cvol, sample, folder] = process.argv.slice(2).map((name) => path.resolve(name));
mkdirSync(folder, { recursive: true });
const environment = { ...process.env, CVOL_CPU: "base", PATH: `${path.dirname(cvol)}:${process.env.PATH}` };
const quiet = { cwd: folder, stdio: ["ignore", "ignore", "inherit"], env: environment };
const run = (...words) => execFileSync(cvol, words, quiet);
const say = (sentence) => console.log(sentence);

// ---- files ----------------------------------------------------------------------------------------

run("compress", sample, "whole.cvol", "--fast");
run("decompress", "whole.cvol", "box.nrrd", "--box", "60:140,80:150,60:130");
const KINDS = {
  default: [],
  lossless: ["--lossless"],
  bounded: ["--max-error", "2"],
  smallest: ["--effort", "max"],
  blocks8: ["--block", "8"],
  background: ["--background", "0"],
};
for (const [name, options] of Object.entries(KINDS)) run("compress", "box.nrrd", `${name}.cvol`, ...options);

const names = ["whole", ...Object.keys(KINDS)];
const instances = await openInstances(web, ...names.map((name) => path.join(folder, `${name}.cvol`)));
const turned = { volume: "0", width: 200, height: 160, camera: { azimuth: 30, elevation: 20 } };
const pixelsBy = async (ask) => new Uint8Array((await ask("POST", "/frame", { view: turned })).bytes);
const coarse = await pixelsBy(instances.coarse);
const missing = (await instances.coarse("GET", "/volumes")).json().volumes.filter((v) => v.residual_missing);
assert.deepEqual(missing.map(({ name }) => name), ["lossless.cvol", "bounded.cvol"]);
const ask = await instances.copy();
const copied = await pixelsBy(ask);
assert.deepEqual(copied, await pixelsBy(instances.whole));
const apart = coarse.reduce((sum, value, i) => sum + Math.abs(value - copied[i]), 0) / coarse.length;
say(`a coarse level differs by ${apart.toFixed(2)} of 255 in the mean, the copy of an instance by nothing`);
assert.ok(apart > 0.05 && apart < 8);
const { volumes } = (await ask("GET", "/volumes")).json();
assert.deepEqual(volumes.map(({ state, error }) => [state, error]), names.map(() => ["ready", null]));

// ---- samples --------------------------------------------------------------------------------------

for (const { id, name, dims } of volumes) {
  run("decompress", name, "samples.raw");
  const raw = readFileSync(path.join(folder, "samples.raw"));
  const z = dims[2] >> 1;
  const slice = await ask("GET", `/volumes/${id}/slice?axis=z&index=${z}&window=0,255`);
  assert.deepEqual(slice.size, [dims[0], dims[1]]);
  const pixels = new Uint8Array(slice.bytes);
  const wanted = raw.subarray(z * dims[0] * dims[1], (z + 1) * dims[0] * dims[1]);
  const wrong = wanted.reduce((count, value, i) => count + (value !== pixels[4 * i]), 0);
  assert.equal(wrong, 0, `${name}: ${wrong} samples of slice ${z} differ`);
}
say(`samples of ${volumes.length} files are equal`);

// ---- regions --------------------------------------------------------------------------------------

for (const { id, name, rescale } of volumes) {
  const box = [10, 60, 20, 50, 30, 55];
  const words = ["measure", name, "--json", "--box", "10:60,20:50,30:55"];
  const native = JSON.parse(execFileSync(cvol, words, { cwd: folder, env: environment }));
  const answer = (await ask("POST", `/volumes/${id}/measure`, { kind: "box", box })).json();
  assert.equal(rescale, null);
  assert.equal(answer.samples, native.samples);
  assert.ok(Math.abs(answer.mean - native.mean) <= 1e-6 * native.mean, `${name}: the mean is ${answer.mean}, not ${native.mean}`);
  // The samples of a separate background are exact: statistics count that, the sums of cvol measure do not.
  const [least, most] = [name === "background.cvol" ? 0.9 : 1 - 1e-6, 1 + 1e-6].map((share) => share * native.mean_error);
  assert.ok(answer.mean_error >= least && answer.mean_error <= most, `${name}: the bound is ${answer.mean_error}, not ${native.mean_error}`);
}
say(`means of ${volumes.length} files are those of cvol measure`);

// ---- pictures -------------------------------------------------------------------------------------

const STUDIO = { on: true, direction: [-0.55, 0.65, 0.9], ambient: 0.3, diffuse: 0.6, specular: 0.1, shininess: 24 };
const MORE = { fill: 0.2, occlusion: 0.75, shadows: 0.6, in_view: true, keeps_brightness: true };
const box = [null, 150, null, null, null, null];
const VIEWS = {
  studio: { light: { ...STUDIO, ...MORE } },
  headlight: { light: { on: true } },
  flat: { light: { on: false } },
  mip: { mode: "mip" },
  minimum: { mode: "min" }, // rays leave the brain, so it is black
  xray: { mode: "xray" },
  surface: { mode: "iso", surface: { value: 70 } },
  clip: { clip: { box }, background: [1, 1, 1] },
  perspective: { camera: { azimuth: 200, elevation: 20, fov: 40 }, light: { ...STUDIO, ...MORE } },
  zoom: { camera: { azimuth: 33, elevation: 20, roll: 40, zoom: 3 } },
};

async function compare(volume, name, fields) {
  const view = { volume: volume.id, width: 200, height: 160, camera: { azimuth: 30, elevation: 20 }, ...fields };
  const { command, files } = (await ask("POST", "/command", { view })).json();
  for (const [file, content] of Object.entries(files ?? {}))
    writeFileSync(path.join(folder, file), JSON.stringify(content));
  const output = command.match(/ -o (\S+)/)[1];
  execSync(command, quiet);
  const native = readPng(readFileSync(path.join(folder, output)));
  const answer = await ask("POST", "/frame", { view });
  assert.equal(answer.status, 200);
  const pixels = new Uint8Array(answer.bytes);
  let [most, bright] = [0, 0];
  native.rgb.forEach((value, i) => {
    most = Math.max(most, Math.abs(value - pixels[4 * Math.floor(i / 3) + (i % 3)]));
    bright += value > 40;
  });
  assert.ok(bright > 1000 || name === "minimum", `${volume.name}, ${name}: the picture is empty`);
  assert.ok(most <= 1, `${volume.name}, ${name}: a pixel differs by ${most}`);
  return most;
}

for (const [name, fields] of Object.entries(VIEWS))
  say(`${name}: largest difference ${await compare(volumes[0], name, fields)}`);
for (const volume of volumes.slice(1))
  say(`${volume.name}: largest difference ${await compare(volume, "studio", VIEWS.studio)}`);

// ---- refusals -------------------------------------------------------------------------------------

const refused = await ask("POST", "/frame", { view: { volume: "0", mode: "none" } });
assert.equal(refused.status, 400);
assert.match(refused.json().error, /mode/);
writeFileSync(path.join(folder, "cut.cvol"), readFileSync(path.join(folder, "default.cvol")).subarray(0, 200));
writeFileSync(path.join(folder, "text.cvol"), "not a volume");
const broken = await openInstances(web, path.join(folder, "cut.cvol"), path.join(folder, "text.cvol"));
for (const { name, state, error } of (await broken.whole("GET", "/volumes")).json().volumes) {
  assert.equal(state, "failed");
  say(`refused: ${error}`);
  assert.match(error, new RegExp(name));
}
