// The automatic window of modes xray, mip and min. A small picture with a window of all values gives the values in
// the picture; the window covers these.

import { api } from "../state/api.js";
import { rounded } from "../state/meaning.js";
import { store } from "../state/store.js";
import { requestView, same } from "../state/view.js";
import { volumes } from "../state/volumes.js";

const SIZE = 128;
const LOW = 0.01;
const HIGH = 0.998;
const PROJECTIONS = ["xray", "mip", "min"];

let chosen = null; // the last automatic window

// 1 if the mode needs a window and the user has set none.
export const wantsWindow = (mode, { window }) =>
  PROJECTIONS.includes(mode) && (window === null || same(window, chosen));

async function greys(blob) {
  const bitmap = await createImageBitmap(blob);
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = SIZE;
  const context = canvas.getContext("2d", { willReadFrequently: true });
  context.drawImage(bitmap, 0, 0, SIZE, SIZE);
  bitmap.close();
  const { data } = context.getImageData(0, 0, SIZE, SIZE);
  return data.filter((_, at) => at % 4 === 0 && data[at] > 0).sort();
}

// [black, white], rounded; null if the picture has no values.
export async function autoWindow(mode) {
  const volume = volumes.current();
  if (volume?.state !== "ready" || !(volume.min < volume.max)) return null;
  const zoom = 1;
  const view = { ...store.state.view, mode, channels: null, overlays: [], background: [0, 0, 0], window: [volume.min, volume.max] };
  const asked = requestView({ ...view, camera: { ...view.camera, zoom, look_at: [0, 0, 0], fov: 0 } }, SIZE, SIZE);
  const { blob } = await api.frame({
    view: asked,
    quality: "still",
    format: "png",
    viewer: "window",
    sequence: Date.now(),
  });
  const sorted = await greys(blob);
  if (sorted.length < 16) return null;
  const value = (part, more) => {
    const grey = sorted[Math.min(sorted.length - 1, Math.floor(part * sorted.length))] + more;
    return volume.min + (Math.max(0, Math.min(255, grey)) / 255) * (volume.max - volume.min);
  };
  const digits = 3 - Math.floor(Math.log10(volume.max - volume.min));
  const window = [value(LOW, -1), value(HIGH, 1)].map((v) => rounded(v, digits));
  if (!(window[0] < window[1])) return null;
  chosen = window;
  return window;
}
