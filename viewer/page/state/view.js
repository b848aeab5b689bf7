// The form of a view (doc/viewer-api.md) in requests.

import { requestChannels } from "./channels.js";
import { requestOverlays } from "./overlays.js";

// The view for a request, without null and empty fields.
export function requestView(view, width, height) {
  const out = { ...view };
  if (width) out.width = width;
  if (height) out.height = height;
  const channels = requestChannels(view);
  if (channels) out.channels = channels;
  else delete out.channels;
  const overlays = requestOverlays(view);
  if (overlays) out.overlays = overlays;
  else delete out.overlays;
  if (out.window === null) delete out.window;
  if (out.surface.value === null) out.surface = { colour: out.surface.colour };
  const clip = {};
  if (view.clip.box && view.clip.box.some((face) => face !== null)) clip.box = view.clip.box;
  if (view.clip.planes.length) clip.planes = view.clip.planes;
  if (Object.keys(clip).length) out.clip = clip;
  else delete out.clip;
  return out;
}

// 1 if two JSON values are equal.
export function same(a, b) {
  if (a === b) return true;
  if (typeof a !== "object" || typeof b !== "object" || !a || !b) return false;
  if (Array.isArray(a) !== Array.isArray(b)) return false;
  const keys = Object.keys(a);
  return keys.length === Object.keys(b).length && keys.every((key) => same(a[key], b[key]));
}
