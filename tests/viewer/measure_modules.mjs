// Tests the page's modules of measurements and bookmarks that need no browser.
//     node measure_modules.mjs

import assert from "node:assert/strict";

import * as kept from "../../viewer/page/state/bookmarks.js";
import * as measures from "../../viewer/page/state/measures.js";
import { handlesOf } from "../../viewer/page/measure/handles.js";
import { passes, sectionOf } from "../../viewer/page/measure/slice_geometry.js";
import { linesOf } from "../../viewer/page/measure/space_geometry.js";
import "../../viewer/page/state/panel_state.js";
import { hashOf, patchOf } from "../../viewer/page/state/link.js";
import { DEFAULT_VIEW } from "../../viewer/page/state/default_view.js";

const DIMS = [30, 26, 22];

// ---- measurements -------------------------------------------------------------------------------

// A box has the samples at its corners, in any order of the corners, and stays in the volume.
assert.deepEqual(measures.boxOf([[10.4, 3, 5], [2.6, 8.5, 5]], DIMS), [3, 11, 3, 10, 5, 6]);
assert.deepEqual(measures.boxOf([[-0.5, -0.5, -0.5], [29.5, 25.5, 21.5]], DIMS), [0, 30, 0, 26, 0, 22]);
assert.deepEqual(measures.makeMeasure("distance", "0", [[1.234, -3, 2], [40, 5, 6]], DIMS).points, [[1.23, -0.5, 2], [29.5, 5, 6]]);
assert.deepEqual(measures.middleOf({ box: [3, 11, 3, 10, 5, 6] }, DIMS), [7, 6, 5]);
assert.deepEqual(measures.requestOf({ kind: "box", of: "0", box: [0, 1, 0, 1, 0, 1] }, 3), { kind: "box", box: [0, 1, 0, 1, 0, 1], time: 3 });
assert.deepEqual(measures.requestOf({ kind: "distance", of: "0", points: [] }, 3), { kind: "distance", points: [] });

// Copies and channels share the measurements of their file.
const all = new Map([["1", { id: "1", channel: { first: "0" } }], ["2", { id: "2", parent: "1" }], ["3", { id: "3", channel: null }]]);
const get = (id) => all.get(id);
assert.deepEqual(["1", "2", "3"].map((id) => measures.rootOf(get(id), get)), ["0", "0", "3"]);

// A bookmark adds what is not there, under the id that its file has now.
{
  const [a, b] = [{ kind: "box", of: "1", box: [0, 1, 0, 1, 0, 1] }, { kind: "box", of: "1", box: [0, 2, 0, 1, 0, 1] }];
  assert.deepEqual(measures.joinedMeasures([a], [{ ...a, of: "0" }, { ...b, of: "0" }], "1"), [a, b]);
  assert.equal(measures.joinedMeasures([], Array(300).fill(a), "1").length, measures.MOST);
}

// Bounds are rounded up, figures to one digit more.
assert.equal(measures.figureText(93.21234, 0.1201), "93.212 ± 0.13");
assert.equal(measures.figureText(-93.21234, 12.01), "\u221293.2 ± 13");
assert.equal(measures.figureText(1000, 0), "1000 ± 0");
assert.equal(measures.figureText(0.5, null), "0.5");
assert.equal(measures.figureText(1e9 + 0.25, 0, 1), "1000000000.25 ± 0", "far from 0");
assert.equal(measures.figureText(0, 0, 1), "0 ± 0");
assert.equal(measures.figureText(null, null), "none");
for (let error = 1e-9; error < 1e9; error *= 1.37) {
  const shown = Number(measures.figureText(1, error).split("± ")[1]);
  assert.ok(shown >= error * (1 - 1e-8) && shown <= 1.1 * error, `${error} is shown as ${shown}`);
}
const inMm = { unit: "mm", unit_assumed: false };
assert.equal(measures.lengthText({ length: 25, ...inMm }), "25 mm");
assert.equal(measures.lengthText({ length: 25, unit: "mm", unit_assumed: true }), "25 mm (unit assumed)");
assert.equal(measures.lengthText({ length: 25.123456, unit: "", unit_assumed: false }), "25.123 (no unit in the file)");
assert.equal(measures.volumeText({ volume: 3200, ...inMm }), "3.2 ml, 3200 mm³");
assert.equal(measures.volumeText({ volume: 3200, unit: "um", unit_assumed: false }), "3200 µm³");

