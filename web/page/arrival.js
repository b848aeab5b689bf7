// A file that arrives from a server, part by part. The coefficients of a .cvol file stand in the order of its levels,
// so the file's beginning is a file of a coarse level. After it, another way of loading may take over (ranged.js).

const HEAD = 12; // bytes: signature and version
const SECTION = 24; // bytes before a section's content
const LEVELS = { SHL0: 3, SHL1: 2, SHL2: 1 }; // the finest level that is complete after the section
const LABELS = 4; // as residual in MODE
const SIGNATURE = [0x8b, 0x43, 0x56, 0x4c];
const ATTEMPTS = 5; // without a byte more, before it gives up
const PAUSE_MS = 300; // before the next one; each later pause is twice as long

export const isCvol = (bytes) => bytes.length >= HEAD && SIGNATURE.every((byte, i) => bytes[i] === byte);

// The finest complete level of a .cvol file of which there are the bytes; 0: none is known, or coarse levels say nothing,
// because the samples are labels. Levels of a file with a residual lack it, and are blurred like all others. Files of
// several volumes and packed files have no levels here.
export function levelOf(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.length);
  let level = 0;
  for (let at = HEAD; at + SECTION <= bytes.length; ) {
    const tag = String.fromCharCode(...bytes.subarray(at, at + 4));
    if (tag === "MODE" && bytes[at + SECTION] === LABELS) return 0;
    at += SECTION + Number(view.getBigUint64(at + 8, true));
    if (at <= bytes.length) level = LEVELS[tag] ?? level;
  }
  return level;
}

const failure = (sentence, more = {}) => Object.assign(new Error(sentence), more);

function explain(address) {
  const here = globalThis.location; // Node has none
  if (here?.protocol === "file:") return "a page from a disk cannot read other files: drop the file here";
  return here && address.origin !== here.origin
    ? `${address.origin} does not answer, or does not allow other pages to read it (CORS)`
    : "the server does not answer";
}

