// Tests the page's modules that need no browser: camera, store, links, units.
//     node page_modules.mjs

import assert from "node:assert/strict";

import * as camera from "../../viewer/page/state/camera.js";
import { carryInLink, hashOf, patchOf } from "../../viewer/page/state/link.js";
import { reprojection } from "../../viewer/page/picture/reproject.js";
import { createStore, merge } from "../../viewer/page/state/store.js";
import { comparedTime, spokenTime, timeIn, timeOf, valueText } from "../../viewer/page/state/times.js";
import { bytesText, lengthText, ratioText, roundLength } from "../../viewer/page/state/units.js";
import { DEFAULT_VIEW } from "../../viewer/page/state/default_view.js";
import { requestView } from "../../viewer/page/state/view.js";

const volume = { dims: [301, 370, 316], spacing: [0.5, 0.5, 0.8] };
const [WIDTH, HEIGHT] = [900, 700];
const near = (a, b, slack = 1e-6) => assert.ok(Math.abs(a - b) <= slack, `${a} is not ${b}`);

let seed = 1;
function random(from, to) {
  seed = (seed * 48271) % 2147483647;
  return from + ((to - from) * seed) / 2147483647;
}
const anyCamera = (fov) => ({
  azimuth: random(-180, 180),
  elevation: random(-80, 80),
  roll: random(-180, 180),
  zoom: random(0.5, 4),
  fov,
  look_at: [random(-30, 30), random(-30, 30), random(-30, 30)],
});
const seen = (c, mirror) => camera.projector({ camera: c, mirror }, volume, WIDTH, HEIGHT);

// Front view: x to the right, z upwards. Half the distance doubles the size.
{
  const front = { ...DEFAULT_VIEW.camera };
  const pixel = camera.diagonal(volume) / HEIGHT;
  const at = seen(front, false)([10, 0, 20]);
  near(at.x, WIDTH / 2 + 10 / pixel);
  near(at.y, HEIGHT / 2 - 20 / pixel);
  near(seen(front, true)([10, 0, 20]).x, WIDTH / 2 - 10 / pixel);
  near(seen({ ...front, zoom: 2 }, false)([10, 0, 20]).x, WIDTH / 2 + 20 / pixel);
  assert.ok(seen(front, false)([0, -1, 0]).depth > 0, "the eye is at -y");
}

for (let round = 0; round < 200; round++) {
  const mirror = round % 2 === 1;
  const c = anyCamera(round % 3 ? 0 : 40);
  const place = [random(-40, 40), random(-40, 40), random(-40, 40)];
  const before = seen(c, mirror)(place);

  // sampleOf inverts worldOf.
  camera.sampleOf(volume, camera.worldOf(volume, place)).forEach((s, a) => near(s, place[a], 1e-9));

  // Panning moves a point at the depth of look_at with the pointer; in parallel projection every point.
  const held = c.fov ? c.look_at : place;
  const [from, to] = [seen(c, mirror)(held), seen(camera.panned(c, mirror, volume, 30, -20, HEIGHT), mirror)(held)];
  near(to.x - from.x, 30);
  near(to.y - from.y, -20);

  // Zooming keeps the point under the pointer.
  if (!c.fov) {
    const closer = camera.zoomed(c, mirror, volume, 1.7, before.x - WIDTH / 2, before.y - HEIGHT / 2, HEIGHT);
    const after = seen(closer, mirror)(place);
    near(after.x, before.x);
    near(after.y, before.y);
  }

  // A roll turns the picture clockwise about its centre, mirrored or not.
  const turned = seen(camera.rolled({ ...c, fov: 0 }, mirror, 25), mirror)(place);
  const plain = seen({ ...c, fov: 0 }, mirror)(place);
  const [dx, dy] = [plain.x - WIDTH / 2, plain.y - HEIGHT / 2];
  const [cosine, sine] = [Math.cos((25 * Math.PI) / 180), Math.sin((25 * Math.PI) / 180)];
  near(turned.x - WIDTH / 2, dx * cosine - dy * sine);
  near(turned.y - HEIGHT / 2, dx * sine + dy * cosine);

  // Orbiting moves the point nearest to the eye with the pointer.
  const small = { ...c, fov: 0, elevation: Math.max(-60, Math.min(60, c.elevation)) };
  const top = camera.sum([1, c.look_at], [60, camera.directions(small, mirror).eye]); // towards the eye
  const right = seen(camera.orbited(small, mirror, 2, 0, HEIGHT), mirror)(top);
  const down = seen(camera.orbited(small, mirror, 0, 2, HEIGHT), mirror)(top);
  const angle = (small.roll * Math.PI) / 180;
  // A horizontal drag turns about the volume's vertical axis only without roll.
  if (Math.abs(Math.cos(angle)) > 0.9 && Math.cos(angle) > 0) {
    assert.ok(right.x > WIDTH / 2, "to the right");
    assert.ok(down.y > HEIGHT / 2, "downwards");
  }

  // A reprojected picture after pan, roll and zoom equals the picture of the new camera.
  const later = {
    ...c,
    fov: 0,
    roll: c.roll + 15,
    zoom: c.zoom * 1.4,
    look_at: camera.sum([1, c.look_at], [1, [3, -4, 5]]),
  };
  const drawn = { volume: "0", mirror, camera: { ...c, fov: 0 } };
  const motion = reprojection(drawn, { ...drawn, camera: later }, volume, WIDTH, HEIGHT);
  const moved = seen(later, mirror)(place);
  const x = motion.scale * (dx * Math.cos(motion.angle) - dy * Math.sin(motion.angle)) + motion.x;
  const y = motion.scale * (dx * Math.sin(motion.angle) + dy * Math.cos(motion.angle)) + motion.y;
  near(x, moved.x - WIDTH / 2, 1e-5);
  near(y, moved.y - HEIGHT / 2, 1e-5);
  assert.equal(
    reprojection(drawn, { ...drawn, camera: { ...later, azimuth: c.azimuth + 1 } }, volume, WIDTH, HEIGHT),
    null,
  );
}

