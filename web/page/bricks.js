// The bricks of a .cvol file (doc/format.md, section 6), of which the beginning is there: where their bytes are.

const HEAD = 12; // bytes: signature and version
const SECTION = 24; // bytes before a section's content
const SHELLS = ["SHL0", "SHL1", "SHL2", "SHL3"];
const OTHER_KINDS = ["PACK", "LIST", "PICT", "BAKE"]; // of files without sections of bricks
const USUAL_SIDE = 64;
const USUAL_RUN = 16;
export const COARSEST = 3; // level
const GAP = 16384; // bytes between two ranges that one request fetches
const DCT = 1;
const FILTER_REACH = 2; // of the filters that draw
const LAP_REACH = 2;

// The sections that are there: {tag: {at (of the content), length}}.
function sectionsOf(view) {
  const found = {};
  for (let at = HEAD; at + SECTION <= view.byteLength; ) {
    const tag = String.fromCharCode(...[0, 1, 2, 3].map((i) => view.getUint8(at + i)));
    const length = Number(view.getBigUint64(at + 8, true));
    found[tag] = { at: at + SECTION, length };
    at += SECTION + length;
  }
  return found;
}

const wordsAt = (view, at, count) => Array.from({ length: count }, (_, i) => view.getUint32(at + 4 * i, true));

// The lengths of all bricks in all shells, which begin INDX.
function lengthsOf(bytes, { at }, count) {
  const lengths = new Float64Array(count);
  for (let k = 0; k < count; k++) {
    let [scale, byte] = [1, 0];
    do {
      byte = bytes[at++];
      lengths[k] += (byte & 127) * scale;
      scale *= 128;
    } while (byte & 128);
  }
  return lengths;
}

// {dims, sides (of a brick, in samples), grid (bricks along x, y, z), count, reach (samples beyond a brick that it
// changes), begin, end: of the bytes of all shells, heads(): the ranges of the headers of shells 1 to 3, isHead(k, bytes),
// rangesOf(levels)}; null if the beginning is too short, or the bricks of the file have no levels: it has a residual, is
// packed, or is no volume.
export function bricksOf(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.length);
  const found = sectionsOf(view);
  const { HEAD: head, INDX: index, SHL0: first, BRKS: shape, MODE: mode } = found;
  if (!head || !index || !first || OTHER_KINDS.some((tag) => found[tag])) return null;
  if (mode && view.getUint32(mode.at, true)) return null;
  const dims = [0, 8, 16].map((at) => Number(view.getBigUint64(head.at + at, true)));
  const [, transform, rank, block, lapped] = wordsAt(view, head.at + 24, 5);
  if (rank !== 3 || transform !== DCT || !block) return null;
  const sides = shape ? wordsAt(view, shape.at, 3) : Array(3).fill(USUAL_SIDE);
  const run = shape ? view.getUint32(shape.at + 12, true) : USUAL_RUN;
  const grid = dims.map((n, a) => Math.ceil(n / sides[a]));
  const count = grid[0] * grid[1] * grid[2];
  if (!(SHELLS.length * count <= index.length)) return null; // damaged: the reader of the whole file says so
  const lengths = lengthsOf(bytes, index, SHELLS.length * count);

  // Of each shell: where its bytes begin, and where each run of bricks ends.
  let at = first.at;
  const shells = SHELLS.map((tag, s) => {
    const [begin, ends] = [at, []];
    for (let b = 0; b < count; b++) {
      at += lengths[s * count + b];
      if ((b + 1) % run === 0 || b + 1 === count) ends.push(at);
    }
    at += SECTION;
    return { tag, begin, ends };
  });
  const finer = shells.slice(1);

  const isNeeded = (levels, shell, r) => {
    for (let b = r * run; b < Math.min(count, (r + 1) * run); b++) if (levels[b] <= COARSEST - shell) return true;
    return false;
  };

  return {
    dims,
    sides,
    grid,
    count,
    reach: FILTER_REACH + (lapped ? LAP_REACH : 0),
    begin: first.at,
    end: at - SECTION,
    heads: () => finer.map(({ begin }) => [begin - SECTION, begin]),
    isHead: (k, read) => String.fromCharCode(...read.subarray(0, 4)) === finer[k].tag,
    // The ranges [from, to) of bytes, in rising order, that bricks of these levels need beside level 3 and the heads.
    rangesOf(levels) {
      const ranges = [];
      finer.forEach(({ begin, ends }, k) =>
        ends.forEach((to, r) => {
          const from = r ? ends[r - 1] : begin;
          if (to === from || !isNeeded(levels, k + 1, r)) return;
          const last = ranges.at(-1);
          if (last && from - last[1] <= GAP) last[1] = to;
          else ranges.push([from, to]);
        }),
      );
      return ranges;
    },
  };
}
