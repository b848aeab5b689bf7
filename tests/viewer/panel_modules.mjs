// Tests the panels' modules that need no browser: points of transfer functions, histograms, units, orientation.
//     node panel_modules.mjs

import assert from "node:assert/strict";

import * as overlays from "../../viewer/page/state/overlays.js";
import * as channels from "../../viewer/page/state/channels.js";
import { fittedWindow } from "../../viewer/page/slices/slice_window.js";
import { colourAt, colourMaps, hexOf, rgbOf } from "../../viewer/page/transfer/colour_maps.js";
import { createResolver } from "../../viewer/page/compare/concrete.js";
import { histogramPath, robustRange, ticks } from "../../viewer/page/transfer/histogram.js";
import { meaningOf, rounded, shortNumber } from "../../viewer/page/state/meaning.js";
import { lettersOf, planeName } from "../../viewer/page/slices/orientation.js";
import { hashOf, patchOf } from "../../viewer/page/state/link.js";
import { COMPARE, SLICES } from "../../viewer/page/state/panel_state.js";
import * as transfer from "../../viewer/page/transfer/transfer_points.js";
import { presetGroups } from "../../viewer/page/transfer/transfer_presets.js";
import { DEFAULT_VIEW } from "../../viewer/page/state/default_view.js";

const near = (a, b, slack = 1e-9) => assert.ok(Math.abs(a - b) <= slack, `${a} is not ${b}`);
const points = [
  [10, 0, 0, 0, 0],
  [20, 1, 0.5, 0, 0.1],
  [40, 1, 1, 1, 0.9],
];
const untouched = JSON.stringify(points);

// Functions are linear between points and constant outside.
assert.deepEqual(transfer.pointAt(points, 15), [15, 0.5, 0.25, 0, 0.05]);
assert.deepEqual(transfer.pointAt(points, -5), [-5, 0, 0, 0, 0]);
assert.deepEqual(transfer.pointAt(points, 99), [99, 1, 1, 1, 0.9]);

// Inserting a point on the function does not change it; points cannot pass each other.
{
  const { points: more, index } = transfer.insert(points, transfer.pointAt(points, 33));
  assert.equal(index, 2);
  for (let value = 0; value < 50; value += 0.7)
    transfer.pointAt(more, value).forEach((part, k) => near(part, transfer.pointAt(points, value)[k], 1e-12));
  assert.deepEqual(transfer.without(more, index), points);
  assert.equal(transfer.moved(points, 1, 500, 2)[1][0], 40);
  assert.equal(transfer.moved(points, 1, -500, 2)[1][0], 10);
  assert.equal(transfer.moved(points, 1, 30, 2)[1][4], 1);
}

