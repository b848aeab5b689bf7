// The choice of the volume.

import { make } from "./controls.js";
import { store } from "./store.js";
import { TITLE } from "./transport.js";
import { volumes } from "./volumes.js";

const states = { reading: "reading", compressing: "compressing", failed: "failed" };

export function mountChooser(box, choose) {
  const name = make("span", { class: "volume-name" });
  const list = make("select", { "aria-label": "Volume", onchange: () => choose(list.value) });
  box.append(name, list);

  return function update() {
    const current = volumes.current();
    // The Compare panel lists the copies that it made.
    const shown = volumes.list().filter((volume) => volume.parent === null || volume.id === store.state.view.volume);
    list.hidden = shown.length < 2;
    name.hidden = shown.length > 1;
    name.textContent = current?.name ?? "";
    document.title = TITLE || (current ? `${current.name} · cvol` : "cvol");
    const words = shown.map(({ id, name: text, state }) => [id, states[state] ? `${text} (${states[state]})` : text]);
    const key = JSON.stringify(words);
    if (list.dataset.key !== key) {
      list.dataset.key = key;
      list.replaceChildren(...words.map(([id, text]) => make("option", { value: id }, text)));
    }
    list.value = store.state.view.volume ?? "";
  };
}
