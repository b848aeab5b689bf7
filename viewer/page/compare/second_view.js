// The second picture: another volume, or the difference, with the camera of the first.

import { api } from "../state/api.js";
import { createResolver } from "./concrete.js";
import { createFrames } from "../picture/frames.js";
import { listenToGestures } from "../input/gestures.js";
import { element } from "../controls/panel_kit.js";
import { store } from "../state/store.js";
import { comparedTime } from "../state/times.js";
import { requestView } from "../state/view.js";
import { volumes } from "../state/volumes.js";

/** 1 if values are comparable in both volumes: copies of one volume, or nearly the same range. */
function sameValues(a, b) {
  const span = Math.max(a.max - a.min, b.max - b.min);
  const near = Math.abs(a.min - b.min) + Math.abs(a.max - b.max) < 0.2 * span;
  return near || a.parent === b.id || b.parent === a.id || (a.parent !== null && a.parent === b.parent);
}

/** `hand`: the gestures of the first view. shown(info) and failed(message or null) are called after each picture. */
export function createSecondView(box, { hand, shown, failed }) {
  const canvas = element("canvas", {
    class: "second-canvas",
    width: 1,
    height: 1,
    tabindex: hand ? 0 : null,
    role: hand ? "application" : "img",
    "aria-label": "Second 3-D view. Arrow keys turn both.",
  });
  box.append(canvas);
  const context = canvas.getContext("2d", { alpha: false });
  const resolve = createResolver(api);
  const comparison = () => store.state.page.compare;
  let view = null; // the view to draw: that of the first picture, resolved
  let resolving = 0;

  function ready() {
    const other = volumes.get(comparison().other);
    return store.state.page.layout === "compare" && other?.state === "ready" && volumes.current()?.state === "ready";
  }

  const timeOf = (other) => comparedTime(comparison(), volumes.current(), volumes.get(other), view.time);
  const viewOf = (other) => ({ ...view, volume: other, time: timeOf(other), channels: null });

  const frames = createFrames({
    picture: (request, options) =>
      comparison().mode === "difference" ? api.difference(request, options) : api.frame(request, options),
    request() {
      if (!ready() || !view || document.hidden || box.clientWidth < 2) return null;
      const { mode, other, gain } = comparison();
      const ratio = devicePixelRatio || 1;
      return {
        view,
        motion: store.state.page.motion,
        width: box.clientWidth * ratio,
        height: box.clientHeight * ratio,
        build: (width, height) => requestView(mode === "difference" ? { ...view, channels: null } : viewOf(other), width, height),
        more: mode === "difference" ? { other, gain, other_time: timeOf(other) } : {},
      };
    },
    show(bitmap, frame) {
      if (canvas.width !== bitmap.width) canvas.width = bitmap.width;
      if (canvas.height !== bitmap.height) canvas.height = bitmap.height;
      context.drawImage(bitmap, 0, 0);
      bitmap.close();
      canvas.dataset.quality = frame.timing.quality;
      failed(null);
      shown(frame.timing);
    },
    fail: (error) => failed(error.message),
  });

  async function refresh() {
    if (!ready()) return;
    const mine = ++resolving;
    const now = store.state.view;
    const alike = comparison().mode === "difference" || sameValues(volumes.current(), volumes.get(comparison().other));
    const resolved = alike ? await resolve(now, volumes.current()) : now;
    if (mine !== resolving) return;
    view = resolved;
    frames.moved();
  }

  new ResizeObserver(refresh).observe(box);
  store.subscribe((state, previous) => {
    if (
      state.view !== previous.view ||
      state.page.compare !== previous.page.compare ||
      state.page.layout !== previous.page.layout
    )
      refresh();
  });
  volumes.subscribe(refresh);
  if (hand) listenToGestures(canvas, hand);
  return { canvas, refresh, viewer: frames.viewer };
}
