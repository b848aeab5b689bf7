// A stream of pictures from the server to one canvas: one request in flight, and only the newest one waits. During
// motion the pictures are fast ones, as large as the target frame rate allows; REST_MS after the motion a still
// picture of full quality follows. If it takes long, a draft comes before it: a smaller still picture.

export const REST_MS = 80;
const TIMINGS_MAX = 2000;
const SIZE_MAX = 8192;
const MOTION_SIZE_MAX = 4096;
const SCALES = [1, 0.8, 0.64, 0.5, 0.4, 0.32, 0.25];
const SMALLEST = 0.4; // share of the page's pixels
const SETTLED = 12;
const OVERHEAD_MAX = 40; // ms: larger values are stalls of the browser
const LONG_MS = 3000; // of still pictures
const DRAFT_MS = 1000;
const DRAFT_MIN = 1 / 16; // share of the pixels
const UNKNOWN_MS = 1 / 1000; // for a pixel, until there was a still picture

// Times of each picture: {requested, shown, quality, width, height, server: {...}}, for tests and the status line.
export const timings = (window.cvolTimings = []);

// The number of directions of scattered light in motion.
const MOTION_SAMPLES = 12;

function inMotion(view) {
  if (!(view.light?.samples > MOTION_SAMPLES)) return view;
  return { ...view, light: { ...view.light, samples: MOTION_SAMPLES } };
}

// The size of pictures in motion (a share of the canvas pixels) and the time budget of the server, which chooses their
// quality. If pictures are coarse or late, it uses fewer pixels.
export function createPace() {
  let place = 2;
  let elapsed = 0; // of recent pictures, from request to canvas
  let overhead = 8; // the part of it outside rendering
  let settled = 0; // pictures since the size changed
  return {
    get scale() {
      return SCALES[place];
    },
    budget: (period) => Math.round(Math.min(period * 0.85, Math.max(8, period * 0.95 - overhead))),
    record(total, info, period, smallest) {
      if (settled < 2) elapsed = total;
      else elapsed += 0.2 * (total - elapsed);
      overhead += 0.15 * (Math.min(OVERHEAD_MAX, Math.max(1, total - (info.render_ms ?? 0))) - overhead);
      if (++settled < SETTLED) return;
      const coarse = info.level > 0;
      let next = place;
      if (elapsed > period * (coarse ? 1.1 : 1.5) || (coarse && SCALES[place] > 0.5)) next++;
      else if (elapsed < period * 0.6 && !coarse) next--;
      next = Math.max(0, Math.min(SCALES.length - 1, next));
      if (next === place || (next > place && SCALES[next] < smallest)) return;
      settled = 0;
      place = next;
    },
  };
}

// The quality of the next still picture, and the share of its pixels: a draft first if all pixels take LONG_MS.
export function createRest() {
  let perPixel = UNKNOWN_MS;
  return {
    next: (pixels) => (perPixel * pixels > LONG_MS ? "draft" : "still"),
    share: (pixels) => Math.max(DRAFT_MIN, DRAFT_MS / (perPixel * pixels)),
    record: (ms, pixels) => (perPixel = ms / pixels),
  };
}

const sized = (length, scale, limit) => Math.max(1, Math.min(limit, Math.round(length * scale)));

// picture(request, {signal}) requests a picture: api.frame or api.difference. request() returns the current view,
// or null if there is none: {view, width, height (screen pixels), ratio (screen pixels per page pixel),
// build(width, height) (the view for a request), motion: {fps, size}, more: further fields}. show(bitmap, frame)
// gets each picture and owns the bitmap; frame is {view, timing, blob}. fail(error, quality) gets errors; busy(yes)
// reports whether a request is in flight.
export function createFrames({ picture, request, show, fail, busy = () => {} }) {
  const viewer = [...crypto.getRandomValues(new Uint8Array(9))].map((byte) => byte.toString(36)).join("");
  const pace = createPace();
  const rest = createRest();
  let sequence = 0;
  let shownSequence = 0;
  let flight = null; // the current request, not superseded
  let waiting = null; // the quality of the next request: "motion", "draft" or "still"
  let underway = 0; // requests whose pictures are not on the canvas yet
  let restTimer = 0;
  let ended = false;

  function nextRequest(quality) {
    const now = request();
    if (!now) return null;
    const moving = quality === "motion";
    const chosen = now.motion.size;
    const draft = quality === "draft" ? Math.sqrt(rest.share(now.width * now.height)) : 1;
    const scale = !moving ? draft : chosen === "auto" ? pace.scale : chosen;
    const limit = moving ? MOTION_SIZE_MAX : SIZE_MAX;
    const body = {
      view: now.build(sized(now.width, scale, limit), sized(now.height, scale, limit)),
      quality: moving ? "motion" : "still",
      format: moving ? "jpeg" : "png",
      viewer,
      sequence: ++sequence,
      ...now.more,
    };
    const period = 1000 / now.motion.fps;
    if (moving) {
      body.budget_ms = pace.budget(period);
      body.view = inMotion(body.view);
    }
    return {
      body,
      period,
      quality,
      view: now.view,
      smallest: SMALLEST / (now.ratio ?? 1),
      stop: new AbortController(),
    };
  }

  async function send() {
    const quality = waiting;
    waiting = null;
    const mine = nextRequest(quality);
    if (!mine) return;
    flight?.stop.abort(); // the newer request cancels it on the server; do not wait for its answer
    flight = mine;
    underway++;
    busy(true);
    const requested = performance.now();
    const landed = () => {
      if (flight !== mine) return false;
      flight = null;
      if (quality === "draft" && !ended) waiting ??= "still";
      if (waiting) send();
      else busy(false);
      return true;
    };
    try {
      const { blob, info } = await picture(mine.body, { signal: mine.stop.signal });
      const received = performance.now();
      const { width, height } = mine.body.view;
      if (quality !== "motion") rest.record(received - requested, width * height);
      landed();
      const bitmap = await createImageBitmap(blob);
      if (ended || mine.body.sequence < shownSequence) {
        bitmap.close();
        return;
      }
      shownSequence = mine.body.sequence;
      const shown = performance.now();
      const timing = { requested, received, shown, quality, width, height, server: info };
      timings.push(timing);
      if (timings.length > TIMINGS_MAX) timings.splice(0, timings.length - TIMINGS_MAX);
      if (quality === "motion") pace.record(shown - requested, info, mine.period, mine.smallest);
      show(bitmap, { view: mine.view, timing, blob });
    } catch (error) {
      const newest = landed();
      if (newest && !waiting && !ended) fail(error, quality);
    } finally {
      underway--;
    }
  }

  function want(quality) {
    waiting = quality;
    // A still picture may take long: motion does not wait for it, and the server cancels it.
    if (!flight || (flight.quality !== "motion" && quality === "motion")) send();
  }

  function wantStill() {
    const { width, height } = request() ?? {};
    want(width ? rest.next(width * height) : "still");
  }

  return {
    viewer,
    // True until the last picture that was asked for is on the canvas.
    get pending() {
      return restTimer !== 0 || waiting !== null || underway > 0;
    },
    // The view changes, as by a gesture: fast pictures first, then a still one.
    moved() {
      clearTimeout(restTimer);
      restTimer = setTimeout(() => ((restTimer = 0), wantStill()), REST_MS);
      want("motion");
    },
    // The view is final: only a still picture.
    still() {
      clearTimeout(restTimer);
      restTimer = 0;
      wantStill();
    },
    end() {
      ended = true;
      clearTimeout(restTimer);
      restTimer = 0;
      waiting = null;
    },
  };
}