const answer = { kind: "box", samples: 8, volume: 16, mean: -3.5, mean_error: 0.25, value_unit: "HU", ...inMm };
assert.equal(measures.shortText(answer), "mean \u22123.5 ± 0.25 HU");
assert.equal(measures.shortText({ ...answer, mean: 964.51234, mean_error: 0, value_unit: "" }), "mean 964.5", "rounded: no bound");
assert.equal(measures.shortText({ ...answer, mean: null }), "");
const csv = measures.csvOf([{ number: 1, measure: { kind: "box", of: "0", box: [1, 3, 4, 6, 7, 9] }, answer }], 'a "b", c', 2);
const [head, line] = csv.trimEnd().split("\n");
assert.equal(line.slice(0, 36), '1,box,"a ""b"", c",2,1,4,7,2,5,8,,,,');
const cells = line.replace('"a ""b"", c"', "file").split(",");
assert.equal(cells.length, head.split(",").length);
assert.equal(cells[head.split(",").indexOf("mean")], "-3.5");

// ---- lines --------------------------------------------------------------------------------------

const plane = { axis: 2, across: 0, down: 1 };
const box = [4, 14, 6, 16, 3, 10];
assert.deepEqual(sectionOf({ kind: "box", box }, plane, 3), [[3.5, 13.5], [5.5, 15.5]]);
assert.equal(sectionOf({ kind: "box", box }, plane, 10), null);
assert.deepEqual(sectionOf({ kind: "ellipsoid", box }, plane, 6), [[3.5, 13.5], [5.5, 15.5]]); // in the middle
const [[lo, hi]] = sectionOf({ kind: "ellipsoid", box }, plane, 3); // 3 of 3.5 samples from the middle
assert.ok(Math.abs((hi - lo) / 10 - Math.sqrt(1 - (3 / 3.5) ** 2)) < 1e-12);
assert.equal(passes([0, 0, 4], [9, 9, 4.4], plane, 4), "in");
assert.equal(passes([0, 0, 2], [9, 9, 8], plane, 4), "through");
assert.equal(passes([0, 0, 2], [9, 9, 3], plane, 4), null);
assert.equal(linesOf({ kind: "box", box }).flat().length, 2 * 5 + 4 * 2);
assert.equal(linesOf({ kind: "ellipsoid", box }).length, 3);
assert.equal(linesOf({ kind: "ellipsoid", box: [4, 14, 6, 16, 3, 4] }).length, 1);
for (const [x, y, z] of linesOf({ kind: "ellipsoid", box }).flat())
  assert.ok(Math.abs(((x - 8.5) / 5) ** 2 + ((y - 10.5) / 5) ** 2 + ((z - 6) / 3.5) ** 2 - 1) < 1e-9);

// ---- handles ------------------------------------------------------------------------------------

const dims = [40, 40, 20];
const region = (kind) => ({ kind, of: "0", box });
assert.deepEqual(handlesOf(region("box"), plane, 3).map(({ kind }) => kind).sort(), ["corner", "corner", "corner", "corner", "middle", "side", "side", "side", "side"]);
assert.equal(handlesOf(region("ellipsoid"), plane, 6).length, 5);
assert.deepEqual(handlesOf(region("ellipsoid"), plane, 10), []);
// A handle that is moved stands where it was moved, in every slice of an ellipsoid; the opposite one stays, and so does
// what the slice does not show.
for (const kind of ["box", "ellipsoid"])
  for (let slice = 3; slice < 10; slice++)
    for (const [i, handle] of handlesOf(region(kind), plane, slice).entries()) {
      assert.deepEqual(handle.move(region(kind), handle.place, dims).box, box, `${kind} ${slice} ${handle.kind} ${i}`);
      const to = handle.place.map((part) => part + 3);
      const moved = handle.move(region(kind), to, dims);
      assert.deepEqual(moved.box.slice(4), box.slice(4));
      const now = handlesOf(moved, plane, slice)[i].place;
      const axes = handle.kind === "side" ? [i % 2 ? 0 : 1] : [0, 1];
      for (const a of [0, 1]) {
        const wanted = axes.includes(a) ? to[a] : now[a];
        assert.ok(Math.abs(now[a] - wanted) <= 0.5 + 1e-9, `${kind} ${slice} ${handle.kind} ${i}: ${now}, not ${to}`);
      }
      if (handle.kind === "middle") assert.deepEqual(moved.box, [7, 17, 9, 19, 3, 10]);
      else assert.equal(moved.box.filter((border, k) => border !== box[k]).length, axes.length);
    }
const [centre, left] = handlesOf(region("ellipsoid"), plane, 6);
assert.deepEqual(centre.move(region("ellipsoid"), [-50, 99, 6], dims).box, [0, 10, 30, 40, 3, 10], "it stays in the volume");
assert.deepEqual(left.move(region("ellipsoid"), [99, 0, 6], dims).box, [13, 14, 6, 16, 3, 10], "a sample is left");
assert.equal(handlesOf({ kind: "distance", of: "0", points: [[1, 2, 3], [4, 5, 9]] }, plane, 3).length, 1);

