// Comparison of a volume with another one or with a smaller copy: side by side, or the difference of the pictures.

import { element, field, logSlider, options, statusLine } from "../controls/panel_kit.js";
import { comparedTime, timeIn, valueText } from "../state/times.js";
import { bytesText, ratioText } from "../state/units.js";
import { COMPARE } from "../state/panel_state.js";
import { createSecondView } from "./second_view.js";
import { createSmallerCopy } from "./smaller_copy.js";

export function mount(panel, { store, api, volumes, stage, view3d }) {
  store.set({ page: { compare: { ...COMPARE, ...store.state.page.compare } } }, { undo: false });
  const compare = () => store.state.page.compare;
  const set = (patch, how) => store.set({ page: patch }, { undo: false, ...how });
  const status = statusLine();

  // ---- elements on the stage --------------------------------------------------------------------------

  const label = element("p", { class: "second-label" });
  const notice = element("p", { class: "second-notice", role: "status" });
  let failure = "";
  const second = createSecondView(stage.compare, {
    hand: (view3d || window.cvol?.view3d)?.hand,
    shown: showFigures,
    failed(sentence) {
      failure = sentence || "";
      show();
    },
  });
  stage.compare.append(label, notice);

  // ---- elements in the panel --------------------------------------------------------------------------

  const choices = { off: "Off", side: "Side by side", difference: "Difference" };
  const radios = Object.entries(choices).map(([value, text]) =>
    element(
      "label",
      {},
      element("input", { type: "radio", name: "compare-mode", value, onchange: () => choose(value) }),
      text,
    ),
  );
  const other = field(
    "With",
    element("select", { onchange: () => set({ compare: { other: other.input.value || null } }) }),
  );
  const time = field(
    "Time",
    element("input", { type: "number", min: 0, step: 1, onchange: () => chooseTime(Number(time.input.value)) }),
  );
  const gain = logSlider(1, 100, { oninput: () => amplify(true), onchange: () => amplify(false) });
  const gainOut = element("output", {});
  const gainField = field("Gain", gain.input, gainOut);
  const smaller = createSmallerCopy({ api, volumes, viewer: second.viewer, chosen: copyChosen });
  panel.classList.add("panel-compare");
  panel.append(
    element("div", { class: "choice", role: "radiogroup", "aria-label": "Comparing" }, ...radios),
    other.node,
    time.node,
    gainField.node,
    status.node,
    smaller.node,
  );

  function choose(mode) {
    if (mode === "off") return set({ layout: "single" });
    const chosen = isThere(compare().other) ? compare().other : likely();
    set({ layout: "compare", compare: { mode, other: chosen } });
    if (!chosen) status.say("Choose a ratio below to make a smaller copy.");
  }

  function chooseTime(wanted) {
    set({ compare: { time: timeIn(volumes.current(), Math.max(0, Math.round(wanted) || 0)) } });
  }

  function copyChosen(id) {
    set(id ? { layout: "compare", compare: { other: id } } : { layout: "single", compare: { other: null } });
  }

  function amplify(live) {
    set({ compare: { gain: Number(gain.get().toPrecision(2)) } }, { live });
  }

  // ---- updates ----------------------------------------------------------------------------------------

  const others = () => volumes.list().filter(({ id }) => id !== store.state.view.volume);

  /** 1 if the volume can be compared with itself at another time. */
  const hasTimes = () => volumes.current()?.times > 1;

  const isThere = (id) =>
    id !== null && (id === smaller.id || (hasTimes() && id === store.state.view.volume) || others().some((volume) => volume.id === id));

  /** The first choice for a comparison: the original of this copy, or a copy of this volume. */
  function likely() {
    const current = volumes.current();
    const kin = others().find(({ id, parent }) => id === current?.parent || parent === current?.id);
    return (kin || others()[0] || (hasTimes() ? current : null))?.id ?? null;
  }

  function nameOf(volume) {
    if (volume.state === "failed") return `${volume.name}: failed`;
    if (volume.state !== "ready") return `${volume.name}: ${volume.doing?.what || volume.state}`;
    return `${volume.name}, ${ratioText(volume.ratio)}, ${bytesText(volume.compressed_bytes)}`;
  }

  function comparable() {
    const all = others().map((volume) => [volume.id, nameOf(volume)]);
    if (hasTimes()) all.push([store.state.view.volume, "Another time of this volume"]);
    return all.length ? all : [["", "no other volume"]];
  }

  /** "time 3, 6 s" of the second picture; "": it has no times. */
  function timeText(volume) {
    if (!(volume.times > 1)) return "";
    const at = comparedTime(compare(), volumes.current(), volume, store.state.view.time);
    return [`time ${at}`, valueText(volume, at)].filter(Boolean).join(", ");
  }

  function showFigures({ server }) {
    if (server.psnr_db === undefined) return;
    const parts = [
      server.exact ? "the pictures are equal" : `PSNR of the pictures ${decibels(server.psnr_db)}`,
      server.psnr_foreground_db !== undefined && `foreground ${decibels(server.psnr_foreground_db)}`,
      server.ssim !== undefined && `SSIM ${server.ssim.toFixed(4)}`,
    ];
    const text = parts.filter(Boolean).join(" · ");
    status.say(text);
    label.textContent = `Difference × ${compare().gain} · ${text}`;
  }

  const decibels = (value) => (value === null || value > 200 ? "no difference" : `${value.toFixed(1)} dB`);

  function show() {
    const { mode, other: id, gain: times } = compare();
    const on = store.state.page.layout === "compare";
    for (const radio of radios) radio.firstChild.checked = radio.firstChild.value === (on ? mode : "off");
    options(
      other.input,
      comparable(),
      id ?? "",
    );
    other.input.disabled = comparable()[0][0] === "";
    time.node.hidden = !hasTimes() || id !== store.state.view.volume;
    if (document.activeElement !== time.input) time.input.value = timeIn(volumes.current(), compare().time);
    time.input.max = (volumes.current()?.times ?? 1) - 1;
    if (on && !isThere(id) && likely()) return set({ compare: { other: likely() } });
    gainField.node.hidden = !on || mode !== "difference";
    gain.set(times, `${times} times`);
    gainOut.value = `× ${times}`;
    const volume = volumes.get(id);
    const facts = volume?.state === "ready" && [
      volume.name,
      timeText(volume),
      ratioText(volume.ratio),
      bytesText(volume.compressed_bytes),
      volume.exact ? "exact" : volume.psnr_db !== null && `PSNR ${volume.measured ? "" : "≥ "}${volume.psnr_db.toFixed(1)} dB`,
    ];
    if (mode === "side" || !volume) {
      label.textContent = facts ? facts.filter(Boolean).join(" · ") : "";
      if (volume && on) status.say("");
    }
    if (on) showNotice(id, volume);
  }

  function showNotice(id, volume) {
    const working = volume ? volume.state !== "ready" && volume.state !== "failed" : id !== null && id === smaller.id;
    second.canvas.hidden = !volume && !working;
    second.canvas.classList.toggle("stale", working);
    if (working) notice.textContent = `Compressing… ${Math.round(100 * (volume?.doing?.fraction || 0))} %`;
    else if (!volume) notice.textContent = "There is no other volume: make a smaller copy.";
    else notice.textContent = volume.error || failure;
  }

  api.about().then(
    ({ limits }) => (smaller.node.hidden = !limits.copies),
    () => {},
  );
  volumes.subscribe(show);
  store.subscribe((state, previous) => {
    if (
      state.page.compare !== previous.page.compare ||
      state.page.layout !== previous.page.layout ||
      state.view.volume !== previous.view.volume ||
      state.view.time !== previous.view.time
    )
      show();
  });
  show();
}
