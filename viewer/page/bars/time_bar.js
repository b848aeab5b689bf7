// The bar below the picture of a series: play, the time, and how fast it plays. Volumes of one time have none.

import { make } from "../controls/controls.js";
import { store } from "../state/store.js";
import { spokenTime, valueText } from "../state/times.js";
import { volumes } from "../state/volumes.js";

const SPEEDS = [1, 2, 5, 10, 20];

const icon = (path) =>
  make("svg:svg", { viewBox: "0 0 20 20", "aria-hidden": "true" }, make("svg:path", { d: path, class: "filled" }));

const PLAY = "M6 4v12l10-6z";
const PAUSE = "M6 4h3v12H6zM11 4h3v12h-3z";

// Returns {update, playing(on), shown(view)}: call shown with the view of each picture.
export function mountTimeBar(bar, player) {
  const iconButton = (label, title, path, onclick, style = "") =>
    make("button", { type: "button", class: `icon ${style}`.trim(), title, "aria-label": label, onclick }, icon(path));
  const play = iconButton("Play", "Play or stop (space)", PLAY, () => player.toggle());
  const before = iconButton("Time before", "Time before (j)", "M6 4v12M15 4v12l-8-6z", () => player.move(-1), "step");
  const next = iconButton("Time after", "Time after (k)", "M14 4v12M5 4v12l8-6z", () => player.move(1), "step");
  const slider = make("input", {
    type: "range",
    min: 0,
    step: 1,
    "aria-label": "Time",
    oninput: () => player.show(Number(slider.value), true),
    onchange: () => player.show(Number(slider.value)),
  });
  const number = make("b", {});
  const count = make("span", { class: "time-count" });
  const value = make("span", { class: "time-value" });
  const text = make("span", { class: "time-text" }, number, count, value);
  const speed = make("select", {
    "aria-label": "Times per second",
    title: "Times per second",
    onchange: () => store.set({ page: { playing: Number(speed.value) } }, { undo: false }),
  });
  speed.append(...SPEEDS.map((times) => make("option", { value: times }, `${times} / s`)));
  bar.append(before, play, next, slider, text, speed);
  let measured = null; // the volume whose texts have their width

  // The texts keep their width while they change.
  function measure(volume) {
    if (measured === volume) return;
    measured = volume;
    const longest = (texts) => Math.max(...texts.map((part) => part.length));
    const last = volume.times - 1;
    number.style.minWidth = `${String(last).length}ch`;
    const values = volume.time_values ? [0, 1, last >> 1, last].map((time) => valueText(volume, time)) : [""];
    value.style.minWidth = `${longest(values)}ch`;
  }

  function update() {
    const volume = volumes.current();
    const there = volume?.state === "ready" && volume.times > 1;
    bar.hidden = !there;
    if (!there) return;
    const { time } = store.state.view;
    measure(volume);
    slider.max = volume.times - 1;
    slider.value = time;
    slider.setAttribute("aria-valuetext", spokenTime(volume, time));
    number.textContent = time;
    count.textContent = ` of ${volume.times - 1}`;
    value.textContent = valueText(volume, time);
    speed.value = store.state.page.playing;
  }

  store.subscribe((state, previous) => {
    if (state.view.time !== previous.view.time || state.view.volume !== previous.view.volume) update();
    if (state.page.playing !== previous.page.playing) update();
  });
  volumes.subscribe(update);
  return {
    update,
    playing(on) {
      play.setAttribute("aria-pressed", on);
      play.setAttribute("aria-label", on ? "Stop" : "Play");
      play.replaceChildren(icon(on ? PAUSE : PLAY));
    },
    shown: (view) => (bar.dataset.late = view.time !== store.state.view.time),
  };
}
