// The `cvol render` command that reproduces the still picture, and the files that it reads.

import { button, copyFrom, download, element, field, statusLine } from "../controls/panel_kit.js";
import { requestView } from "../state/view.js";

const WAIT_MS = 400; // after the last change

export function createCommandLine({ store, api, volumes, size }) {
  const status = statusLine();
  const area = element("textarea", { readonly: true, rows: 4, spellcheck: "false", class: "command-text" });
  const text = field("Command for this picture", area);
  const files = element("div", { class: "buttons" });
  const copy = button("Copy", () => copyFrom(area, status, "Command"));
  const node = element(
    "fieldset",
    { class: "panel-group" },
    element("legend", {}, "Command"),
    text.node,
    element("div", { class: "buttons" }, copy, files),
    status.node,
  );
  let timer = 0;
  let asked = 0;
  let stale = true;

  async function ask() {
    if (!area.checkVisibility() || volumes.current()?.state !== "ready") return;
    const mine = ++asked;
    stale = false;
    try {
      const answer = await api.command(requestView(store.state.view, ...size()));
      if (mine !== asked) return;
      area.value = answer.command;
      files.replaceChildren(
        ...Object.entries(answer.files || {}).map(([name, content]) =>
          button(`Save ${name}`, () => download(`${JSON.stringify(content, null, 1)}\n`, name)),
        ),
      );
      status.say("");
    } catch (error) {
      if (mine !== asked) return;
      area.value = "";
      files.replaceChildren();
      status.say(error.message, true);
    }
  }

  function later() {
    stale = true;
    clearTimeout(timer);
    timer = setTimeout(ask, WAIT_MS);
  }

  new IntersectionObserver(() => stale && ask()).observe(area);
  store.subscribe((state, previous, { live } = {}) => !live && later());
  volumes.subscribe(later);
  return { node, later };
}