// Overlays: their initial settings, those of a link, and labels.
{
  const described = { name: "a", opacity: 0.8, depth: 30 };
  const labels = [4, 9, 17].map((value) => ({ value, name: null, colour: [1, 0, 0] }));
  const volume = {
    overlays: [
      { ...described, labels: null, values: { transfer: "hot", window: [1, 5] } },
      { ...described, labels, values: null },
    ],
  };
  const first = overlays.overlaysOf(volume);
  assert.deepEqual(first, [
    { on: true, opacity: 0.8, depth: null, transfer: "hot", window: [1, 5] },
    { on: true, opacity: 0.8, depth: null, labels: null },
  ]);
  assert.equal(overlays.overlaysOf({ overlays: [] }), null);
  assert.equal(overlays.requestOverlays(DEFAULT_VIEW), undefined);
  assert.deepEqual(overlays.requestOverlays({ overlays: first }), [
    { on: true, opacity: 0.8, transfer: "hot", window: [1, 5] },
    { on: true, opacity: 0.8 },
  ]);
  assert.deepEqual(overlays.fittingOverlays([first[0]], volume), first, "of another number");
  const bad = [{ on: 1, opacity: 2, depth: "x", transfer: 3, window: [2, 1], labels: [4], more: 1 }, { labels: [9, 9, 5], transfer: "hot" }];
  assert.deepEqual(overlays.fittingOverlays(bad, volume), [first[0], { ...first[1], labels: [9] }]);
  const state = { ...DEFAULT_VIEW, overlays: overlays.fittingOverlays([{ window: null }, { labels: [4], depth: 7 }], volume) };
  assert.deepEqual(overlays.fittingOverlays(patchOf(hashOf({ view: state, page: {} })).view.overlays, volume), state.overlays);
  for (const window of [["a", "b"], [null, 2], [1, "2"], [-1e308, 1e308], [1, 2, 3]])
    assert.deepEqual(overlays.fittingOverlays([{ window }, {}], volume), first, "no window");
  assert.deepEqual(overlays.fittingOverlays([{ window: [2, 3] }, {}], volume)[0].window, [2, 3]);
  const names = overlays.overlayTransfers({ transfers: ["auto", "bone", "ct-bone"], ct_transfers: ["ct-bone"] });
  assert.deepEqual(
    ["rainbow", "ct-bone", "", "bone", "hot"].map((name) => overlays.fittingOverlays([{ transfer: name }, {}], volume, names)[0].transfer),
    ["hot", "hot", "hot", "bone", "hot"],
  );
  volume.overlays[0].values = { transfer: "hot", window: [1, 5], value_scale: 0.5, value_offset: -20 };
  const answers = [{ value: 30, label: null }, { value: 9, label: "Front" }];
  assert.deepEqual(overlays.overlayTexts(answers, { overlays: first }, volume), ["a \u22125", "Front"]);
  assert.deepEqual(overlays.overlayTexts(answers, { overlays: [first[0], { on: false }] }, volume), ["a \u22125"]);
  const hidden = { overlays: [{ ...first[0], opacity: 0 }, { ...first[1], labels: [4] }] };
  assert.deepEqual(overlays.overlayTexts(answers, hidden, volume), [], "not drawn");
  assert.deepEqual(overlays.overlayTexts(answers, { overlays: [first[0], { ...first[1], labels: [9] }] }, volume).length, 2);
  assert.deepEqual(overlays.overlayTexts([{ value: null }, null], { overlays: first }, volume), []);
  volume.overlays[1].name = "left.part.seg.nrrd";
  assert.deepEqual(overlays.overlayTexts([null, { value: 1234567, label: null }], { overlays: first }, volume), ["left.part 1234567"]);
  assert.deepEqual(overlays.overlayTexts([null, { value: 9, label: null }], { overlays: first }, volume), ["left.part 9"]);
  const all = [4, 9, 17];
  const one = overlays.labelChange({ labels: null }, all, 9, false);
  assert.deepEqual(one, { labels: [4, 17] });
  assert.deepEqual(overlays.labelChange(one, all, 9, true), { labels: null });
  assert.deepEqual(overlays.labelChange({ labels: [] }, all, 17, true), { labels: [17] });
  assert.ok(overlays.showsLabel(one, 4) && !overlays.showsLabel(one, 9));
}

// Window and level move all points and keep the proportions of their distances.
assert.deepEqual(
  transfer.stretched(points, 100, 160).map(([value]) => value),
  [100, 120, 160],
);
assert.deepEqual(transfer.extent(transfer.stretched([[5, 1, 1, 1, 1]], 3, 7)), [5, 5]);

// A colour map keeps the opacity at every value and has its own colours at its ends. Applying it twice adds no
// points.
for (const name of colourMaps) {
  const once = transfer.coloured(points, name);
  for (let value = 0; value < 50; value += 0.7)
    near(transfer.pointAt(once, value)[4], transfer.pointAt(points, value)[4], 1e-12);
  assert.deepEqual(once[0].slice(1, 4), colourAt(name, 0));
  assert.deepEqual(once.at(-1).slice(1, 4), colourAt(name, 1));
  assert.deepEqual(transfer.coloured(once, name), once);
  assert.deepEqual(rgbOf(hexOf(colourAt(name, 0))), colourAt(name, 0));
}

// Simplifying keeps few points and changes the function only slightly.
{
  const many = Array.from({ length: 33 }, (_, k) => [k, k / 32, k / 32, 0, k < 16 ? 0 : (k - 16) / 32]);
  const few = transfer.simplified(many);
  assert.ok(few.length < 14 && few.length >= 3, `${few.length} points`);
  for (const point of many) {
    const simplified = transfer.pointAt(few, point[0]);
    near(transfer.heightOf(simplified[4]), transfer.heightOf(point[4]), 0.021);
    [1, 2, 3].forEach((k) => near(simplified[k], point[k], 0.041));
  }
}
assert.equal(JSON.stringify(points), untouched, "points were changed in place");
near(transfer.opacityAt(transfer.heightOf(0.037)), 0.037);

