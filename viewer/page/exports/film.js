// Animations: a turn of the camera or the times of a series as a file, made by the server.

import { button, element, field, options, statusLine, stem } from "../controls/panel_kit.js";
import { bytesText } from "../state/units.js";
import { requestView } from "../state/view.js";

const POLL_MS = 400;
const ENDINGS = { png: "tar" };
const WORDS = { gif: "GIF", webp: "WebP", png: "PNG, numbered", mp4: "MP4" };

/** `size()` returns [width, height] of the panel. */
export function createFilm({ store, api, volumes, size }) {
  const status = statusLine();
  const number = (value, min, max, oninput) => element("input", { type: "number", value, min, max, step: 1, oninput });
  const overTime = element("input", { type: "checkbox", onchange: timesChosen });
  const timesCheck = element("label", { class: "check", hidden: true }, overTime, "One picture of each time");
  const frames = field("Pictures", number(72, 1, 3600, showSummary));
  const fps = field("Pictures per second", number(25, 1, 50, showSummary));
  const degrees = field("Degrees", element("input", { type: "number", value: 360, step: "any" }));
  const format = field("Format", element("select"));
  const progress = element("progress", { max: 1, value: 0, hidden: true, "aria-label": "Animation" });
  const start = button("Make the animation", make);
  const cancel = button("Cancel", stop, { hidden: true });
  const save = element("a", { class: "button", hidden: true }, "Save the animation");
  const length = element("p", { class: "hint" });
  const node = element(
    "fieldset",
    { class: "panel-group" },
    element("legend", {}, "Animation"),
    timesCheck,
    element("div", { class: "field-grid pairs" }, frames.node, fps.node, degrees.node, format.node),
    length,
    progress,
    status.node,
    element("div", { class: "buttons" }, start, cancel, save),
  );
  let running = null;

  let turn = { fps: 25, degrees: 360, frames: 72 }; // the settings of the kind that is not chosen
  let series = { fps: 10, degrees: 0 };

  const read = () => ({ fps: fps.input.value, degrees: degrees.input.value, frames: frames.input.value });

  function timesChosen() {
    const on = overTime.checked;
    if (on) turn = read();
    else series = read();
    const now = on ? { ...series, frames: volumes.current().times } : turn;
    fps.input.value = now.fps;
    degrees.input.value = now.degrees;
    frames.input.value = now.frames;
    frames.input.disabled = on;
    showSummary();
  }

  function showTimes() {
    const there = volumes.current()?.times > 1;
    timesCheck.hidden = !there;
    if (there || !overTime.checked) return;
    overTime.checked = false;
    timesChosen();
  }
  volumes.subscribe(showTimes);
  store.subscribe((state, previous) => state.view.volume !== previous.view.volume && showTimes());

  function showSummary() {
    const seconds = Number(frames.input.value) / Number(fps.input.value);
    length.textContent = Number.isFinite(seconds)
      ? `${Number(seconds.toPrecision(3))} seconds of ${size().join(" × ")} pixels, from the current camera.`
      : "";
  }

  function showRunning(yes) {
    progress.hidden = !yes;
    cancel.hidden = !yes;
    start.disabled = yes;
  }

  async function make() {
    save.hidden = true;
    if (running) await api.removeFilm(running).catch(() => {});
    running = null;
    try {
      const film = await api.film({
        view: requestView(store.state.view, ...size()),
        ...(overTime.checked ? { over_time: true } : { frames: Number(frames.input.value) }),
        fps: Number(fps.input.value),
        degrees: Number(degrees.input.value),
        format: format.input.value,
      });
      running = film.id;
      showRunning(true);
      status.say("Making the animation…");
      await follow(film.id, format.input.value);
    } catch (error) {
      showRunning(false);
      status.say(error.message, true);
    }
  }

  async function follow(id, kind) {
    while (running === id) {
      const film = await api.filmState(id);
      if (running !== id) return;
      progress.value = film.fraction;
      if (film.state === "failed") throw new Error(film.error);
      if (film.state === "done") {
        showRunning(false);
        status.say(`The animation is ready${film.bytes ? `: ${bytesText(film.bytes)}` : ""}.`);
        save.href = api.filmAddress(id);
        save.download = `${stem(volumes.current())}.${ENDINGS[kind] || kind}`;
        save.hidden = false;
        save.focus();
        return;
      }
      await new Promise((resolve) => setTimeout(resolve, POLL_MS));
    }
  }

  async function stop() {
    const id = running;
    running = null;
    showRunning(false);
    status.say("Cancelled.");
    start.focus();
    try {
      await api.removeFilm(id);
    } catch (error) {
      status.say(error.message, true);
    }
  }

  showSummary();
  return {
    node,
    showSummary,
    offer(formats) {
      options(
        format.input,
        formats.map((name) => [name, WORDS[name] || name.toUpperCase()]),
        formats.includes("webp") ? "webp" : formats[0],
      );
    },
  };
}