const placed = [];
const free = (x, y) => measures.freePlace(placed, [x, y], 10);
assert.deepEqual([free(10, 20), free(40, 25), free(400, 25)], [[10, 20], [40, 39], [400, 25]]);

// ---- links --------------------------------------------------------------------------------------

const list = [
  { kind: "distance", of: "0", points: [[1, 2.5, 3], [4, 5, 6]] },
  { kind: "angle", of: "0", points: [[1, 2, 3], [4, 5, 6], [7, 8, 9]] },
  { kind: "ellipsoid", of: "1", box: [1, 2, 3, 4, 5, 6] },
];
const link = "volume='0'&camera.azimuth=30&.page.layout='slices'";
const bookmarks = [["It's \"mine\" & 50 %", "a b.cvol 3x4x5", link], ["Zwölf", "a b.cvol 3x4x5", ""]];
const page = { measures: { list, shown: false }, bookmarks: { list: bookmarks } };
const back = patchOf(`#${hashOf({ view: DEFAULT_VIEW, page })}`).page;
assert.deepEqual(back, page);
for (const wrong of [[{ ...list[0], kind: "line" }], [{ ...list[0], points: [[1, 2]] }], [{ ...list[2], box: [1, 2, 3, 4, 5, 6.5] }], [null], 3, [{ ...list[0], of: 1 }]])
  assert.deepEqual(patchOf(hashOf({ view: DEFAULT_VIEW, page: { measures: { list: wrong, shown: true } } })), {}, JSON.stringify(wrong));
for (const wrong of [[["a", "b"]], [["", "b", "c"]], [["a", 1, "c"]], [["x".repeat(81), "b", "c"]], ["abc"], null])
  assert.deepEqual(patchOf(hashOf({ view: DEFAULT_VIEW, page: { bookmarks: { list: wrong } } })), {}, JSON.stringify(wrong));

// A link has the angles of a front view too: 0 is not what the first view of a volume has.
const front = { ...DEFAULT_VIEW, volume: "0" };
assert.deepEqual(patchOf(hashOf({ view: front, page: {} })).view.camera, DEFAULT_VIEW.camera);
assert.equal(patchOf(hashOf({ view: front, page: {} })).view.light.on, true);

// ---- bookmarks ----------------------------------------------------------------------------------

assert.equal(kept.fileOf({ name: "a b.cvol", dims: [3, 4, 5] }), "a b.cvol 3x4x5");
assert.equal(kept.nextName(bookmarks, "a b.cvol 3x4x5"), "View 1");
assert.equal(kept.nextName([["View 1", "f", ""]], "f"), "View 2");
assert.equal(kept.freeName([["Top", "f", ""], ["Top 2", "f", "x"]], "f", " Top "), "Top 3");
assert.equal(kept.freeName([["Top", "f", ""]], "g", "Top"), "Top");
const two = [["Top", "f", "a"], ["Side", "f", "b"]];
assert.deepEqual(kept.renamed(two, two[1], " Left "), [["Top", "f", "a"], ["Left", "f", "b"]]);
assert.deepEqual(kept.renamed(two, two[1], "Top")[1], ["Top 2", "f", "b"], "a name is there once");
for (const name of ["", "  ", "Side"]) assert.equal(kept.renamed(two, two[1], name), two);
assert.ok(kept.areBookmarks(kept.renamed(two, two[0], "x".repeat(200))));
const one = [["Top", "f", "a"]];
assert.equal(kept.joined(one, [["Other name", "f", "a"]]), one, "the same view is there");
assert.deepEqual(kept.joined(one, [["Top", "f", "b"]]), [["Top", "f", "a"], ["Top 2", "f", "b"]]);
assert.ok(kept.areBookmarks(kept.joined([], Array.from({ length: 300 }, (_, i) => [`n${i}`, "f", `${i}`]))));

// The storage keeps them by file; one that refuses costs nothing.
const stored = new Map();
globalThis.localStorage = {
  getItem: (key) => stored.get(key) ?? null,
  setItem: (key, text) => stored.set(key, text),
  removeItem: (key) => stored.delete(key),
};
kept.writeKept("a b.cvol 3x4x5", [...bookmarks, ...one]);
assert.deepEqual(kept.readKept("a b.cvol 3x4x5"), bookmarks);
assert.deepEqual(kept.readKept("f"), []);
stored.set("cvol bookmarks f", "not JSON");
assert.deepEqual(kept.readKept("f"), []);
kept.writeKept("a b.cvol 3x4x5", []);
assert.deepEqual([...stored.keys()], ["cvol bookmarks f"]);
globalThis.localStorage = null;
assert.deepEqual(kept.readKept("f"), []);
kept.writeKept("f", one);

console.log("measure modules: all checks passed");
