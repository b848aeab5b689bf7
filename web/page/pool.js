// Workers, each with a WebAssembly instance. The first one opens the volumes. Meanwhile the second one opens their
// coarse levels, and answers requests for which these are enough. Then the memory of the first instance goes from
// worker to worker, and all have the volumes. Each works on one request at a time; requests that wait are dropped if
// they are cancelled.
//
// While a file arrives (arrival.js), the second worker has the finest level that is there. Another worker opens the next
// level, and takes its place. Of a ranged file (ranged.js) a part is there: as much as is wanted. When there is more,
// other workers open it, and take the place of all.

import { levelOf } from "./arrival.js";

const COARSE = 2; // level: 1/4 of the samples along each axis
const COARSEST = 3;
const WHOLE = 0;

const failure = (sentence, status) => Object.assign(new Error(sentence), { status });
export const aborted = () => new DOMException("The request was cancelled.", "AbortError");

// start(): makes a Worker. opening: what worker.js opens, and a promise of the compiled module. A file that is arriving has `arrival`.
// onRanged(): called when the file has become a ranged one; onPart(): when there is more of it.
export function createPool(count, start, { module, files, onRanged, onPart, ...opening }) {
  let waiting = []; // {request, signal, coarse, resolve, reject}
  let broken = null; // the error of the volumes
  let ended = false;
  let lost = null; // the error of a file that did not arrive: what is there stays
  let ranged = null; // the only file, if it is one
  let part = 0; // the number of parts of it that were opened
  let opened = null; // levels of the bricks of the last one
  // level: of the volumes that it has; null: none. module: what it must compile to begin.
  const makeSeat = () => hear({ worker: start(), task: null, heap: 0, level: null, module });
  const workers = Array.from({ length: count }, makeSeat);
  const arriving = files.some(({ arrival }) => arrival);
  let hasAll = !arriving; // all bytes of all files

  function nextFor({ level }) {
    waiting = waiting.filter(({ signal, reject }) => !signal?.aborted || reject(aborted()));
    const place = waiting.findIndex(({ coarse }) => level === WHOLE || (coarse && level > WHOLE));
    return place < 0 ? null : waiting.splice(place, 1)[0];
  }

  function give(seat, task = seat.task === null ? nextFor(seat) : null) {
    if (!task) return;
    seat.task = task;
    seat.worker.postMessage(task.request, task.given ?? []);
  }

  function take(seat, data) {
    const { task } = seat;
    if (data.heap) seat.heap = data.heap;
    seat.task = null;
    if (data.failure === undefined) task?.resolve({ ...data, level: seat.level, part });
    else task?.reject(failure(`The page cannot draw: ${data.failure}`, 500));
    give(seat);
  }

  // Asks a worker that is idle, or will be soon.
  async function order(seat, request, given) {
    const begin = await seat.module;
    while (seat.task) await seat.task.done.catch(() => {});
    const task = { request: { ...request, begin }, given };
    seat.module = null;
    task.done = new Promise((resolve, reject) => Object.assign(task, { resolve, reject }));
    give(seat, task);
    return task.done;
  }

  function hear(seat) {
    seat.worker.onmessage = ({ data }) => take(seat, data);
    seat.worker.onerror = (event) => take(seat, { failure: event.message || "a worker does not start" });
    return seat;
  }

  // The files with the bytes that bytesOf() gives; null if it gives none.
  async function filesWith(bytesOf) {
    const made = await Promise.all(files.map(async (file) => ({ name: file.name, bytes: await bytesOf(file) })));
    return made.every(({ bytes }) => bytes) ? made : null;
  }

  async function openAll() {
    const all = await filesWith(({ bytes, arrival }) => arrival?.whole ?? bytes).catch(async (error) => {
      await coarse; // the last level that is there
      lost = error;
    });
    if (!all) return;
    if (!arriving) await coarse; // the first picture comes sooner if one worker alone has the processor
    hasAll = true;
    if (ranged) return; // openParts() does it
    const { memory, series } = await order(workers[0], { open: { ...opening, files: all, level: WHOLE }, lend: count > 1 });
    serve(workers[0], WHOLE);
    await copyTo(workers.slice(1), memory, series && all);
  }

  // Gives the memory of an instance from seat to seat. files: of a series, which reads them later.
  async function copyTo(seats, memory, files) {
    for (const seat of seats) {
      try {
        ({ memory } = await order(seat, { load: memory, ...(files && { files }) }, [memory]));
      } catch {
        break; // without memory for so many instances
      }
      serve(seat, WHOLE);
    }
  }

  // True if a level of the files is enough for pictures: their volumes are no labels. The seat gets no requests yet.
  async function openLevel(seat, level, given) {
    const { ready, lossy } = await order(seat, { open: { ...opening, files: given, level } });
    return ready && (lossy || given.every(({ bytes }) => levelOf(new Uint8Array(bytes)) > 0));
  }

  function serve(seat, level) {
    seat.level = level;
    give(seat);
  }

  // A worker takes the place of another one, which ends when it has answered.
  async function replace(place, seat) {
    const before = workers[place];
    workers[place] = seat;
    before.level = null; // it gets no more to do
    await before.task?.done.catch(() => {});
    before.worker.terminate();
  }

  // Opens one part after the other of a ranged file, as long as there are more.
  async function openParts() {
    while (!broken) {
      const { levels, level, ...file } = await ranged.next();
      if (broken) return;
      const seats = Array.from({ length: count }, makeSeat);
      const [first, ...others] = seats;
      const volumes = opening.volumes.map((volume) => ({ ...volume, brickLevels: levels }));
      const what = { ...opening, volumes, files: [{ name: files[0].name, ...file }], level };
      const { ready, error, memory } = await order(first, { open: what, lend: count > 1 });
      if (broken || !ready) {
        for (const { worker } of seats) worker.terminate();
        return broken || ranged.fail(failure(error, 500));
      }
      part++;
      opened = levels;
      workers.forEach((seat) => (seat.level = null)); // they have less
      serve(first, WHOLE);
      await replace(0, first);
      onPart();
      await copyTo(others, memory);
      await Promise.all(others.map((seat, k) => replace(k + 1, seat)));
    }
  }

  // Opens level after level of files that arrive, until all bytes are there: each by a new worker, which takes the place
  // of the one before.
  async function openArriving() {
    for (let level = COARSEST; level > WHOLE; level--) {
      const given = await filesWith(({ bytes, arrival }) => (arrival ? arrival.level(level) : bytes));
      if (!given || hasAll || broken) return;
      const seat = makeSeat();
      const fit = await openLevel(seat, level, given).catch(() => false);
      if (!fit || hasAll || broken) {
        seat.worker.terminate();
        continue;
      }
      serve(seat, level);
      await replace(1, seat);
      if (level === COARSEST) ranged = await rangedFile();
      if (ranged) {
        onRanged();
        return openParts();
      }
    }
  }

  // The file that is loaded as it is wanted. Several files are loaded whole.
  async function rangedFile() {
    const [{ arrival }, ...others] = files;
    const branched = (await arrival?.branched) ?? null;
    if (!others.length) return branched;
    branched?.wantAll();
    return null;
  }

  const isLost = ({ coarse }) => broken ?? (coarse && workers.some(({ level }) => level !== null) ? null : lost);
  const rejectLost = () => {
    for (const task of waiting.filter(isLost)) task.reject(isLost(task));
    waiting = waiting.filter((task) => !isLost(task));
  };
  async function openCoarse() {
    if (await openLevel(workers[1], COARSE, await filesWith(({ bytes }) => bytes))) serve(workers[1], COARSE);
  }
  const coarse = count > 1 ? (arriving ? openArriving() : openCoarse()).catch(() => {}) : null;
  openAll()
    .catch((error) => (broken = error))
    .then(rejectLost);

  return {
    // The number of workers that have the whole volumes.
    get count() {
      return workers.filter(({ level }) => level === WHOLE).length;
    },
    // True while a file, or what is wanted of it, is still arriving, and if it did not arrive.
    get partial() {
      const isShort = ranged !== null && !lost && opened !== null && !ranged.suffices(opened);
      return isShort || (arriving && workers.every(({ level }) => level !== WHOLE));
    },
    get lost() {
      return lost !== null;
    },
    // The ranged file, or null.
    get ranged() {
      return ranged;
    },
    // True after end().
    get ended() {
      return ended;
    },
    // Resolves with the answer of worker.js. coarse: coarse levels of the volumes are enough.
    ask: (request, signal, coarse = false) =>
      new Promise((resolve, reject) => {
        const task = { request, signal, coarse };
        if (isLost(task)) return reject(isLost(task));
        task.done = new Promise((done) => {
          task.resolve = (answer) => (resolve(answer), done());
          task.reject = (error) => (reject(error), done());
        });
        waiting.push(task);
        for (const seat of workers) give(seat);
      }),
    // Ends the workers; what they were asked is cancelled.
    end() {
      ended = true;
      broken = aborted();
      for (const { reject } of waiting.splice(0)) reject(broken);
      for (const { worker, task } of workers) {
        worker.terminate();
        task?.reject(broken);
      }
    },
    // Bytes of WebAssembly memory of all workers.
    heap: () => workers.reduce((sum, { heap }) => sum + heap, 0),
  };
}
