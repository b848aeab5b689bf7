// The list of channels of a file: each is shown or not, has a colour, and can be chosen for its settings.

import { channelName, chosenChannel } from "../state/channels.js";
import { hexOf, rgbOf } from "../transfer/colour_maps.js";
import { element } from "../controls/panel_kit.js";
import { store } from "../state/store.js";
import { volumes } from "../state/volumes.js";

// Puts the list into a panel; hidden for volumes of one channel. choose(id) is called when a channel is chosen.
export function mountChannels(panel, choose) {
  const list = element("ul", { class: "channel-list" });
  const hint = element("p", { class: "hint" }, "Colours and opacity below are those of the chosen channel.");
  const box = element("fieldset", { class: "panel-group", hidden: true }, element("legend", {}, "Channels"), list, hint);
  panel.prepend(box);
  let rows = [];

  function change(volume, patch, how) {
    const channels = store.state.view.channels.map((channel) =>
      channel.volume === volume ? { ...channel, ...patch } : channel,
    );
    store.set({ view: { channels } }, how);
  }

  function row({ volume }) {
    const name = channelName(volumes.get(volume));
    const on = element("input", {
      type: "checkbox",
      "aria-label": `Show ${name}`,
      onchange: () => change(volume, { on: on.checked }),
    });
    const colour = element("input", {
      type: "color",
      "aria-label": `Colour of ${name}`,
      oninput: () => change(volume, { colour: rgbOf(colour.value) }, { live: true }),
      onchange: () => change(volume, { colour: rgbOf(colour.value) }),
    });
    const chosen = element("input", {
      type: "radio",
      name: "channel",
      value: volume,
      onchange: () => {
        choose(volume);
        store.set({ view: chosenChannel(store.state.view, volume) });
      },
    });
    const label = element("label", { class: "channel-name" }, chosen, name);
    return { volume, on, colour, chosen, node: element("li", {}, on, colour, label) };
  }

  function show() {
    const { channels, volume } = store.state.view;
    box.hidden = !channels;
    if (!channels) return;
    if (rows.map((one) => one.volume).join() !== channels.map((one) => one.volume).join()) {
      rows = channels.map(row);
      list.replaceChildren(...rows.map(({ node }) => node));
    }
    const shown = channels.filter(({ on }) => on).length;
    rows.forEach((one, i) => {
      one.on.checked = channels[i].on;
      one.on.disabled = channels[i].on && shown === 1; // one channel is always shown
      if (document.activeElement !== one.colour) one.colour.value = hexOf(channels[i].colour);
      one.chosen.checked = one.volume === volume;
    });
  }

  store.subscribe((state, previous) => {
    if (state.view.channels !== previous.view.channels || state.view.volume !== previous.view.volume) show();
  });
  show();
}
