// A slider of the ratio; releasing it makes a copy with that ratio and shows its error.

import { button, element, field, logSlider, statusLine } from "../controls/panel_kit.js";
import { store } from "../state/store.js";
import { bytesText, ratioText } from "../state/units.js";

const WAIT_MS = 350; // after the last movement of the slider: keys move it step by step

/** Calls `chosen(id)` for each new copy, and with null when the copy is removed. */
export function createSmallerCopy({ api, volumes, viewer, chosen }) {
  const status = statusLine();
  const progress = element("progress", { max: 1, hidden: true, "aria-label": "Compressing" });
  const out = element("output", {});
  const ratio = logSlider(5, 500, { oninput: preview, onchange: later });
  const ratioField = field("Ratio", ratio.input, out);
  const drop = button("Remove the copy", remove, { hidden: true });
  const node = element(
    "fieldset",
    { class: "panel-group" },
    element("legend", {}, "Smaller copy"),
    ratioField.node,
    progress,
    status.node,
    element("div", { class: "buttons" }, drop),
  );
  let copy = null; // its id
  let reported = false; // its results were shown
  let asked = 0; // its ratio
  let timer = 0;

  const wanted = () => Number(ratio.get().toPrecision(2));

  function base() {
    const current = volumes.current();
    return volumes.get(current?.parent) || current;
  }

  function timeNow(from) {
    const current = volumes.current();
    return current === from ? store.state.view.time : (current?.time ?? 0);
  }

  function preview() {
    const { raw_bytes: raw } = base() || {};
    ratio.set(ratio.get(), `one ${wanted()}th`);
    out.value = `1/${wanted()}`;
    if (raw) status.say(`About ${bytesText(Math.round(raw / wanted()))} of ${bytesText(raw)}. Release the slider to make it.`);
  }

  function later() {
    preview();
    clearTimeout(timer);
    timer = setTimeout(ask, WAIT_MS);
  }

  async function ask() {
    const from = base();
    if (from?.state !== "ready") return;
    try {
      const begun = await api.copy(from.id, { ratio: wanted(), viewer, time: timeNow(from) });
      copy = begun.id;
      asked = wanted();
      reported = false;
      progress.hidden = false;
      progress.removeAttribute("value");
      status.say(`Compressing to 1/${wanted()}…`);
      chosen(copy);
      await volumes.refresh();
    } catch (error) {
      status.say(error.message, true);
    }
  }

  async function remove() {
    const id = copy;
    copy = null;
    chosen(null);
    try {
      await api.remove(id);
      status.say("");
      await volumes.refresh();
    } catch (error) {
      status.say(error.message, true);
    }
  }

  function follow() {
    const volume = copy && volumes.get(copy);
    drop.hidden = !volume;
    progress.hidden = !volume || volume.state === "ready" || volume.state === "failed";
    if (!volume) return;
    if (volume.doing?.fraction > 0) progress.value = volume.doing.fraction;
    if (volume.state === "failed") status.say(volume.error, true);
    if (volume.state !== "ready" || reported) return;
    reported = true;
    const parts = [
      ratioText(volume.ratio),
      bytesText(volume.compressed_bytes),
      volume.exact ? "exact" : volume.psnr_db !== null ? `PSNR ${volume.measured ? "" : "at least "}${volume.psnr_db.toFixed(1)} dB` : null,
      volume.max_error !== null && !volume.exact ? `largest error ${Number(volume.max_error.toPrecision(3))}` : null,
    ];
    const short = volume.ratio < 0.95 * asked ? " This is the smallest possible copy." : "";
    status.say(`${parts.filter(Boolean).join(" · ")}.${short}`);
  }

  volumes.subscribe(follow);
  ratio.set(60, "one 60th");
  out.value = "1/60";
  return {
    node,
    /** The id of the copy, which may not be in the list of volumes yet. */
    get id() {
      return copy;
    },
  };
}
