// The dialog of keys and gestures.

import { make } from "../controls/controls.js";
import { KEYS } from "./keyboard.js";

const GESTURES = [
  ["Turn", "drag"],
  ["Move", "shift or right drag, two fingers"],
  ["Zoom", "wheel, pinch"],
  ["Roll", "alt drag, two fingers"],
  ["Show value and position", "click"],
  ["Measure", "choose a tool, click; in slices drag, too"],
  ["Centre this point", "double click"],
  ["Reset the view", "double click on the background"],
  ["Reset a slider", "double click on it"],
];

function list(rows, keys) {
  const out = make("dl");
  for (const [what, how] of rows) {
    const shown = keys ? how.flatMap((key, i) => (i ? [" ", make("kbd", {}, key)] : [make("kbd", {}, key)])) : [how];
    out.append(make("dt", {}, ...shown), make("dd", {}, what));
  }
  return out;
}

export function mountHelp(dialog, about) {
  const close = make(
    "button",
    { type: "button", class: "icon", "aria-label": "Close", onclick: () => dialog.close() },
    "✕",
  );
  const version = make("p", { class: "hint" });
  dialog.append(
    make("div", { class: "top" }, make("h2", { id: "help-title" }, "Keys and gestures"), close),
    make(
      "div",
      { class: "columns" },
      make("div", {}, make("h3", {}, "Keys"), list(KEYS, true)),
      make("div", {}, make("h3", {}, "Mouse and touch, on the picture"), list(GESTURES, false)),
    ),
    version,
  );
  dialog.addEventListener("click", (event) => event.target === dialog && dialog.close());
  return () => {
    if (dialog.open) return dialog.close();
    const { program, threads } = about() ?? {};
    version.textContent = program
      ? `cvol ${program}, ${threads} ${threads === 1 ? "thread" : "threads"}. The link in the address bar restores this view.`
      : "";
    dialog.showModal();
  };
}
