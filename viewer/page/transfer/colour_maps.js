// Colour maps for transfer functions: colours at equally spaced positions from 0 to 1, each as one number.

const maps = {
  Gray: [0x202020, 0xffffff],
  Viridis: [0x440154, 0x472d7b, 0x3b528b, 0x2c728e, 0x21918c, 0x28ae80, 0x5ec962, 0xaddc30, 0xfde725],
  Magma: [0x1d1147, 0x3b0f70, 0x641a80, 0x8c2981, 0xb73779, 0xde4968, 0xf7705c, 0xfe9f6d, 0xfcfdbf],
  Cividis: [0x00224e, 0x1f3b6d, 0x434e6c, 0x61646f, 0x7d7c78, 0x9b9476, 0xbcaf6f, 0xdecb60, 0xfee838],
  "Cool-warm": [0x3b4cc0, 0x6688ee, 0x9abbff, 0xc9d8f0, 0xdddddd, 0xf2cbb7, 0xf7a889, 0xe26952, 0xb40426],
  Hot: [0x400000, 0xff2000, 0xffd000, 0xffffff],
  Embers: [0x4d1f0f, 0x994419, 0xeb8c33, 0xffcf85, 0xfff8e8],
  Tissue: [0x402028, 0x8c4a48, 0xcc8f80, 0xebd2c2, 0xffffff],
  Fluorescence: [0x06203a, 0x0b6e75, 0x2fbf71, 0xb8f06a, 0xfffff0],
  Ice: [0x0a1a3c, 0x1c4f8a, 0x4a96c9, 0xa6d8ec, 0xffffff],
};

export const colourMaps = Object.keys(maps);

const channels = (colour) => [(colour >> 16) / 255, ((colour >> 8) & 255) / 255, (colour & 255) / 255];

/** [r, g, b] of a map at a position from 0 to 1. */
export function colourAt(name, place) {
  const stops = maps[name];
  const at = Math.min(1, Math.max(0, place)) * (stops.length - 1);
  const low = Math.min(stops.length - 2, Math.floor(at));
  const [from, to] = [channels(stops[low]), channels(stops[low + 1])];
  return from.map((value, k) => value + (at - low) * (to[k] - value));
}

/** The number of colours that define a map. */
export const stopCount = (name) => maps[name].length;

export function hexOf([r, g, b]) {
  const part = (value) =>
    Math.round(255 * Math.min(1, Math.max(0, value)))
      .toString(16)
      .padStart(2, "0");
  return `#${part(r)}${part(g)}${part(b)}`;
}

export const rgbOf = (hex) => channels(parseInt(hex.slice(1), 16));