// The tag of a file's content, also if a server compresses it on the way.
const tagOf = (headers) => headers.get("ETag")?.replace(/^W\/|-gzip(?="$)/g, "") ?? "";
const differ = (a, b) => a && b && a !== b;

// Asks for the bytes from `from` on, or [from, to). {answer, from: where it begins, total: bytes of the file, or 0 if not
// known, tag}; null: there are no more.
async function request(address, name, from, { fetch = globalThis.fetch, headers: asked = {}, signal, cache } = {}, to = 0) {
  let answer;
  const range = from || to ? { Range: `bytes=${from}-${to ? to - 1 : ""}` } : {};
  try {
    answer = await fetch(address, { headers: { ...asked, ...range }, signal, ...(cache && { cache }) });
  } catch {
    signal?.throwIfAborted();
    throw failure(`${name}: ${explain(address)}`, { again: from > 0 });
  }
  const { status, headers } = answer;
  const told = /^bytes (?:(\d+)-\d+|\*)\/(\d+)$/.exec(headers.get("Content-Range") ?? "");
  if (status === 416 && Number(told?.[2]) === from) return null;
  if (status !== 200 && status !== 206) {
    const again = from > 0 && status >= 500;
    throw failure(`${name}: the server answers ${status} ${answer.statusText}`.trim(), { again });
  }
  const length = headers.get("Content-Encoding") ? 0 : Number(headers.get("Content-Length"));
  const begin = status === 206 ? Number(told?.[1] ?? from) : 0;
  const total = told ? Number(told[2]) : length && begin + length;
  return { answer, from: begin, total, tag: tagOf(headers), isPart: status === 206 };
}

const pause = (tried) => new Promise((done) => setTimeout(done, PAUSE_MS * 2 ** tried));

// The bytes [from, to) of a file that had this tag; it tries again if the connection ends. A browser's cache would let
// requests of one file wait for each other, and give parts of another file the tag of the first.
async function requestRange(address, name, tag, from, to, options) {
  for (let tried = 0; ; tried++) {
    try {
      const now = await request(address, name, from, { ...options, cache: "no-store" }, to);
      if (!now?.isPart || now.from !== from || differ(now.tag, tag))
        throw failure(`${name}: the file has changed: load the page again`);
      const bytes = new Uint8Array(await now.answer.arrayBuffer());
      if (bytes.length === to - from) return bytes;
      if (bytes.length > to - from) throw failure(`${name}: the server sends other bytes than it was asked for`);
    } catch (error) {
      options?.signal?.throwIfAborted();
      if (error.message.startsWith(`${name}: `) && !error.again) throw error;
    }
    if (tried + 1 >= ATTEMPTS) throw failure(`${name}: the server's answer ends early: load the page again`);
    await pause(tried);
  }
}

// The bytes of a file as they arrive: an answer that ends early goes on where it ended, if the server can do that and
// still has the same file.
function createBuffer() {
  let bytes = new Uint8Array(1 << 20);
  let used = 0;
  return {
    get used() {
      return used;
    },
    get all() {
      return bytes.subarray(0, used);
    },
    clear: () => (used = 0),
    add(part, total) {
      if (used + part.length > bytes.length) {
        const more = new Uint8Array(Math.max(total, 2 * bytes.length, used + part.length));
        more.set(bytes.subarray(0, used));
        bytes = more;
      }
      bytes.set(part, used);
      used += part.length;
    },
  };
}

async function receive(address, name, buffer, { more, refuse, options }) {
  let before = null;
  let most = 0; // bytes that were there at once
  for (let left = ATTEMPTS; ; left--) {
    const start = buffer.used;
    let [total, ended] = [0, false];
    try {
      const now = await request(address, name, start, options);
      if (!now) return;
      const other = before && (differ(now.tag, before.tag) || differ(now.total, before.total));
      if (now.from !== start || (other && start)) {
        buffer.clear();
        if (now.from) throw failure(`${name}: the file has changed: load the page again`);
      }
      [before, total] = [now, now.total];
      refuse(total);
      const reader = now.answer.body.getReader();
      for (let { done, value } = await reader.read(); !done; { done, value } = await reader.read()) {
        buffer.add(value, total);
        refuse(buffer.used);
        try {
          more(total, now.tag);
        } catch (error) {
          throw failure(`${name}: ${error.message}`); // not the connection's
        }
      }
      ended = true;
    } catch (error) {
      options?.signal?.throwIfAborted();
      if (error.message.startsWith(`${name}: `) && !error.again) throw error;
    }
    if (ended && buffer.used >= total) return;
    if (buffer.used > most) left = ATTEMPTS;
    most = Math.max(most, buffer.used);
    if (left <= 1) throw failure(`${name}: the server's answer ends early: load the page again`);
    await pause(ATTEMPTS - left);
  }
}

// Begins to load. {head: promise of the first bytes, level(n): promise of the bytes when level n or a finer one is
// complete, or null if all bytes are there first, whole: promise of all bytes, sofar(): a copy of those that are there,
// from the first one on, branched: promise of what took over, or null}.
// progress(bytes, total) during loading; refuse(bytes) throws if the file is too large.
// branch({bytes(): those that are there now, from the first one on, total, fetchRange(from, to)}), if it is given, is called
// once, when a level is complete. It resolves with {whole: promise of all bytes, beginning: bytes from the first one on}, which takes over, or
// with null, and may call fail(error) later.
// options: { fetch, headers, signal }, all of which may be missing.
export function arrive(address, name, { progress, refuse, branch, options = {} }) {
  const buffer = createBuffer();
  const waiting = []; // {when(): whether it is time, resolve, reject}
  const stop = new AbortController();
  const own = { ...options, signal: stop.signal };
  let ended = false;
  let failed = null;
  let level = 0;
  let asked = !branch; // branch() was called
  let decided = !branch; // it has answered
  let branched = null;

  const settle = () => {
    for (const entry of [...waiting])
      if (failed || ended || entry.when()) {
        waiting.splice(waiting.indexOf(entry), 1);
        if (failed) entry.reject(failed);
        else entry.resolve();
      }
  };
  const until = (when) => new Promise((resolve, reject) => (waiting.push({ when, resolve, reject }), settle()));
  const copy = () => (branched ? branched.beginning : buffer.all).slice();
  const end = () => ((ended = true), settle());
  const fail = (error) => ((failed = error), settle());

  function tryBranch(total, tag) {
    const fetchRange = (from, to) => requestRange(address, name, tag, from, to, options);
    asked = true;
    branch({ bytes: () => buffer.all, total, fetchRange, fail }).then((taken) => {
      decided = true;
      if (taken && !ended && !failed) {
        branched = taken;
        stop.abort();
        taken.whole.then(end);
      }
      settle();
    });
  }

  const more = (total, tag) => {
    if (isCvol(buffer.all)) level = levelOf(buffer.all);
    progress(buffer.used, total);
    settle();
    if (!asked && level > 0) tryBranch(total, tag);
  };
  options.signal?.addEventListener("abort", () => stop.abort(options.signal.reason));
  const over = until(() => decided).then(() => branched);
  over.catch(() => {}); // the other promises say it
  receive(address, name, buffer, { more, refuse, options: own }).then(end, (error) => branched || fail(error));

  return {
    head: until(() => buffer.used >= HEAD).then(copy),
    level: (n) => until(() => level > 0 && level <= n).then(() => (ended ? null : copy().buffer)),
    whole: until(() => false).then(() => copy().buffer),
    sofar: () => copy().buffer,
    branched: over,
  };
}
