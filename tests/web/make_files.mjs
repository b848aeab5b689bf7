// Makes files for tests: a NIfTI file of several times, and slices of a DICOM series, of bytes.

const NIFTI_HEAD = 352;

/** samples: bytes of dims [nx, ny, nz, times]; spacing: of x, y, z in mm and of times in s. */
export function niftiOf(samples, dims, spacing) {
  const head = Buffer.alloc(NIFTI_HEAD);
  head.writeInt32LE(348, 0);
  [dims.length, ...dims, 1, 1, 1].slice(0, 8).forEach((n, i) => head.writeInt16LE(n, 40 + 2 * i));
  head.writeInt16LE(2, 70); // unsigned bytes
  head.writeInt16LE(8, 72);
  [1, ...spacing].forEach((length, i) => head.writeFloatLE(length, 76 + 4 * i));
  head.writeFloatLE(NIFTI_HEAD, 108);
  head.writeInt8(2 + 8, 123); // mm and s
  head.write("n+1\0", 344, "latin1");
  return Buffer.concat([head, samples]);
}

// An element in Explicit VR Little Endian (DICOM PS3.5, section 7.1.2).
function elementOf(group, number, kind, value) {
  const text = typeof value === "string";
  const bytes = text ? Buffer.from(value + (value.length % 2 ? (kind === "UI" ? "\0" : " ") : ""), "latin1") : value;
  const long = ["OB", "OW"].includes(kind);
  const head = Buffer.alloc(long ? 12 : 8);
  head.writeUInt16LE(group, 0);
  head.writeUInt16LE(number, 2);
  head.write(kind, 4, "latin1");
  if (long) head.writeUInt32LE(bytes.length, 8);
  else head.writeUInt16LE(bytes.length, 6);
  return Buffer.concat([head, bytes]);
}

const word = (value) => {
  const bytes = Buffer.alloc(2);
  bytes.writeUInt16LE(value);
  return bytes;
};

// Pixels in one fragment (DICOM PS3.5, appendix A.4).
function packedPixels(bytes) {
  const item = (number, length) => {
    const head = Buffer.alloc(8);
    head.writeUInt16LE(0xfffe, 0);
    head.writeUInt16LE(number, 2);
    head.writeUInt32LE(length, 4);
    return head;
  };
  const element = elementOf(0x7fe0, 0x10, "OB", Buffer.alloc(0));
  element.writeUInt32LE(0xffffffff, 8);
  return Buffer.concat([element, item(0xe000, 0), item(0xe000, bytes.length), bytes, item(0xe0dd, 0)]);
}

const RAW = "1.2.840.10008.1.2.1";

/** The slice z of a series of CT, of bytes of nx x ny samples. transfer: the transfer syntax. */
export function dicomOf(samples, [nx, ny], spacing, z, { transfer = RAW, number = 1, description = "" } = {}) {
  const meta = Buffer.concat([
    elementOf(2, 2, "UI", "1.2.840.10008.5.1.4.1.1.2"),
    elementOf(2, 3, "UI", `1.2.3.4.${z + 1}`),
    elementOf(2, 0x10, "UI", transfer),
  ]);
  const length = Buffer.alloc(4);
  length.writeUInt32LE(meta.length);
  const main = [
    elementOf(8, 0x16, "UI", "1.2.840.10008.5.1.4.1.1.2"),
    elementOf(8, 0x18, "UI", `1.2.3.4.${z + 1}`),
    elementOf(8, 0x60, "CS", "CT"),
    elementOf(8, 0x103e, "LO", description),
    elementOf(0x20, 0xd, "UI", "1.2.3.5"),
    elementOf(0x20, 0xe, "UI", `1.2.3.6.${number}`),
    elementOf(0x20, 0x11, "IS", String(number)),
    elementOf(0x20, 0x13, "IS", String(z + 1)),
    elementOf(0x20, 0x32, "DS", `0\\0\\${spacing[2] * z}`),
    elementOf(0x20, 0x37, "DS", "1\\0\\0\\0\\1\\0"),
    elementOf(0x28, 2, "US", word(1)),
    elementOf(0x28, 4, "CS", "MONOCHROME2"),
    elementOf(0x28, 0x10, "US", word(ny)),
    elementOf(0x28, 0x11, "US", word(nx)),
    elementOf(0x28, 0x30, "DS", `${spacing[1]}\\${spacing[0]}`),
    elementOf(0x28, 0x100, "US", word(8)),
    elementOf(0x28, 0x101, "US", word(8)),
    elementOf(0x28, 0x102, "US", word(7)),
    elementOf(0x28, 0x103, "US", word(0)),
    transfer === RAW ? elementOf(0x7fe0, 0x10, "OW", samples) : packedPixels(samples),
  ];
  return Buffer.concat([Buffer.alloc(128), Buffer.from("DICM"), elementOf(2, 0, "UL", length), meta, ...main]);
}