// The home camera shows the whole volume, and the volume nearly fills the picture.
for (const [width, height] of [
  [900, 700],
  [360, 600],
  [2000, 500],
]) {
  const home = camera.homeCamera({ ...volume, views: {} }, width, height);
  const project = camera.projector({ camera: home, mirror: false }, volume, width, height);
  let reach = 0;
  for (const corner of [0, 1, 2, 3, 4, 5, 6, 7]) {
    const at = project(
      camera.worldOf(
        volume,
        volume.dims.map((n, a) => ((corner >> a) & 1) * (n - 1)),
      ),
    );
    reach = Math.max(reach, Math.abs(at.x / width - 0.5) * 2, Math.abs(at.y / height - 0.5) * 2);
  }
  assert.ok(reach > 0.85 && reach < 0.95, `${width} x ${height}: ${reach}`);
}

// The store: a gesture is one undo step, live changes add none, and equal values keep their object.
{
  const store = createStore({ view: { a: 1, b: { c: [1, 2] } }, page: { open: 0 } });
  const first = store.state;
  assert.equal(merge(first, { view: { b: { c: [1, 2] } } }), first);
  let calls = 0;
  const end = store.subscribe((state, previous, { live }) => calls++ && assert.equal(typeof live, "boolean"));
  for (let a = 2; a < 9; a++) store.set({ view: { a } }, { live: true });
  assert.equal(store.canUndo, false);
  store.set({});
  assert.equal(store.canUndo, true);
  store.set({ page: { open: 1 } }, { undo: false });
  assert.ok(store.undo());
  assert.deepEqual(store.state, { view: { a: 1, b: { c: [1, 2] } }, page: { open: 1 } });
  assert.equal(store.undo(), false);
  assert.ok(store.redo());
  assert.equal(store.state.view.a, 8);
  assert.equal(store.state.view.b, first.view.b);
  store.set({ view: { a: 8 } });
  assert.ok(store.undo());
  assert.equal(store.state.view.a, 1, "a set that changes nothing is no step");
  store.rewrite((state) => merge(state, { view: { a: state.view.a * 10 } }));
  assert.ok(store.redo());
  assert.equal(store.state.view.a, 80);
  end();
  const before = calls;
  store.set({ view: { a: 0 } });
  assert.equal(calls, before);
}

// Links restore the state, contain only differences, and ignore unknown fields.
{
  const view = merge(DEFAULT_VIEW, {
    volume: "0",
    camera: { azimuth: 30.5, look_at: [1, 2, 3] },
    transfer: [
      [0, 0, 0, 0, 0],
      [1, 0.5, 0.25, 0.5, 0.5],
    ],
    window: [1, 2],
    surface: { value: 3 },
    clip: { box: [null, 3, null, null, null, null], planes: [[1, 0, 0, 4]] },
  });
  carryInLink("compare", null);
  const page = { layout: "slices", sample: [1, 2, 3.5], compare: { with: "it's 1 & 2" }, theme: "dark" };
  const patch = patchOf(`#${hashOf({ view, page })}`);
  assert.deepEqual(merge(DEFAULT_VIEW, patch.view), view);
  assert.deepEqual(patch.page, { layout: "slices", sample: [1, 2, 3.5], compare: { with: "it's 1 & 2" } });
  assert.equal(hashOf({ view: DEFAULT_VIEW, page: { layout: "single", sample: null, compare: null } }), "");
  const hostile =
    "#camera.zoom='x'&camera.azimuth=5&mode=7&foo=1&camera={}&camera.look_at=[1,2]&__proto__.x=1" +
    "&.page.__proto__.z=1&constructor.x=1&clip.planes=[[1,2]]&light.on=1&transfer=[1]&broken=%&=&&window=[1]";
  assert.deepEqual(patchOf(hostile), { view: { camera: { azimuth: 5 } } });
  assert.equal({}.x, undefined);
}

