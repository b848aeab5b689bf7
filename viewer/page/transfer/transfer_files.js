// Transfer functions as files: saves cvol's JSON; the server reads this and ParaView's JSON. Files have the values that
// samples mean.

import { button, download, element, stem } from "../controls/panel_kit.js";

const LARGEST = 1 << 20; // bytes of a request

/** A row of buttons. points() returns the points to save; loaded(points) gets the points that were read. */
export function transferFiles({ api, volumes, status, points, loaded }) {
  const input = element("input", {
    type: "file",
    accept: ".json,application/json",
    class: "unseen",
    onchange: load,
    tabindex: -1,
    "aria-label": "Transfer function file",
  });

  function save() {
    const volume = volumes.current();
    const value = (sample) => (volume?.value_scale || 1) * sample + (volume?.value_offset || 0);
    const values = points().map(([sample, ...colour]) => [value(sample), ...colour]);
    // Values may be far from 0 compared with their distances.
    const rounded = values.map((point) => point.map((x, k) => Number(x.toPrecision(k ? 8 : 15))));
    const lines = rounded.map((point) => `    ${JSON.stringify(point)}`);
    const name = `${stem(volume)}-transfer.json`;
    download(`{\n  "points": [\n${lines.join(",\n")}\n  ]\n}\n`, name);
    status.say(`Saved ${name}, for cvol render --transfer.`);
  }

  async function load() {
    const [file] = input.files;
    const volume = volumes.current();
    input.value = "";
    if (!file || !volume) return;
    try {
      if (file.size > LARGEST) throw new Error(`${file.name} has ${file.size} bytes, must have at most ${LARGEST}.`);
      const { points: read } = await api.readTransfer(volume.id, await file.text());
      loaded(read);
      status.say(`${file.name}: ${read.length} points.`);
    } catch (error) {
      status.say(error.message, true);
    }
  }

  return element(
    "div",
    { class: "buttons" },
    button("Save", save, { title: "A JSON file for cvol render --transfer" }),
    button("Load…", () => input.click(), { title: "A JSON file of cvol or ParaView" }),
    input,
  );
}
