// Shown instead of a picture: progress of a volume, its failure, or a viewer that does not answer.

import { make } from "../controls/controls.js";

export function mountNotice(box, again) {
  let shown = "";

  function show(key, ...children) {
    if (key === shown) return;
    shown = key;
    box.hidden = !key;
    box.replaceChildren(...children);
  }

  const bar = make("progress", { max: 1 });
  const bars = make("p", {}, bar);
  const percent = make("span", { class: "quiet" });
  return {
    clear: () => show(""),
    working({ state, name, doing }) {
      const what = doing?.what ?? state;
      const title = `${what[0].toUpperCase()}${what.slice(1)} ${name ?? ""}`;
      show(`working ${title}`, make("p", {}, title), bars, percent);
      bar.setAttribute("aria-label", title);
      if (doing && Number.isFinite(doing.fraction)) {
        bar.value = doing.fraction;
        percent.textContent = `${Math.round(100 * doing.fraction)} %`;
      } else {
        bar.removeAttribute("value");
        percent.textContent = "";
      }
    },
    empty: (sentence) => show(`empty ${sentence}`, make("p", {}, sentence)),
    failed: (sentence) => show(`failed ${sentence}`, make("p", {}, sentence)),
    gone: () =>
      show(
        "gone",
        make("p", {}, "The viewer does not answer any more."),
        make(
          "p",
          { class: "quiet" },
          "The picture stays. If cvol view has ended, start it again and open the URL that it prints.",
        ),
        make("p", {}, make("button", { type: "button", class: "button", onclick: again }, "Try again")),
      ),
  };
}
