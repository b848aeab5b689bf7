// A picture in strips: the rows of a frame, drawn by several workers, and the quality of frames in motion.

const RUNGS = ["full", "object order", "soft", "level 1", "level 2", "level 3"];
const FIRST = 4;
const GROWTH = 3; // as in viewer/service/pace.c
const ROOM = 0.85;
const SHARE = 0.3;
const AGEING = 0.97;
const STRIP_ROWS = 96; // of still pictures: between strips a newer request can cancel them

// The rung of the next frame in motion, by the times of earlier ones: viewer/service/pace.c for a page.
export function createRungs() {
  let kind = "";
  let rung = FIRST;
  let ms = [];
  let tried = [];
  return {
    choose({ volume, width, height, mode, light }, budget) {
      const now = [volume, width, height, mode, light?.on, light?.samples].join();
      if (now !== kind) [kind, rung, ms, tried] = [now, FIRST, [], []];
      while (rung < RUNGS.length - 1 && ms[rung] > budget) rung++;
      if (rung > 0 && ms[rung] > 0 && (ms[rung - 1] ?? GROWTH * ms[rung]) <= ROOM * budget) rung--;
      for (let finer = 0; finer < rung; finer++) if (ms[finer]) ms[finer] *= AGEING;
      return rung;
    },
    add(of, time) {
      if (!tried[of]) tried[of] = true;
      else ms[of] = ms[of] < time ? (1 - SHARE) * ms[of] + SHARE * time : time;
    },
  };
}

// [[first, count], ...]: `count` of them, or one where a picture cannot be drawn in strips.
export function stripsOf({ view: { height, camera }, quality }, workers) {
  const count = camera.fov > 0 ? 1 : quality === "still" ? Math.max(workers, Math.ceil(height / STRIP_ROWS)) : workers;
  const strips = Math.min(count, height);
  const edge = (k) => Math.round((k * height) / strips);
  return Array.from({ length: strips }, (_, k) => [edge(k), edge(k + 1) - edge(k)]);
}

// Draws a frame. ask(request, signal) resolves with the answer of a worker. {blob: pixels, info}
export async function drawStrips(request, { ask, workers, rungs, signal }) {
  const { budget_ms: budget, ...still } = request;
  const { view } = request;
  const rung = request.quality === "motion" ? rungs.choose(view, budget ?? 20) : 0;
  const body = request.quality === "motion" ? { ...still, quality: RUNGS[rung] } : still;
  const strips = stripsOf(request, workers);
  const begin = performance.now();
  const pixels = new Uint8ClampedArray(4 * view.width * view.height);
  let frame = {};
  let empty = true;
  await Promise.all(
    strips.map(async (rows) => {
      const asked = strips.length > 1 ? { ...body, rows } : body;
      const answer = await ask(asked, signal);
      pixels.set(new Uint8Array(answer.bytes), 4 * view.width * rows[0]);
      frame = JSON.parse(answer.frame);
      empty &&= frame.empty === true;
    }),
  );
  const render = performance.now() - begin;
  if (request.quality === "motion") rungs.add(rung, render);
  const figures = { queue_ms: 0, render_ms: render, bytes: pixels.length, threads: workers };
  const info = { ...frame, empty, sequence: request.sequence ?? 0, ...figures };
  return { blob: new ImageData(pixels, view.width, view.height), info };
}
