// The picture of the volume: requests to the server, and gestures that move the camera.

import { api } from "../state/api.js";
import * as math from "../state/camera.js";
import { createFrames } from "./frames.js";
import { listenToGestures } from "../input/gestures.js";
import { drawMoved, isIdentity, reprojection } from "./reproject.js";
import { merge, store } from "../state/store.js";
import { requestView, same } from "../state/view.js";
import { volumes } from "../state/volumes.js";

const FLIGHT_MS = 260;
const LATE_MS = 50;

// canvas: the target. events: {shown(frame, whether it was only moved), busy(yes), failed(message or null, status),
// picked(answer), touched()}.
export function mountView3d(canvas, events) {
  const context = canvas.getContext("2d", { alpha: false });
  const size = { width: 1, height: 1, ratio: 1 };
  let frame = null; // the frame on the canvas
  let kept = null; // its pixels
  let moved = 0; // pending animation frame that moves them

  const ready = () => volumes.current()?.state === "ready";

  const frames = createFrames({
    picture: api.frame,
    request() {
      const { view, page } = store.state;
      if (!ready() || document.hidden || size.width < 2) return null;
      return {
        view,
        motion: page.motion,
        width: size.width * size.ratio,
        height: size.height * size.ratio,
        ratio: size.ratio,
        build: (width, height) => requestView(view, width, height),
      };
    },
    show(bitmap, shown) {
      // A canvas loses its content when its size changes: draw it again at once.
      if (canvas.width !== bitmap.width) canvas.width = bitmap.width;
      if (canvas.height !== bitmap.height) canvas.height = bitmap.height;
      context.drawImage(bitmap, 0, 0);
      kept?.close();
      kept = bitmap;
      frame = { ...shown, width: size.width, height: size.height };
      canvas.dataset.quality = shown.timing.quality;
      canvas.dataset.sequence = shown.timing.server.sequence;
      events.failed(null);
      events.shown(frame);
    },
    fail: (error) => events.failed(error.message, error.status),
    busy: events.busy,
  });

  // While a picture is late, move the last one with the hand.
  function follow() {
    moved = 0;
    const { view } = store.state;
    if (!frame || frame.view === view || performance.now() - frame.timing.shown < LATE_MS) return;
    const volume = volumes.get(frame.view.volume);
    const motion = volume?.state === "ready" && reprojection(frame.view, view, volume, frame.width, frame.height);
    if (!motion || isIdentity(motion)) return;
    const ground = `rgb(${frame.view.background.map((part) => Math.round(255 * part)).join(" ")})`;
    drawMoved(context, kept, motion, frame.width, frame.height, ground);
    frame.seen = { ...frame.view, camera: view.camera };
    events.shown(frame, true);
  }

  function measure() {
    const box = canvas.parentElement.getBoundingClientRect();
    const now = { width: Math.round(box.width), height: Math.round(box.height), ratio: devicePixelRatio || 1 };
    if (now.width === size.width && now.height === size.height && now.ratio === size.ratio) return;
    const before = { ...size };
    Object.assign(size, now);
    if (before.width > 1) refit(before);
    frames.moved();
  }

  // The volume keeps its share of the stage: zoom is relative to the height.
  function refit(before) {
    const volume = volumes.current();
    if (volume?.state !== "ready" || size.width < 2 || size.height < 2) return;
    const fit = ({ width, height }) => math.homeCamera(volume, width, height).zoom;
    const factor = fit(size) / fit(before);
    if (Math.abs(factor - 1) < 1e-6) return;
    store.rewrite((state) => {
      const camera = math.tidy({ ...state.view.camera, zoom: state.view.camera.zoom * factor });
      return merge(state, { view: { camera } });
    });
  }
  new ResizeObserver(measure).observe(canvas.parentElement);

  store.subscribe((state, previous, { live }) => {
    if (state.view === previous.view) {
      // The gesture has ended; its fast picture is already visible.
      if (!live && frame && frame.view === state.view && frame.timing.quality === "motion") frames.still();
      return;
    }
    frames.moved();
    if (live) moved ||= requestAnimationFrame(follow);
  });
  document.addEventListener("visibilitychange", () => document.hidden || frames.moved());

  // ---- gestures ---------------------------------------------------------------------------------------

  const current = () => store.state.view.camera;
  const move = (camera) => store.set({ view: { camera: math.tidy(camera) } }, { live: true });
  const mirror = () => store.state.view.mirror;

  async function placeAt(x, y) {
    const view = requestView(store.state.view, Math.max(1, size.width), Math.max(1, size.height));
    if (!ready() || (view.mode !== "composite" && view.mode !== "iso")) return null;
    try {
      return await api.pick(view, x / size.width, y / size.height);
    } catch (error) {
      events.failed(error.message, error.status);
      return null;
    }
  }

  const hand = {
    turn: (dx, dy) => ready() && move(math.orbited(current(), mirror(), dx, dy, size.height)),
    pan: (dx, dy) => ready() && move(math.panned(current(), mirror(), volumes.current(), dx, dy, size.height)),
    zoom(factor, x = size.width / 2, y = size.height / 2) {
      if (!ready()) return;
      const [dx, dy] = [x - size.width / 2, y - size.height / 2];
      move(math.zoomed(current(), mirror(), volumes.current(), factor, dx, dy, size.height));
    },
    roll: (degrees) => ready() && move(math.rolled(current(), mirror(), degrees)),
    finish: () => store.set({}),
    start: () => events.touched?.(),
    async tap(x = size.width / 2, y = size.height / 2) {
      const answer = await placeAt(x, y);
      if (!answer) return;
      events.picked(answer);
      store.set(
        { page: { sample: answer.hit ? answer.sample.map((s) => Number(s.toFixed(2))) : null } },
        { undo: false },
      );
    },
    // Centre the point that was hit; outside the volume: fit the whole volume.
    async doubleTap(x, y) {
      const answer = await placeAt(x, y);
      if (!ready()) return;
      if (!answer?.hit) return home();
      const look_at = math.worldOf(volumes.current(), answer.sample);
      fly(math.tidy({ ...current(), look_at }));
    },
  };
  listenToGestures(canvas, hand);

  // Moves to another camera in FLIGHT_MS, as one undo step; any other movement ends it.
  let flight = 0;
  function fly({ fov, ...to }) {
    const from = current();
    const start = performance.now();
    const mine = ++flight;
    if (matchMedia("(prefers-reduced-motion: reduce)").matches) return store.set({ view: { camera: to } });
    const turned = (key, part) => from[key] + math.wrapDegrees(to[key] - from[key]) * part;
    let last = from;
    const step = (now) => {
      if (mine !== flight || Object.keys(to).some((key) => !same(current()[key], last[key]))) return;
      const part = Math.min(1, Math.max(0, (now - start) / FLIGHT_MS));
      if (part === 1) return store.set({ view: { camera: to } });
      const eased = part * part * (3 - 2 * part);
      last = math.tidy({
        azimuth: turned("azimuth", eased),
        elevation: from.elevation + (to.elevation - from.elevation) * eased,
        roll: turned("roll", eased),
        zoom: from.zoom * (to.zoom / from.zoom) ** eased,
        look_at: math.sum([1 - eased, from.look_at], [eased, to.look_at]),
      });
      store.set({ view: { camera: last } }, { live: true });
      requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }

  function home() {
    const volume = volumes.current();
    if (volume?.state === "ready") fly(math.homeCamera(volume, size.width, size.height));
  }

  measure();
  return {
    size,
    hand,
    home,
    fly,
    // The frame on the canvas: {view, width, height (of the page's pixels), timing}, or null. `seen`: the view to
    // which it was moved.
    get frame() {
      return frame;
    },
    // True while pictures are on their way.
    get pending() {
      return frames.pending;
    },
    refresh: () => frames.moved(),
    viewer: frames.viewer,
  };
}
