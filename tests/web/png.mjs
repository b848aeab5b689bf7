// Reads PNG files of 8 bits: RGB, RGBA or grey. {width, height, rgb: bytes}

import { inflateSync } from "node:zlib";

const CHANNELS = { 0: 1, 2: 3, 6: 4 };

function chunksOf(file) {
  const chunks = [];
  for (let at = 8; at < file.length; ) {
    const size = file.readUInt32BE(at);
    chunks.push([file.toString("latin1", at + 4, at + 8), file.subarray(at + 8, at + 8 + size)]);
    at += 12 + size;
  }
  return chunks;
}

function paeth(left, above, corner) {
  const guess = left + above - corner;
  const [a, b, c] = [left, above, corner].map((value) => Math.abs(guess - value));
  return a <= b && a <= c ? left : b <= c ? above : corner;
}

// Undoes the filter of a row, in place.
function unfilter(row, filter, above, channels) {
  for (let i = 0; i < row.length; i++) {
    const left = i >= channels ? row[i - channels] : 0;
    const corner = i >= channels ? above[i - channels] : 0;
    row[i] += [0, left, above[i], (left + above[i]) >> 1, paeth(left, above[i], corner)][filter];
  }
}

export function readPng(file) {
  const chunks = chunksOf(file);
  const header = chunks[0][1];
  const [width, height] = [header.readUInt32BE(0), header.readUInt32BE(4)];
  const channels = CHANNELS[header[9]];
  const data = inflateSync(Buffer.concat(chunks.filter(([name]) => name === "IDAT").map(([, bytes]) => bytes)));
  const rgb = new Uint8Array(3 * width * height);
  let above = new Uint8Array(width * channels);
  for (let y = 0; y < height; y++) {
    const start = y * (width * channels + 1);
    const row = new Uint8Array(data.subarray(start + 1, start + 1 + width * channels));
    unfilter(row, data[start], above, channels);
    for (let x = 0; x < width; x++)
      for (let c = 0; c < 3; c++) rgb[3 * (y * width + x) + c] = row[x * channels + (channels > 1 ? c : 0)];
    above = row;
  }
  return { width, height, rgb };
}
