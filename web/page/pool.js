// Workers, each with a WebAssembly instance that has all volumes. Each works on one request at a time; requests that
// wait are dropped if they are cancelled.

const failure = (sentence, status) => Object.assign(new Error(sentence), { status });
export const aborted = () => new DOMException("The request was cancelled.", "AbortError");

// start(): makes a Worker. opening: what worker.js opens. Resolves when the first worker has read the volumes.
export function createPool(count, start, opening) {
  const waiting = []; // {request, signal, resolve, reject}
  const workers = Array.from({ length: count }, () => ({ worker: start(), task: null, heap: 0 }));
  let ids = 0;

  function give(seat) {
    let task = null;
    while (!task && waiting.length) {
      task = waiting.shift();
      if (!task.signal?.aborted) continue;
      task.reject(aborted());
      task = null;
    }
    seat.task = task;
    if (task) seat.worker.postMessage({ id: ++ids, ...task.request });
  }

  function take(seat, data) {
    const { task } = seat;
    if (data.heap) seat.heap = data.heap;
    give(seat);
    if (data.failure !== undefined) task.reject(failure(`The page cannot draw: ${data.failure}`, 500));
    else task.resolve(data);
  }

  for (const seat of workers) {
    seat.task = { request: {}, resolve: () => {}, reject: (error) => (seat.broken = error) };
    seat.worker.onmessage = ({ data }) => take(seat, data);
    seat.worker.onerror = (event) => take(seat, { failure: event.message || "a worker does not start" });
    seat.worker.postMessage({ id: 0, open: opening });
  }

  return {
    count,
    // Resolves with the answer of worker.js.
    ask: (request, signal) =>
      new Promise((resolve, reject) => {
        waiting.push({ request, signal, resolve, reject });
        const idle = workers.find(({ task }) => task === null);
        if (idle) give(idle);
      }),
    // Bytes of WebAssembly memory of all workers.
    heap: () => workers.reduce((sum, { heap }) => sum + heap, 0),
  };
}
