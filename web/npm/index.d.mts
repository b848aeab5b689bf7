/** Samples, x fastest. */
export type Samples =
  | Uint8Array
  | Int8Array
  | Uint16Array
  | Int16Array
  | Uint32Array
  | Int32Array
  | Float32Array
  | Float64Array;

export type SampleType = "uint8" | "int8" | "uint16" | "int16" | "uint32" | "int32" | "float32" | "float64";

/** Three numbers: x, y, z. */
export type Triple = [number, number, number];

export interface DecodeOptions {
  /** 0: all samples. 1, 2, 3: means of cells of 2, 4, 8 samples along each axis, from the file's lowest frequencies. */
  level?: number;
  /** x0, y0, z0, x1, y1, z1 in samples of the level, without the last ones. Default: all. */
  box?: [number, number, number, number, number, number];
  /** The volume of a file of several, from 0. */
  time?: number;
  channel?: number;
}

export interface Volume {
  data: Samples;
  type: SampleType;
  /** Samples of `data` along x, y, z. */
  shape: Triple;
  /** Distance of neighbours along each axis, in `unit`. */
  spacing: Triple;
  /** World position of the first sample of `data`. */
  origin: Triple;
  /** Unit vectors of the axes in the world, one after the other. */
  directions: number[];
  /** "mm", "um", ...; "": unknown. */
  unit: string;
  level: number;
  /** Of the level, in dB: measured, or a lower bound of a coarse level; null: it is exact. */
  psnr: number | null;
  /** The largest error of a sample, or an upper bound of it at a coarse level. */
  maxError: number;
  /** A certified bound of the L2 distance from the original samples: of the coefficients, which in an exact file are
   * coarser than its samples. */
  l2Error: number;
}

/** Decodes samples of a .cvol file. Errors: what is wrong with the file or an option, as an Error with one sentence. */
export declare function decode(bytes: Uint8Array | ArrayBuffer | ArrayBufferView, options?: DecodeOptions): Promise<Volume>;

export interface RangeOptions {
  /** 1, 2, 3: load only the beginning of the file, with this level. Labels and files of several volumes are loaded
   * as a whole. */
  level?: number;
  headers?: Record<string, string>;
  signal?: AbortSignal;
  /** In place of the global function. */
  fetch?: typeof globalThis.fetch;
  /** total: 0 if the server does not say. */
  onProgress?: (bytes: number, total: number) => void;
  /** The largest number of bytes to load. */
  limit?: number;
}

/** Loads a file from a server that answers ranges of bytes (or all of it, if it does not). An answer that ends early
 * goes on where it ended. Errors: a status of HTTP, CORS, a file that has changed, no .cvol file, an abort. */
export declare function openRange(url: string | URL, options?: RangeOptions): Promise<CvolFile>;

/** A file in memory, or its beginning, which decodes and draws `level` or coarser ones. */
export declare class CvolFile {
  constructor(bytes: Uint8Array | ArrayBuffer | ArrayBufferView, level?: number);
  readonly bytes: Uint8Array;
  readonly level: number;
  decode(options?: DecodeOptions): Promise<Volume>;
}

/** Fields of a VIEW of cvol's viewer (doc/viewer-api.md). What is not given is as in the viewer. */
export interface View {
  width?: number;
  height?: number;
  time?: number;
  mode?: "composite" | "xray" | "mean" | "mip" | "min" | "iso";
  camera?: { azimuth?: number; elevation?: number; roll?: number; zoom?: number; fov?: number; look_at?: Triple };
  mirror?: boolean;
  /** A name, or points [value, r, g, b, opacity]. */
  transfer?: string | [number, number, number, number, number][];
  opacity_scale?: number;
  window?: [number, number] | null;
  light?: Record<string, unknown>;
  surface?: { value?: number; colour?: Triple };
  clip?: { box?: (number | null)[]; planes?: [number, number, number, number][] };
  background?: Triple;
  step?: number;
  oversample?: number;
  footprint?: string;
}

export interface Picture {
  width: number;
  height: number;
  /** Bytes R G B A, the top row first. */
  data: Uint8ClampedArray;
}

export declare class Renderer {
  static create(
    source: Uint8Array | ArrayBuffer | ArrayBufferView | CvolFile,
    options?: { time?: number; channel?: number; name?: string },
  ): Promise<Renderer>;
  /** What doc/viewer-api.md calls a VOLUME. */
  readonly volume: Record<string, unknown>;
  draw(view?: View): Picture;
  /** Frees its memory. */
  close(): void;
}

/** An HTMLCanvasElement or an OffscreenCanvas. */
export interface Canvas {
  width: number;
  height: number;
  getContext(kind: "2d"): unknown;
}

/** Draws a picture onto a canvas, in the canvas's size unless the view has one; null: only returns the pixels. */
export declare function render(
  canvas: Canvas | null,
  source: Uint8Array | ArrayBuffer | ArrayBufferView | CvolFile | Renderer,
  view?: View,
): Promise<Picture>;
