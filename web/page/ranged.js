// A file of a server of which only what is wanted is loaded: the bricks (bricks.js) of a view, as fine as it needs.

import { bricksOf, COARSEST } from "./bricks.js";

const AT_ONCE = 4; // requests
const RANGED_MIN = 4e6; // bytes that are worth more requests
const PART = 1 << 18; // bytes of a request, at most: what is wanted changes
const FINER = [2, 1, 0]; // levels, in the order of loading

// Ranges [from, to) in rising order, joined where they touch, of which some may overlap.
function joined(ranges) {
  const all = [];
  for (const [from, to] of [...ranges].sort((a, b) => a[0] - b[0])) {
    const last = all.at(-1);
    if (last && from <= last[1]) last[1] = Math.max(last[1], to);
    else all.push([from, to]);
  }
  return all;
}

// The parts of ranges that are not in `there`; both in rising order.
function without(ranges, there) {
  const parts = [];
  let k = 0;
  for (let [from, to] of ranges) {
    while (k < there.length && there[k][1] <= from) k++;
    for (let i = k; i < there.length && there[i][0] < to; i++) {
      if (there[i][0] > from) parts.push([from, there[i][0]]);
      from = Math.max(from, there[i][1]);
    }
    if (from < to) parts.push([from, to]);
  }
  return parts;
}

const bytesIn = (ranges) => ranges.reduce((sum, [from, to]) => sum + to - from, 0);
const same = (a, b) => a.length === b.length && a.every((level, i) => level === b[i]);
const firstPart = ([from, to]) => [from, Math.min(to, from + PART)];

// Takes over from arrival.js, as its `branch`: resolves with a ranged file, or with null if the rest of the file is small,
// its bricks have no levels, or the server does not answer ranges.
export async function branchOff({ bytes, total, fetchRange, fail }, progress) {
  const bricks = total - bytes().length < RANGED_MIN ? null : bricksOf(bytes());
  if (!bricks) return null;
  const heads = bricks.heads();
  try {
    const read = await Promise.all(heads.map((range) => fetchRange(...range)));
    if (!read.every((head, k) => bricks.isHead(k, head))) return null;
    const pieces = read.map((head, k) => ({ from: heads[k][0], bytes: head }));
    return createRanged({ first: bytes().slice(), pieces, bricks, total, fetchRange, progress, failed: fail });
  } catch {
    return null;
  }
}

// first: the beginning of the file, with level 3 or more; pieces: [{from, bytes}], more of it; bricks: bricksOf(first);
// total: bytes of the file; fetchRange(from, to) resolves with these bytes. progress(bytes, total, whether more is on its way);
// failed(error): it ends.
function createRanged({ first, pieces: more, bricks, total, fetchRange, progress, failed }) {
  const pieces = [{ from: 0, bytes: first }, ...more];
  let there = joined(pieces.map(({ from, bytes }) => [from, from + bytes.length]));
  let used = bytesIn(there);
  let underway = []; // ranges
  let wanted = new Uint8Array(bricks.count).fill(COARSEST);
  let have = wanted; // levels of what is there
  let given = null; // levels of the last part that next() gave
  let givenAt = 0; // when it did so
  let openingMs = 0; // that part took to open
  let begun = { at: 0, used }; // when loading began that goes on
  let waiting = null; // resolves next()
  let all = false; // the whole file is wanted
  let broken = false;
  let resolveWhole;
  const whole = new Promise((resolve) => (resolveWhole = resolve));

  // What is wanted, but at this level at most; and what is there.
  const step = (level) => have.map((own, b) => Math.min(own, Math.max(wanted[b], level)));

  // The next range to load: coarse levels of all wanted bricks first.
  function nextRange() {
    const rows = FINER.map((level) => bricks.rangesOf(step(level)));
    if (all) rows.push([[0, total]]);
    for (const ranges of rows) {
      const [next] = without(ranges, joined([...there, ...underway]));
      if (next) return firstPart(next);
    }
    return null;
  }

  // True if opening what is there now would take longer than loading all that is wanted.
  function isWorthWaiting() {
    const left = bytesIn(without(bricks.rangesOf(step(0)), there));
    const rate = (used - begun.used) / (performance.now() - begun.at);
    return left > 0 && left < rate * openingMs;
  }

  // Gives the levels that are there to the one who waits for them.
  function give() {
    for (const level of FINER) {
      const levels = step(level);
      if (without(bricks.rangesOf(levels), there).length) break;
      have = levels;
    }
    if (!waiting || (given && same(have, given)) || isWorthWaiting()) return;
    given = have;
    givenAt = performance.now();
    waiting({ levels: have, level: Math.min(...have), size: total, pieces });
    waiting = null;
  }

  function fail(error) {
    if (!broken) failed(error);
    broken = true;
  }

  async function load(range) {
    underway.push(range);
    try {
      const bytes = await fetchRange(...range);
      pieces.push({ from: range[0], bytes });
      there = joined([...there, range]);
      used += bytes.length;
    } catch (error) {
      fail(error);
    }
    underway = underway.filter((one) => one !== range);
    go();
  }

  function go() {
    if (!underway.length) begun = { at: performance.now(), used };
    while (!broken && underway.length < AT_ONCE) {
      const range = nextRange();
      if (!range) break;
      load(range);
    }
    progress(used, total, underway.length > 0);
    if (used === total) resolveWhole();
    else give();
  }

  return {
    bricks,
    whole, // resolves when all bytes are there
    fail, // a part cannot be opened
    // The bytes that are there, from the first one to the first gap.
    get beginning() {
      const bytes = new Uint8Array(there[0][1]);
      for (const piece of pieces) if (piece.from < bytes.length) bytes.set(piece.bytes, piece.from);
      return bytes;
    },
    // True if a part of these levels has all that is wanted.
    suffices: (levels) => levels.every((level, b) => level <= wanted[b]),
    // Loads bricks up to these levels, and no others any more.
    want(levels) {
      if (all || same(levels, wanted)) return;
      wanted = levels;
      go();
    },
    // Loads the whole file.
    wantAll() {
      all = true;
      wanted = new Uint8Array(bricks.count);
      go();
    },
    // Resolves with {levels, level (the finest), size, pieces: [{from, bytes}]} when more of what is wanted is there.
    next() {
      if (given) openingMs = performance.now() - givenAt;
      return new Promise((resolve) => ((waiting = resolve), give()));
    },
  };
}
