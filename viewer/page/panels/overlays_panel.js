// The overlays panel: for each overlay its name and if it is shown, its strength, and its colours or its labels.

import { api } from "../state/api.js";
import { diagonal } from "../state/camera.js";
import { button, element, field, newestOnly, options } from "../controls/panel_kit.js";
import { slider } from "../controls/controls.js";
import { labelRow } from "./labels_panel.js";
import { meaningOf, rounded, shortNumber } from "../state/meaning.js";
import { labelChange, overlayPatch, overlayTransfers, showsLabel } from "../state/overlays.js";
import { store } from "../state/store.js";
import { presetWord } from "../transfer/transfer_presets.js";
import { volumes } from "../state/volumes.js";

const hasDepth = ({ view }) => view.mode === "composite" || view.mode === "iso";

function gradient(points) {
  const [low, high] = [points[0][0], points.at(-1)[0]];
  const stops = points.map(([value, ...rgb]) => {
    const colour = rgb.slice(0, 3).map((c) => Math.round(255 * c));
    return `rgb(${colour.join(" ")}) ${high > low ? ((100 * (value - low)) / (high - low)).toFixed(2) : 50}%`;
  });
  return `linear-gradient(to right, ${stops.length > 1 ? stops.join(", ") : [stops, stops].join(", ")})`;
}

// ---- colours of values --------------------------------------------------------------------------------

function colours(i, { values }, named) {
  const set = (change) => store.set(overlayPatch(store.state.view, i, change));
  const means = meaningOf(values);
  const list = element("select", { onchange: () => set({ transfer: list.value }) });
  const bar = element("div", { class: "overlay-bar" });
  const ends = ["From", "To"].map((word) =>
    field(word, element("input", { type: "number", step: "any", onchange: typeWindow })),
  );
  const fit = button("Fit", () => set({ window: null }), { title: "Fit the window to the values of the overlay" });
  const trouble = element("p", { class: "panel-status bad", role: "status" });
  let shown = [0, 1];
  let key = "";

  function typeWindow() {
    const [low, high] = ends.map(({ input }) => means.from(Number(input.value))).sort((a, b) => a - b);
    if (ends.every(({ input }) => input.value !== "") && low < high) set({ window: [low, high] });
    else showEnds();
  }
  function showEnds() {
    const meant = shown.map(means.to).sort((a, b) => a - b);
    ends.forEach(({ input }, k) => {
      if (document.activeElement !== input) input.value = rounded(meant[k], means.digits + 1);
    });
    bar.title = meant.map((value) => shortNumber(value, means.digits)).join(" to ");
  }
  const ask = newestOnly(async (id, { transfer, window }) => {
    try {
      const { points } = await api.overlayTransfer(id, i, transfer, window);
      shown = [points[0][0], points.at(-1)[0]];
      bar.style.background = gradient(points);
      trouble.textContent = "";
      showEnds();
    } catch (error) {
      key = "";
      trouble.textContent = error.message;
    }
  });
  named.then((names) => {
    const own = names.includes(values.transfer) ? [] : [[values.transfer, values.transfer.split("/").at(-1)]];
    options(list, [...own, ...names.map((name) => [name, presetWord(name)])], store.state.view.overlays?.[i]?.transfer);
  });
  const row = field("Colours", list);
  return {
    node: element(
      "div",
      { class: "overlay-colours" },
      row.node,
      bar,
      element("div", { class: "overlay-window" }, ...ends.map(({ node }) => node), fit),
      trouble,
    ),
    update(overlay) {
      list.value = overlay.transfer;
      fit.disabled = overlay.window === null;
      const id = volumes.current()?.id;
      const wanted = JSON.stringify([id, overlay.transfer, overlay.window]);
      if (wanted === key) return;
      key = wanted;
      ask(id, overlay);
    },
  };
}

// ---- labels -------------------------------------------------------------------------------------------

