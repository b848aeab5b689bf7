// The volumes of a page of cvol export --site: files that are dropped or chosen, and the one that ?url= names, which is
// shown level by level; of a large one only what the view needs is loaded. Files of other formats are compressed by a
// worker, and can be saved as .cvol. Several files can be one volume (dropped.js); of several DICOM series one is chosen.

import { make } from "../../viewer/page/controls/controls.js";
import { bytesText } from "../../viewer/page/state/units.js";
import { arrive, isCvol } from "./arrival.js";
import { filesOf, volumesOf } from "./dropped.js";
import { branchOff } from "./ranged.js";
import { unpackCode, unpackModule } from "./unpack.js";

const COARSEST = 3; // level
const BYTES_MAX = 1e9;
const FORMATS =
  ".cvol, .nii, .nii.gz, .nrrd, .nhdr, .mha, .mhd, .tif, .npy, .mrc, .mgz, .mgh, .vtk, .vti, .vdb, .mat, and DICOM";

export const START = "";
export const TITLE = "";

const all = { files: [], volumes: [] };
let first = null; // resolves firstVolumes()
const begun = new Promise((resolve) => (first = resolve));
const listeners = new Set();

export const firstVolumes = () => begun;
export const onVolumes = (fn) => listeners.add(fn);

// ---- elements -----------------------------------------------------------------------------------

const sentence = make("p", { class: "sentence", role: "alert" });
const doing = make("p", { class: "quiet" });
const bar = make("progress", { max: 1, hidden: true, "aria-label": "Compressing" });
const input = make("input", {
  type: "file",
  multiple: true,
  "aria-label": "A volume",
  hidden: true,
  onchange() {
    const files = [...input.files].map((file) => ({ name: file.name, file }));
    input.value = ""; // the same files can be chosen again
    open(async () => files);
  },
});
const choose = make("button", { type: "button", class: "button", onclick: () => input.click() }, "Choose files");
const close = make("button", { type: "button", class: "button", hidden: true, onclick: () => show(false) }, "Close");
const choices = make("p", { class: "choices", role: "group", "aria-label": "Series" });
const box = make(
  "section",
  { id: "opening", "aria-label": "Open a volume" },
  make("h2", {}, "Drop a volume here"),
  make("p", {}, "Nothing is uploaded: this page reads, compresses and draws the file itself."),
  make("p", { class: "quiet" }, FORMATS),
  make("p", { class: "quiet" }, "Drop the files of a DICOM series together, or their folder, and a header with its data."),
  make("p", { class: "buttons" }, choose, close, input),
  bar,
  doing,
  choices,
  sentence,
);
const saving = make("p", { id: "saving", hidden: true });
const arriving = make("p", { id: "arriving", role: "status", hidden: true });
let begins = false; // the file of ?url= is shown, and still arrives
const again = make("button", { type: "button", class: "button", id: "open-file", onclick: () => show(true) }, "Open");
document.getElementById("stage").append(box, saving, arriving);
document.querySelector("#bar .tools").prepend(again);
document.getElementById("panel-sections").inert = true;

function show(yes) {
  box.hidden = !yes;
  close.hidden = !all.files.length;
  if (yes) choose.focus();
}

function say(text = "") {
  sentence.textContent = text;
  if (text) show(true);
}

function work(text, fraction) {
  doing.textContent = text;
  bar.hidden = !text;
  choose.disabled = Boolean(text);
  if (fraction >= 0) bar.value = fraction;
  else bar.removeAttribute("value");
}

function offer(name, before, bytes) {
  const href = URL.createObjectURL(new Blob([bytes], { type: "application/octet-stream" }));
  const save = make("a", { class: "button", href, download: name }, `Save ${name}`);
  const size = `Compressed from ${bytesText(before)} to ${bytesText(bytes.byteLength)} `;
  const hide = make("button", { type: "button", class: "button", onclick: () => (saving.hidden = true) }, "Hide");
  saving.replaceChildren(make("span", {}, size), save, hide);
  saving.hidden = false;
}

// ---- files --------------------------------------------------------------------------------------

// Loads convert.js, which the page needs only for files of other formats.
const loadScript = (name) =>
  new Promise((resolve, reject) => {
    const failed = () => reject(new Error(`${name}: cannot be loaded: copy it next to this page`));
    const script = make("script", { src: name, onload: resolve, onerror: failed });
    document.head.append(script);
  });

// Lets the user choose a DICOM series: resolves with its key, or with null.
function chooseSeries(name, series) {
  work(`${name} has ${series.length} series. Choose one.`);
  bar.hidden = true;
  return new Promise((resolve) => {
    const end = (key) => {
      choices.replaceChildren();
      resolve(key);
    };
    const button = (text, key) => make("button", { type: "button", class: "button", onclick: () => end(key) }, text);
    const sorted = [...series].sort((a, b) => b.slices - a.slices);
    choices.replaceChildren(
      ...sorted.map(({ key, description, slices }) =>
        button(`${description || "Series"} (${key}), ${slices} ${slices === 1 ? "slice" : "slices"}`, key)),
      button("Cancel", null),
    );
    choices.firstChild.focus();
  });
}

