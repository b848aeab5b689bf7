// The codec `cvol` of Zarr (doc/zarr.md in cvol's sources) for zarrita, reading only:
//
//     import * as zarr from "zarrita";
//     import { CvolCodec } from "cvol/zarrita";
//     zarr.registry.set("cvol", async () => CvolCodec);

import { decode } from "./index.mjs";

const SIGNATURE = [0x8b, 0x43, 0x56, 0x4b, 0x0d, 0x0a, 0x1a, 0x0a];
const FIRST = 16; // bytes before the lengths of the axes
// Types of chunks whose files have another one.
const WIDE = { "<i8": BigInt64Array, "<u8": BigUint64Array };
const PLAIN = /^(\|[iu]1|<[iu][24]|<f[48])$/;

const product = (lengths) => lengths.reduce((all, n) => all * n, 1);
const strides = (shape) => shape.map((_, axis) => product(shape.slice(axis + 1)));

const TABLE = Uint32Array.from({ length: 256 }, (_, n) => {
  for (let k = 0; k < 8; k++) n = n & 1 ? 0xedb88320 ^ (n >>> 1) : n >>> 1;
  return n;
});
const crc32 = (bytes) => ~bytes.reduce((crc, byte) => TABLE[(crc ^ byte) & 255] ^ (crc >>> 8), ~0) >>> 0;

// {shape, type, files}: what the header of a chunk says, and the bytes of its volumes.
function parse(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.length);
  const fail = (what) => {
    throw new Error(`a chunk of cvol ${what}`);
  };
  if (bytes.length < FIRST || bytes[8] !== 1) fail("has another version than 1");
  const axes = bytes[9];
  const length = (i) => (FIRST + 8 * i + 8 <= bytes.length ? Number(view.getBigUint64(FIRST + 8 * i, true)) : fail("ends early"));
  const shape = Array.from({ length: axes }, (_, i) => length(i));
  const count = product(shape) ? product(shape.slice(0, -3)) : 0;
  let at = FIRST + 8 * (axes + count);
  // The checksum comes first: damaged lengths may be of any size.
  if (!(at + 4 <= bytes.length) || view.getUint32(at, true) !== crc32(bytes.subarray(0, at))) fail("has a damaged header");
  at += 4;
  const sizes = Array.from({ length: count }, (_, i) => length(axes + i));
  const files = sizes.map((size) => bytes.subarray(at, (at += size)));
  if (at !== bytes.length) fail(`has ${bytes.length} bytes, and its header says ${at}`);
  if (bytes[10] !== 0x43) fail("in Fortran's order cannot be read in JavaScript");
  const type = new TextDecoder().decode(bytes.subarray(11, FIRST)).replace(/\0+$/, "");
  if (!WIDE[type] && !PLAIN.test(type)) fail(`of type ${type} cannot be read in JavaScript`);
  return { shape, type, files };
}

export class CvolCodec {
  kind = "array_to_bytes";
  #shape;

  constructor(configuration, meta) {
    this.configuration = configuration;
    this.#shape = meta.shape;
  }

  static fromConfig(configuration, meta) {
    return new CvolCodec(configuration, meta);
  }

  // {data, shape, stride} of a chunk in C order.
  async decode(bytes) {
    const shape = this.#shape;
    const isFile = !SIGNATURE.every((byte, i) => bytes[i] === byte);
    const { type, files, shape: own } = isFile ? { files: [bytes], shape } : parse(bytes);
    if (own.length !== shape.length || own.some((n, axis) => n !== shape[axis]))
      throw new Error(`a chunk of cvol has the shape ${own}, and its array's chunks have ${shape}`);
    const parts = [];
    const volume = [1, 1, 1, ...shape].slice(-3);
    for (const file of files) {
      const part = await decode(file);
      if (part.shape.some((n, axis) => n !== volume[2 - axis]))
        throw new Error(`a chunk of cvol has volumes of ${part.shape} samples (x, y, z), not ${volume.reverse()}`);
      parts.push(part.data);
    }
    const taken = parts.reduce((sum, part) => sum + part.length, 0);
    if (taken !== product(shape)) throw new Error(`a chunk of cvol has ${taken} samples, not ${product(shape)}`);
    const Samples = WIDE[type] ?? parts[0]?.constructor ?? Uint8Array;
    const data = new Samples(taken);
    let at = 0;
    for (const part of parts) {
      if (WIDE[type]) part.forEach((value, i) => (data[at + i] = BigInt(value)));
      else data.set(part, at);
      at += part.length;
    }
    return { data, shape, stride: strides(shape) };
  }

  encode() {
    throw new Error("the codec cvol writes no chunks in JavaScript");
  }
}
