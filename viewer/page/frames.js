// A stream of pictures from the server to one place of the page: one request in flight, and of those that wait only
// the newest. While something moves pictures are quick ones, as large as they come at the pace aimed for; REST_MS
// after it stopped, a still one of full quality takes their place.

export const REST_MS = 80;
const TIMINGS_MAX = 2000;
const SIZE_MAX = 8192;
const MOTION_SIZE_MAX = 4096;
const SCALES = [1, 0.8, 0.64, 0.5, 0.4, 0.32, 0.25];

// What each picture took: {requested, shown, quality, width, height, server: {...}}, for tests and the status line.
export const timings = (window.cvolTimings = []);

// How large pictures in motion are (a part of the canvas' pixels) and what the server may take for one.
export function createPace() {
  let place = 3;
  let elapsed = 0; // of recent pictures, from request to canvas
  let overhead = 8; // of that, what was not spent rendering
  let settled = 0; // pictures since the size changed
  return {
    get scale() {
      return SCALES[place];
    },
    budget: (period) => Math.round(Math.min(period * 0.8, Math.max(4, period * 0.92 - overhead))),
    record(total, info, period) {
      const weight = settled < 3 ? 0.6 : 0.2;
      elapsed = elapsed ? elapsed + weight * (total - elapsed) : total;
      overhead += 0.2 * (Math.max(1, total - (info.render_ms ?? 0)) - overhead);
      if (++settled < 6) return;
      const coarse = info.level > 0;
      let next = place;
      if (elapsed > period || (coarse && place < 3)) next = Math.min(SCALES.length - 1, place + 1);
      else if (elapsed < period * 0.6 && !coarse) next = Math.max(0, place - 1);
      if (next !== place) settled = 0;
      place = next;
    },
  };
}

const sized = (length, scale, limit) => Math.max(1, Math.min(limit, Math.round(length * scale)));

// show(bitmap, frame) gets each picture (and owns the bitmap); fail(error) a sentence; busy(true or false) whether
// something is on its way. request(): {view, width, height, motion: {fps, size}} as it is now, in the screen's pixels,
// or null where there is nothing to show. picture(request) asks the server: api.frame, or api.difference.
export function createFrames({ picture, request, show, fail, busy = () => {} }) {
  const viewer = [...crypto.getRandomValues(new Uint8Array(9))].map((byte) => byte.toString(36)).join("");
  const pace = createPace();
  let sequence = 0;
  let shownSequence = 0;
  let flight = null; // what is asked for and not superseded
  let waiting = null; // the quality to be asked for next
  let restTimer = 0;
  let ended = false;

  function nextRequest(quality) {
    const now = request();
    if (!now) return null;
    const moving = quality === "motion";
    const chosen = now.motion.size;
    const scale = !moving ? 1 : chosen === "auto" ? pace.scale : chosen;
    const limit = moving ? MOTION_SIZE_MAX : SIZE_MAX;
    const body = {
      view: now.build(sized(now.width, scale, limit), sized(now.height, scale, limit)),
      quality,
      format: moving ? "jpeg" : "png",
      viewer,
      sequence: ++sequence,
      ...now.more,
    };
    const period = 1000 / now.motion.fps;
    if (moving) body.budget_ms = pace.budget(period);
    return { body, period, quality, view: now.view };
  }

  async function send() {
    const quality = waiting;
    waiting = null;
    const mine = nextRequest(quality);
    if (!mine) return;
    flight = mine;
    busy(true);
    const requested = performance.now();
    const landed = () => {
      if (flight !== mine) return false;
      flight = null;
      if (waiting) send();
      else busy(false);
      return true;
    };
    try {
      const { blob, info } = await picture(mine.body);
      const received = performance.now();
      landed();
      const bitmap = await createImageBitmap(blob);
      if (ended || mine.body.sequence < shownSequence) {
        bitmap.close();
        return;
      }
      shownSequence = mine.body.sequence;
      const shown = performance.now();
      const { width, height } = mine.body.view;
      const timing = { requested, received, shown, quality, width, height, server: info };
      timings.push(timing);
      if (timings.length > TIMINGS_MAX) timings.splice(0, timings.length - TIMINGS_MAX);
      if (quality === "motion") pace.record(shown - requested, info, mine.period);
      show(bitmap, { view: mine.view, timing, blob });
    } catch (error) {
      const newest = landed();
      if (newest && !waiting && !ended) fail(error, quality);
    }
  }

  function want(quality) {
    waiting = quality;
    // A still picture may take long: what moves again does not wait for it. The server cancels it.
    if (!flight || (flight.quality === "still" && quality === "motion")) send();
  }

  return {
    viewer,
    // Something moved, or changed.
    moved() {
      clearTimeout(restTimer);
      restTimer = setTimeout(() => want("still"), REST_MS);
      want("motion");
    },
    // It is as it should be: nothing in between.
    still() {
      clearTimeout(restTimer);
      want("still");
    },
    end() {
      ended = true;
      clearTimeout(restTimer);
      waiting = null;
    },
  };
}
