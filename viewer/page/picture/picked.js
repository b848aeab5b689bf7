// Value and position of the last click, in a corner of the picture.

import { make } from "../controls/controls.js";
import { meaningOf, shortNumber } from "../state/meaning.js";
import { overlayTexts } from "../state/overlays.js";
import { store } from "../state/store.js";
import { volumes } from "../state/volumes.js";

export function mountPicked(box) {
  return {
    hide: () => (box.hidden = true),
    show(answer) {
      box.hidden = !answer.hit;
      if (!answer.hit) return;
      const volume = volumes.current();
      const { to, unit, digits } = meaningOf(volume);
      const value = `${shortNumber(to(answer.value), digits + 1)} ${unit}`.trimEnd();
      const sample = answer.sample.map((s) => s.toFixed(0)).join(", ");
      const world = answer.world.map((w) => Number(w.toFixed(2))).join(", ");
      box.replaceChildren(
        make("b", {}, answer.label ? `${value} ${answer.label}` : value),
        make("span", {}, ` sample ${sample} at ${world} ${volume?.unit ?? ""}`.trimEnd()),
        ...overlayTexts(answer.overlays, store.state.view, volume).map((text) => make("span", { class: "of-overlay" }, text)),
      );
    },
  };
}