// Integers with empty bins between them get one bar each; decoded samples keep their bins.
{
  const combed = { min: 0, max: 127, bins: new Array(256).fill(0) };
  for (let k = 0; k <= 127; k++) combed.bins[Math.min(255, Math.floor((k * 256) / 127))] += 5;
  const box = { width: 256, height: 100, low: 0, high: 127, logarithmic: true };
  const path = histogramPath(combed, box);
  assert.equal([...path.matchAll(/L/g)].length, 2 * 128 + 1);
  assert.equal([...path.matchAll(/ 100(?:\.00)?(?=[LZ])/g)].length, 2, "empty but where it begins and ends");
  const full = { min: 0, max: 127, bins: new Array(256).fill(3) };
  assert.equal([...histogramPath(full, box).matchAll(/L/g)].length, 2 * 256 + 1);
}
{
  const bins = new Array(256).fill(0);
  bins[0] = 1000;
  bins[100] = 900;
  bins[255] = 1;
  const [low, high] = robustRange({ min: 0, max: 256, bins }, 0.01, 0.01);
  assert.deepEqual([low, high], [0, 101]);
}
// The window of slices has the values of a small object in an empty volume.
{
  const bins = new Array(256).fill(0);
  bins[0] = 8e6;
  for (let i = 10; i < 200; i++) bins[i] = 5;
  assert.deepEqual(fittedWindow({ min: 0, max: 256, bins }), [0, 200]);
  bins.fill(1000);
  assert.deepEqual(fittedWindow({ min: 0, max: 256, bins }), [0, 256]);
  bins[0] = 1e6;
  bins.fill(1, 100);
  assert.equal(fittedWindow({ min: 0, max: 256, bins })[1], 98);
}
assert.deepEqual(ticks(0, 100, 5), [0, 20, 40, 60, 80, 100]);
assert.deepEqual(ticks(-1024, 3000, 4), [0, 2000]);

// Conversion between samples and physical values is invertible.
{
  const head = { type: "int16", min: 0, max: 4087, rescale: [1, -1024], value_scale: 1, value_offset: 0 };
  const meaning = meaningOf(head);
  assert.equal(meaning.text(1064), "40 HU");
  assert.equal(meaning.text(0), "\u22121024 HU");
  assert.equal(meaning.from(meaning.to(77)), 77);
  assert.equal(meaningOf({ type: "float32", min: 0, max: 1, rescale: null }).text(0.25), "0.25");
  assert.equal(shortNumber(1e-9), "1e\u22129");
}

// Numbers as text resolve a thousandth of the range, far from 0 too; integers have all digits.
{
  const text = (type, min, max, value, more = {}) => meaningOf({ type, min, max, ...more }).text(value);
  assert.equal(text("float64", 1e9, 1e9 + 1, 1e9 + 0.3), "1000000000.3");
  assert.equal(text("float32", 0, 0.9, 2.3e-13), "0");
  assert.equal(text("float32", 0, 1e-20, 9.6077e-21), "9.61e\u221221");
  assert.equal(text("float32", 0, 1e12, 9.6077e11), "9.6077e+11");
  assert.equal(text("float32", 0, 50000, 12345.4), "12345");
  assert.equal(text("float32", 1e-9, 1e-9, 1e-9), "1e\u22129", "one value");
  assert.equal(text("uint32", 0, 2 ** 32 - 1, 16777217), "16777217");
  assert.equal(text("int32", 0, 1234568, 1234567), "1234567");
  assert.equal(text("uint8", 0, 255, 91, { value_scale: 0.5, value_offset: 10 }), "55.5");
  const tiny = meaningOf({ type: "float32", min: 0, max: 1e-20 });
  assert.equal(rounded(9.6077e-21, tiny.digits + 1), 9.608e-21);
  assert.equal(rounded(123456, -3), 123000);
}

// Orientation letters: for LPS and RAS data, and none for unknown orientation.
{
  const views = (left, front) => ({
    left: { azimuth: left, elevation: 0, roll: 0 },
    front: { azimuth: front, elevation: 0, roll: 0 },
    top: { azimuth: 0, elevation: 90, roll: 0 },
  });
  const lps = lettersOf({ patient: true, views: views(90, 0) });
  assert.deepEqual(lps, [["R", "L"], ["A", "P"], ["I", "S"]]);
  const ras = lettersOf({ patient: true, views: views(-90, 180) });
  assert.deepEqual(ras, [["L", "R"], ["P", "A"], ["I", "S"]]);
  assert.deepEqual([0, 1, 2].map((axis) => planeName(lps, axis)), ["Sagittal", "Coronal", "Axial"]);
  assert.equal(lettersOf({ patient: false, views: views(90, 0) }), null);
  assert.equal(planeName(null, 1), "Y");
}