// name: of the file, or of the folder of all files. Resolves with bytes, or with null: the user chose no series.
async function convert(name, files) {
  if (!globalThis.cvolConverter) await loadScript("convert.js");
  const [code, wasm] = globalThis.cvolConverter;
  const [source, module] = await Promise.all([unpackCode(code), unpackModule(wasm)]);
  const worker = new Worker(source);
  const result = await new Promise((resolve) => {
    const answer = (key) => (key === null ? resolve({ bytes: null }) : worker.postMessage({ key }));
    worker.onmessage = ({ data }) => {
      if (data.series) chooseSeries(name, data.series).then(answer);
      else if (data.doing !== undefined) work(`${data.doing} ${name}`, data.fraction);
      else resolve(data);
    };
    worker.onerror = (event) => resolve({ failure: `${name}: ${event.message || "a worker does not start"}` });
    worker.postMessage({ module, name, files }, files.map(({ bytes }) => bytes));
  });
  worker.terminate();
  URL.revokeObjectURL(source);
  if (result.failure) throw new Error(result.failure);
  return result.bytes;
}

const plain = (name) => name.replace(/(\.nii|\.nrrd)?\.gz$|\.[^.]*$/i, "");

// arrival: of a file that is still arriving (arrival.js).
function add(name, bytes, arrival) {
  const file = { name: all.files.length ? `${all.files.length + 1}-${name}` : name, bytes, arrival };
  all.files.push(file);
  all.volumes.push({ file: file.name, name, time: -1, channel: -1 });
  show(false);
  if (all.files.length === 1) first(all);
  else for (const listener of listeners) listener(all);
  return file;
}

// Compresses a file, or a folder of files.
async function compress(name, files) {
  const before = files.reduce((sum, { bytes }) => sum + bytes.byteLength, 0);
  work(`reading ${name}`);
  const made = await convert(name, files);
  if (!made) return;
  offer(`${plain(name)}.cvol`, before, made);
  add(`${plain(name)}.cvol`, made);
}

async function take(name, bytes) {
  if (!bytes.byteLength) throw new Error(`${name}: is empty`);
  if (isCvol(new Uint8Array(bytes))) add(name, bytes);
  else await compress(name, [{ name, bytes }]);
}

function refuseLarge(name, bytes) {
  if (bytes > BYTES_MAX)
    throw new Error(`${name}: has ${bytesText(bytes)}, a page opens at most ${bytesText(BYTES_MAX)}: use cvol compress`);
}

async function attempt(fn) {
  if (choose.disabled) return;
  say();
  work("reading");
  try {
    await fn();
  } catch (error) {
    say(error.message);
  }
  work("");
}

const open = (listFiles) =>
  attempt(async () => {
    for (const { name, files } of await volumesOf(await listFiles())) {
      refuseLarge(name, files.reduce((sum, { file }) => sum + file.size, 0));
      const read = await Promise.all(files.map(async (one) => ({ name: one.name, bytes: await one.file.arrayBuffer() })));
      if (read.length > 1) await compress(name, read);
      else await take(name, read[0].bytes);
    }
  });

// ---- ?url= --------------------------------------------------------------------------------------

// Says how much of the file is there: below the picture, or in the box before there is one.
function report(name, bytes, total) {
  if (!begins) work(`loading ${name}`, total ? bytes / total : -1);
  arriving.textContent = `Loading ${name}: ${bytesText(bytes)}${total ? ` of ${bytesText(total)}` : ""}`;
  arriving.hidden = !begins;
}

// Says how much of a file is there of which only what the view needs is loaded.
function reportPart(name, bytes, total, more) {
  if (more) return report(name, bytes, total);
  const all = make("button", { type: "button", class: "button", onclick: () => loadAll() }, "Load all");
  arriving.replaceChildren(`${bytesText(bytes)} of ${bytesText(total)} loaded, as this view needs `, all);
  arriving.hidden = !begins || bytes === total;
}
let loadAll = () => {};

// Shows a .cvol file as soon as its coarsest level is there; the rest follows.
async function load(address, name) {
  const refuse = (bytes) => refuseLarge(name, bytes);
  const arrival = arrive(address, name, {
    progress: (bytes, total) => report(name, bytes, total),
    refuse,
    branch: (file) => branchOff(file, (bytes, total, more) => reportPart(name, bytes, total, more)),
  });
  arrival.branched.then((ranged) => (loadAll = () => ranged?.wantAll()), () => {});
  const begun = isCvol(await arrival.head) ? await arrival.level(COARSEST) : null;
  if (!begun) return take(name, await arrival.whole);
  begins = true;
  const file = add(name, begun, arrival);
  const end = (bytes) => {
    Object.assign(file, { bytes, arrival: undefined });
    arriving.hidden = true;
  };
  arrival.whole.then(end, (error) => {
    end(arrival.sofar());
    say(error.message);
  });
}

const wanted = new URLSearchParams(location.search).get("url");
if (wanted) {
  attempt(async () => {
    const address = new URL(wanted, location.href);
    const name = decodeURIComponent(address.pathname.split("/").pop()) || "volume.cvol";
    work(`loading ${name}`);
    await load(address, name);
  });
}

// ---- dropping -----------------------------------------------------------------------------------

addEventListener("dragover", (event) => event.preventDefault());
addEventListener("drop", (event) => {
  event.preventDefault();
  const entries = [...event.dataTransfer.items].map((item) => item.webkitGetAsEntry?.() ?? item.getAsFile()).filter(Boolean);
  open(() => filesOf(entries));
});