// Times: within the volume, and with the values of the file.
{
  const run = { times: 4, time_values: [0, 2.5, 5, 7.5], time_unit: "s" };
  assert.deepEqual([timeIn(run, 2), timeIn(run, 9), timeIn({ times: 1 }, 2), timeIn(undefined, 2)], [2, 3, 0, 0]);
  assert.deepEqual([timeOf(run, { times: 4 }, 3), timeOf({ times: 1 }, run, 3)], [3, 0]);
  const [same, other] = [{ id: "0", times: 4 }, { id: "1", times: 4 }];
  assert.equal(comparedTime({ time: 1 }, same, same, 3), 1, "of the same volume: the chosen time");
  assert.equal(comparedTime({ time: 1 }, same, other, 3), 3);
  assert.equal(valueText(run, 1), "2.5 s");
  assert.equal(valueText({ times: 4, time_values: [0, 1, 2, 3], time_unit: "" }, 2), "");
  assert.equal(valueText({ times: 4, time_values: null, time_unit: null }, 2), "");
  assert.equal(spokenTime(run, 3), "Time 3 of 0 to 3, 7.5 s");
  assert.deepEqual(patchOf("#time=2"), { view: { time: 2 } });
  assert.deepEqual(patchOf("#time=-1&time=1.5&time='x'"), {});
  assert.equal(hashOf({ view: merge(DEFAULT_VIEW, { time: 2 }), page: {} }), "time=2");
}

// Requests leave out null fields.
{
  const request = requestView(merge(DEFAULT_VIEW, { volume: "0" }), 10, 20);
  assert.deepEqual(
    [request.width, request.height, "clip" in request, "window" in request, "value" in request.surface],
    [10, 20, false, false, false],
  );
  const box = [null, 5, null, null, null, null];
  assert.deepEqual(requestView(merge(DEFAULT_VIEW, { clip: { box } }), 1, 1).clip, { box });
}

// Large still pictures: a draft with fewer pixels comes first. Each picture takes a millionth of a second for a pixel.
{
  globalThis.window = {};
  globalThis.createImageBitmap = async () => ({ close() {} });
  const { createFrames } = await import("../../viewer/page/picture/frames.js");
  let clock = 0;
  performance.now = () => clock;
  let size = { width: 4000, height: 3000 };
  const asked = [];
  const errors = [];
  let broken = false;
  const picture = async ({ quality, view }) => {
    asked.push([quality, view.width, view.height]);
    clock += (view.width * view.height) / 1000;
    if (broken) throw new Error("broken");
    return { blob: {}, info: {} };
  };
  const shown = [];
  const frames = createFrames({
    picture,
    request: () => ({ ...size, view: {}, build: (width, height) => ({ width, height }), motion: { fps: 15, size: 1 } }),
    show: (_, { timing }) => shown.push(timing.quality),
    fail: (error) => errors.push(error.message),
  });
  const drawn = async () => {
    while (frames.pending) await new Promise((resolve) => setTimeout(resolve));
    return [asked.splice(0), shown.splice(0)];
  };
  frames.still();
  const [[draft, whole], names] = await drawn();
  assert.deepEqual([whole, names], [["still", 4000, 3000], ["draft", "still"]]);
  near(draft[1] / draft[2], 4 / 3, 0.01);
  near(draft[1] * draft[2], 1e6, 2000); // a second
  size = { width: 1000, height: 1000 };
  frames.still();
  assert.deepEqual(await drawn(), [[["still", 1000, 1000]], ["still"]]);
  size = { width: 4000, height: 3000 };
  frames.still();
  frames.moved(); // motion comes before the rest of a draft
  assert.deepEqual((await drawn())[1].slice(-3), ["motion", "draft", "still"]);
  assert.deepEqual(errors, []);
  broken = true;
  frames.still();
  await drawn();
  assert.ok(errors.length > 0);
  broken = false;
  frames.still();
  frames.end();
  await new Promise((resolve) => setTimeout(resolve, 200));
  assert.equal(asked.filter(([quality]) => quality === "still").at(-1)[1] < 4000, true); // nothing follows the draft
}

assert.equal(bytesText(1171145), "1.17 MB");
assert.equal(bytesText(999), "999 bytes");
assert.equal(bytesText(999600), "1.00 MB");
assert.equal(bytesText(1), "1 byte");
assert.equal(ratioText(30.06), "1/30.1");
assert.equal(ratioText(1 / 93), "93 times");
assert.equal(lengthText(50, "mm"), "50 mm");
assert.equal(lengthText(0.02, "mm"), "20 µm");
assert.equal(lengthText(2000, "um"), "2 mm");
assert.equal(lengthText(20, ""), "20");
assert.equal(roundLength(0.07), 0.05);
assert.equal(roundLength(50), 50);
assert.equal(roundLength(199), 100);

console.log("page modules: all checks passed");