// Presets in Hounsfield units are offered only for volumes in Hounsfield units; each name occurs once.
{
  const about = { transfers: ["auto", "bone", "new-one"], ct_transfers: ["ct-bone"] };
  const names = (volume) => presetGroups(about, volume).flatMap(([, group]) => group).sort();
  assert.deepEqual(names({ rescale: null }), ["auto", "bone", "new-one"]);
  assert.deepEqual(names({ rescale: [1, 0] }), ["auto", "bone", "ct-bone", "new-one"]);
}

// The second volume is rendered like the first: automatic settings become explicit values.
{
  let asked = 0;
  const resolve = createResolver({ transfer: async () => (asked++, { points }) });
  const volume = { id: "0", min: -10, max: 30 };
  assert.deepEqual((await resolve(DEFAULT_VIEW, volume)).transfer, points);
  await resolve(DEFAULT_VIEW, volume);
  assert.equal(asked, 1);
  assert.deepEqual((await resolve({ ...DEFAULT_VIEW, mode: "mip" }, volume)).window, [-10, 30]);
  assert.equal((await resolve({ ...DEFAULT_VIEW, mode: "iso" }, volume)).surface.value, 10);
}

// Links carry the state of panels, and ignore invalid values.
{
  const page = {
    layout: "compare",
    sample: [1, 2.5, 3],
    compare: { ...COMPARE, mode: "difference", other: "3" },
    slices: { ...SLICES, windows: { 1: [-160, 240] } },
  };
  const back = patchOf(`#${hashOf({ view: DEFAULT_VIEW, page })}`).page;
  assert.deepEqual({ ...COMPARE, ...back.compare }, page.compare);
  assert.deepEqual(back.slices.windows, page.slices.windows);
  assert.deepEqual([back.layout, back.sample], [page.layout, page.sample]);
  for (const wrong of [
    ".page.layout='upside'",
    ".page.sample=[1,2]",
    ".page.compare=5",
    ".page.compare.mode='x'",
    ".page.compare.gain='8'",
    ".page.compare.constructor=1",
    ".page.slices.windows=[1]",
    ".page.slices.windows.1=[3,2]",
    ".page.slices.windows.1.2=[2,3]",
    ".page.other=1",
  ])
    assert.deepEqual(patchOf(`#${wrong}`), {}, wrong);
}

// Channels: the chosen one has its settings in the view.
{
  const all = ["DAPI", "GFP"].map((name, number) => ({
    id: `${number}`,
    parent: null,
    channel: { first: "0", number, count: 2, name, colour: [number, 1 - number, 0], component: false },
    home: { azimuth: 0, elevation: 0, roll: 0, look_at: [10 * number, 0, 0], size: [10, 4 + number] },
  }));
  const list = channels.channelsOf(all[0], all);
  assert.equal(channels.channelsOf({ parent: null, channel: null }, all), null);
  assert.deepEqual(list.map(({ volume, transfer }) => [volume, transfer]), [["0", "microscopy"], ["1", "microscopy"]]);
  const view = { volume: "0", mode: "composite", channels: list, transfer: "hot", opacity_scale: 2, window: null };
  const request = channels.requestChannels(view);
  assert.deepEqual(request.map((c) => [c.volume, c.transfer, c.opacity_scale, "on" in c, "window" in c]), [
    ["0", "hot", 2, false, false],
    ["1", "microscopy", 1, false, false],
  ]);
  const next = channels.chosenChannel(view, "1");
  assert.deepEqual([next.volume, next.transfer, next.opacity_scale], ["1", "microscopy", 1]);
  assert.equal(next.channels[0].transfer, "hot");
  assert.deepEqual(channels.requestChannels({ ...view, ...next }), request, "choosing a channel changes no picture");
  assert.equal(channels.requestChannels({ ...view, mode: "iso" }), null);
  assert.equal(channels.requestChannels({ ...view, channels: [{ ...list[0], on: false }, list[1]] }).length, 1);
  assert.deepEqual(channels.withJoinedHomes(all)[0].home, { ...all[0].home, look_at: [5, 0, 0], size: [20, 5] });
  assert.deepEqual(channels.tinted([[1, 0.2, 0.5, 0, 0.7]], { ...view, volume: "1" }), [[1, 0.5, 0, 0, 0.7]]);
  assert.ok(channels.areChannels(list) && channels.areChannels(null));
  const bad = [[], {}, [{}], [{ volume: 1, colour: [0, 0, 0] }], [{ volume: "1", colour: [2, 0, 0] }]];
  assert.ok(!bad.some(channels.areChannels));
  assert.equal(channels.sameChannels([list[0]], list), null);
  assert.equal(channels.sameChannels([{ ...list[0], on: false }, list[1]], list)[0].on, false);
}
