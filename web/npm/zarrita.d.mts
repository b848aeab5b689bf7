/** A decoded chunk, as zarrita describes it. */
export interface Chunk {
  data: import("./index.mjs").Samples | BigInt64Array | BigUint64Array;
  shape: number[];
  stride: number[];
}

/** The codec `cvol` for zarrita's registry, for reading. */
export declare class CvolCodec {
  readonly kind: "array_to_bytes";
  readonly configuration: Record<string, unknown>;
  constructor(configuration: Record<string, unknown>, meta: { shape: number[] });
  static fromConfig(configuration: Record<string, unknown>, meta: { shape: number[] }): CvolCodec;
  /** Errors: a damaged chunk; another shape than the array's chunks; Fortran's order, bool and float16. */
  decode(bytes: Uint8Array): Promise<Chunk>;
  encode(): never;
}
