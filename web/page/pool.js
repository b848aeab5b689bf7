// Workers, each with a WebAssembly instance. The first one opens the volumes. Meanwhile the second one opens their
// coarse levels, and answers requests for which these are enough. Then the memory of the first instance goes from
// worker to worker, and all have the volumes. Each works on one request at a time; requests that wait are dropped if
// they are cancelled.

const COARSE = 2; // level: 1/4 of the samples along each axis
const WHOLE = 0;

const failure = (sentence, status) => Object.assign(new Error(sentence), { status });
export const aborted = () => new DOMException("The request was cancelled.", "AbortError");

// start(): makes a Worker. opening: what worker.js opens, and the compiled module.
export function createPool(count, start, { module, ...opening }) {
  let waiting = []; // {request, signal, coarse, resolve, reject}
  let broken = null; // the error of the volumes
  // level: of the volumes that it has; null: none. module: what it must compile to begin.
  const workers = Array.from({ length: count }, () => ({ worker: start(), task: null, heap: 0, level: null, module }));

  function nextFor({ level }) {
    waiting = waiting.filter(({ signal, reject }) => !signal?.aborted || reject(aborted()));
    const place = waiting.findIndex(({ coarse }) => level === WHOLE || (coarse && level === COARSE));
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
    if (data.failure === undefined) task?.resolve({ ...data, coarse: seat.level === COARSE });
    else task?.reject(failure(`The page cannot draw: ${data.failure}`, 500));
    give(seat);
  }

  // Asks a worker that is idle, or will be soon.
  async function order(seat, request, given) {
    while (seat.task) await seat.task.done.catch(() => {});
    const task = { request: { ...request, begin: seat.module }, given };
    seat.module = null;
    task.done = new Promise((resolve, reject) => Object.assign(task, { resolve, reject }));
    give(seat, task);
    return task.done;
  }

  const [first, ...others] = workers;
  for (const seat of workers) {
    seat.worker.onmessage = ({ data }) => take(seat, data);
    seat.worker.onerror = (event) => take(seat, { failure: event.message || "a worker does not start" });
  }

  async function openAll() {
    let { memory } = await order(first, { open: { ...opening, level: WHOLE }, lend: count > 1 });
    first.level = WHOLE;
    give(first);
    for (const seat of others) {
      try {
        ({ memory } = await order(seat, { load: memory }, [memory]));
      } catch {
        break; // without memory for so many instances
      }
      seat.level = WHOLE;
      give(seat);
    }
  }

  async function openCoarse(seat) {
    const { fit } = await order(seat, { open: { ...opening, level: COARSE } });
    if (fit) seat.level = COARSE;
    give(seat);
  }

  openAll().catch((error) => {
    broken = error;
    for (const { reject } of waiting.splice(0)) reject(error);
  });
  if (count > 1) openCoarse(others[0]).catch(() => {});

  return {
    // The number of workers that have the whole volumes.
    get count() {
      return workers.filter(({ level }) => level === WHOLE).length;
    },
    // Resolves with the answer of worker.js. coarse: coarse levels of the volumes are enough.
    ask: (request, signal, coarse = false) =>
      new Promise((resolve, reject) => {
        if (broken) return reject(broken);
        const task = { request, signal, coarse };
        task.done = new Promise((done) => {
          task.resolve = (answer) => (resolve(answer), done());
          task.reject = (error) => (reject(error), done());
        });
        waiting.push(task);
        for (const seat of workers) give(seat);
      }),
    // Ends the workers; what they were asked is cancelled.
    end() {
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
