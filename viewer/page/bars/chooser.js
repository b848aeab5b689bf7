// The choice of the volume.

import { make } from "../controls/controls.js";
import { store } from "../state/store.js";
import { TITLE } from "../state/transport.js";
import { volumes } from "../state/volumes.js";

const states = { reading: "reading", compressing: "compressing", failed: "failed" };

export function mountChooser(box, choose) {
  const name = make("span", { class: "volume-name" });
  const list = make("select", { "aria-label": "Volume", onchange: () => choose(list.value) });
  box.append(name, list);

  return function update() {
    const current = volumes.current();
    // The Compare panel lists the copies that it made.
    // All channels of a file are one choice.
    const shown = volumes
      .list()
      .filter(({ parent, id }) => parent === null || id === store.state.view.volume)
      .filter(({ channel, parent, id }) => !channel || parent !== null || channel.first === id);
    const nameOf = ({ channel, parent, path, name: own }) => (channel && parent === null ? path.split("/").at(-1) : own);
    list.hidden = shown.length < 2;
    name.hidden = shown.length > 1;
    name.textContent = current ? nameOf(current) : "";
    document.title = TITLE || (current ? `${nameOf(current)} · cvol` : "cvol");
    const words = shown.map((volume) => {
      const { id, state } = volume;
      return [id, states[state] ? `${nameOf(volume)} (${states[state]})` : nameOf(volume)];
    });
    const key = JSON.stringify(words);
    if (list.dataset.key !== key) {
      list.dataset.key = key;
      list.replaceChildren(...words.map(([id, text]) => make("option", { value: id }, text)));
    }
    list.value = (current?.parent === null && current.channel?.first) || (store.state.view.volume ?? "");
  };
}
