// Opens damaged files in the WebAssembly, by the code of the page's workers: each must open or fail with a sentence, and
// draw if it opens, within seconds; the instance must not stop.
//
// usage: node test_damaged.mjs WEB_FOLDER FOLDER      FOLDER: what damaged_files.py has written

import assert from "node:assert/strict";
import { readdirSync, readFileSync } from "node:fs";
import path from "node:path";

import { startInstance } from "./instance.mjs";

const [web, folder] = process.argv.slice(2);
const LIMIT_MS = 5000; // of processor time
const names = readdirSync(folder).filter((name) => name.endsWith(".cvol")).sort();
const counts = { opened: 0, refused: 0 };
let [slowest, slowestName] = [0, ""];

// Opens the file at a level and draws it. Returns the sentence of the file's failure, or null.
async function tryLevel(name, level) {
  const ask = await startInstance(web, [path.join(folder, name)], level);
  const { volumes } = (await ask("GET", "/volumes")).json();
  for (const { id, state, error } of volumes) {
    if (state !== "ready") return error;
    for (const mode of ["composite", "mip"]) {
      const { status } = await ask("POST", "/frame", { view: { volume: id, width: 48, height: 40, mode } });
      assert.ok([200, 400, 413].includes(status), `${name}: frame gives ${status}`);
    }
    await ask("GET", `/volumes/${id}/histogram`);
    const { status } = await ask("GET", `/volumes/${id}/slice?axis=z&index=0`);
    assert.ok([200, 400, 413].includes(status), `${name}: slice gives ${status}`);
  }
  return null;
}

const msOf = ({ user, system }) => (user + system) / 1000;
for (const name of names) {
  const before = process.cpuUsage();
  let refused = null;
  for (const level of [2, 0]) {
    try {
      refused = await tryLevel(name, level);
    } catch (error) {
      if (error.stopped || error.code === "ERR_ASSERTION") throw new Error(`${name}, level ${level}: ${error.message}`);
      refused = error.message;
    }
    assert.ok(refused === null || /\w+ \w+/.test(refused), `${name}: the failure has no sentence: ${refused}`);
  }
  counts[refused === null ? "opened" : "refused"]++;
  const ms = msOf(process.cpuUsage(before));
  if (ms > slowest) [slowest, slowestName] = [ms, name];
  assert.ok(ms < 2 * LIMIT_MS, `${name}: ${ms.toFixed(0)} ms`);
}
assert.ok(counts.opened > 0 && counts.refused > 0);
console.log(`${names.length} damaged files: ${counts.refused} give a sentence, ${counts.opened} open; the slowest ` +
  `took ${slowest.toFixed(0)} ms for two levels (${slowestName})`);
