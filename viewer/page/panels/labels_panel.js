// The labels of a volume, with the colours of the picture.

import { element } from "../controls/panel_kit.js";
import { store } from "../state/store.js";
import { volumes } from "../state/volumes.js";

const css = (colour) => `rgb(${colour.map((c) => Math.round(255 * c)).join(" ")})`;

// A label of a list; `before`: what stands in front of its colour.
export function labelRow({ value, name, colour }, before = null) {
  const swatch = element("span", { class: "label-swatch" });
  swatch.style.background = css(colour); // the page's policy refuses style attributes
  const parts = [before, swatch, element("span", { class: "label-value" }, String(value)), name ?? ""];
  return element("li", {}, before ? element("label", {}, ...parts) : null, ...(before ? [] : parts));
}

// Puts the list after the other parts of the panel; hidden for volumes without labels.
export function mountLabels(panel) {
  const list = element("ul", { class: "label-list", tabindex: 0, "aria-label": "Labels" });
  const box = element("fieldset", { class: "panel-group", hidden: true }, element("legend", {}, "Labels"), list);
  let shown = null;
  panel.append(box);
  const show = () => {
    const labels = volumes.current()?.labels ?? null;
    if (labels === shown) return;
    shown = labels;
    box.hidden = !labels;
    list.replaceChildren(...(labels ?? []).map((label) => labelRow(label)));
  };
  volumes.subscribe(show);
  store.subscribe(show);
}