function labels(i, { labels: all }) {
  const values = all.map(({ value }) => value);
  const now = () => store.state.view.overlays[i];
  const set = (change) => store.set(overlayPatch(store.state.view, i, change));
  const boxes = all.map(({ value, name }) => {
    const box = element("input", {
      type: "checkbox",
      "aria-label": `Show ${name ?? `label ${value}`}`,
      onchange: () => set(labelChange(now(), values, value, box.checked)),
    });
    return box;
  });
  const count = element("span", { class: "overlay-count" });
  const every = button("All", () => set({ labels: null }));
  const none = button("None", () => set({ labels: [] }));
  return {
    node: element(
      "div",
      { class: "overlay-labels" },
      element("div", { class: "overlay-label-head" }, count, every, none),
      element("ul", { class: "label-list", "aria-label": "Labels of the overlay" }, ...all.map((label, k) => labelRow(label, boxes[k]))),
    ),
    update(overlay) {
      boxes.forEach((box, k) => (box.checked = showsLabel(overlay, values[k])));
      const shown = overlay.labels?.length ?? all.length;
      count.textContent = `${shown} of ${all.length} labels`;
      every.disabled = shown === all.length;
      none.disabled = shown === 0;
    },
  };
}

// ---- the panel ----------------------------------------------------------------------------------------

function item(i, description, named) {
  const patch = (change) => overlayPatch(store.state.view, i, change);
  const now = (state) => state.view.overlays?.[i];
  const on = element("input", { type: "checkbox", onchange: () => store.set(patch({ on: on.checked })) });
  const sliders = [
    slider({
      label: "Opacity",
      title: "How strongly the overlay covers the volume",
      min: 0,
      max: 1,
      step: 0.01,
      initial: description.opacity,
      read: (state) => now(state)?.opacity ?? 1,
      write: (opacity) => patch({ opacity }),
      enabled: (state) => now(state)?.on,
    }),
    slider({
      label: "Depth",
      title: "How deep behind the visible surface the overlay shines through, in the unit of the volume",
      initial: description.depth,
      limits() {
        const volume = volumes.current();
        const most = volume?.state === "ready" ? Number(diagonal(volume).toPrecision(3)) : 1;
        return { min: 0, max: Math.max(most, description.depth), step: most / 200 };
      },
      read: (state) => now(state)?.depth ?? description.depth,
      write: (depth) => patch({ depth: Number(depth.toPrecision(4)) }),
      enabled: (state) => now(state)?.on && hasDepth(state),
    }),
  ];
  const look = description.values ? colours(i, description, named) : labels(i, description);
  const body = element("div", { class: "overlay-body" }, ...sliders.map((one) => one.element), look.node);
  const node = element(
    "fieldset",
    { class: "overlay-item" },
    element("legend", { class: "unseen" }, `Overlay ${description.name}`),
    element("label", { class: "check overlay-name", title: description.path }, on, element("span", {}, description.name)),
    body,
  );
  return {
    node,
    update(state) {
      const overlay = now(state);
      if (!overlay) return;
      on.checked = overlay.on;
      node.classList.toggle("off", !overlay.on);
      sliders.forEach((one) => one.update(state));
      look.update(overlay);
    },
  };
}

// Fills the panel of a section, which is hidden for volumes without overlays.
export function mountOverlays(panel) {
  const section = panel.closest("details");
  const named = api.about().then(overlayTransfers, () => []);
  let described = "";
  let items = [];
  const show = () => {
    const volume = volumes.current();
    const overlays = (volume?.state === "ready" && volume.overlays) || [];
    const wanted = JSON.stringify(overlays);
    section.hidden = !overlays.length;
    if (wanted !== described) {
      described = wanted;
      items = overlays.map((overlay, i) => item(i, overlay, named));
      panel.replaceChildren(...items.map(({ node }) => node));
    }
    if (section.open && !section.hidden) items.forEach((one) => one.update(store.state));
  };
  section.addEventListener("toggle", show);
  volumes.subscribe(show);
  store.subscribe((state, previous) => {
    if (state.view !== previous.view) show();
  });
  show();
}
