// The status line: time and quality of the picture, size and error of the volume.

import { make } from "../controls/controls.js";
import { bytesText, lengthText, ratioText } from "../state/units.js";
import { volumes } from "../state/volumes.js";

const ms = (value) => (value === undefined ? "?" : value < 9.95 ? value.toFixed(1) : value.toFixed(0));

const BUSY_MS = 200;

export function mountStatus(footer) {
  let timer = 0;
  const dot = make("span", { class: "dot", "data-state": "idle" });
  const time = make("b");
  const quality = make("span");
  const size = make("span");
  const error = make("span");
  const kind = make("span", { class: "wide" });
  const frame = make("span", { class: "frame" }, dot, time, quality);
  footer.append(frame, size, error, kind);

  function describe(volume) {
    if (volume?.state !== "ready") {
      size.replaceChildren();
      error.replaceChildren();
      kind.textContent = volume?.path ?? "";
      return;
    }
    const { raw_bytes, compressed_bytes, ratio, psnr_db, exact, max_error, measured, dims, spacing, unit, type } = volume;
    size.replaceChildren(
      make("b", {}, bytesText(compressed_bytes)),
      ` of ${bytesText(raw_bytes)}, ${ratioText(ratio)}`,
    );
    size.title = `Compressed: ${compressed_bytes} bytes; the samples: ${raw_bytes} bytes`;
    if (psnr_db !== null) error.replaceChildren(measured ? "PSNR " : "PSNR at least ", make("b", {}, `${psnr_db.toFixed(1)} dB`));
    else error.replaceChildren(exact ? "exact" : "error unknown");
    if (volume.whole_level) error.replaceChildren(make("b", {}, "ends early"), `: level ${volume.whole_level} is complete`);
    else if (volume.residual_missing) error.replaceChildren(make("b", {}, "ends early"), ": the residual is missing, not exact");
    if (volume.arrived_level) error.replaceChildren(make("b", {}, "loading"), `: level ${volume.arrived_level} is there`);
    error.title = max_error === null ? "" : `Largest error of a sample: ${max_error}`;
    kind.textContent =
      `${dims.join(" × ")} ${type}, ${spacing.map((s) => Number(s.toPrecision(4))).join(" × ")} ${unit}`.trim();
    kind.title = dims.map((n, a) => lengthText((n - 1) * spacing[a], unit)).join(" by ");
  }

  volumes.subscribe(() => describe(volumes.current()));
  return {
    describe,
    shown({ timing }) {
      const { server } = timing;
      time.textContent = `${ms(timing.shown - timing.requested)} ms`;
      quality.textContent = ` ${server.quality ?? timing.quality}, ${timing.width} × ${timing.height}`;
      frame.title = [
        `Rendering ${ms(server.render_ms)} ms, encoding ${ms(server.encode_ms)} ms, waiting ${ms(server.queue_ms)} ms`,
        `From request to screen ${ms(timing.shown - timing.requested)} ms`,
        `${bytesText(server.bytes ?? 0)}, ${server.threads ?? "?"} ${server.threads === 1 ? "thread" : "threads"}`,
      ].join("\n");
    },
    // Show busy only if it lasts.
    state(name) {
      clearTimeout(timer);
      if (name === "busy") timer = setTimeout(() => (dot.dataset.state = name), BUSY_MS);
      else if (dot.dataset.state !== name) dot.dataset.state = name;
    },
  };
}
