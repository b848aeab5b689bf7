// The export panel: a picture of any size, an animation, the command, a link.

import { createCommandLine } from "./command_line.js";
import { createFilm } from "./film.js";
import { linkOf } from "../state/link.js";
import { button, copyFrom, download, element, field, options, statusLine, stem } from "../controls/panel_kit.js";
import { LINK_LASTS } from "../state/transport.js";
import { bytesText } from "../state/units.js";
import { requestView } from "../state/view.js";

const SIZE_MAX = 8192;
const SIZES = {
  screen: "Screen size",
  double: "Twice the screen size",
  "1024x1024": "1024 × 1024",
  "1920x1080": "1920 × 1080",
  "2048x2048": "2048 × 2048",
  "3840x2160": "3840 × 2160",
  "7680x4320": "7680 × 4320",
  own: "Own",
};

export function mount(panel, { store, api, volumes, stage }) {
  // ---- size -------------------------------------------------------------------------------------------

  const number = (value) =>
    element("input", {
      type: "number",
      min: 1,
      max: SIZE_MAX,
      step: 1,
      value,
      oninput: typeSize,
      onchange: checkSize,
    });
  const choice = field("Size", element("select", { onchange: chooseSize }));
  const width = field("Width", number(1024));
  const height = field("Height", number(1024));
  choice.node.classList.add("whole");
  options(choice.input, Object.entries(SIZES), "screen");

  const size = () => [width.input, height.input].map((input) => Math.round(Number(input.value)) || 1);

  function chooseSize() {
    const chosen = choice.input.value;
    if (chosen === "own") return;
    const scale = (devicePixelRatio || 1) * (chosen === "double" ? 2 : 1);
    const screen = [stage.canvas.clientWidth, stage.canvas.clientHeight].map((n) =>
      Math.min(SIZE_MAX, Math.max(1, Math.round(n * scale))),
    );
    [width.input.value, height.input.value] = chosen.includes("x") ? chosen.split("x") : screen;
    sizeChanged();
  }

  function typeSize() {
    choice.input.value = "own";
    sizeChanged();
  }

  function checkSize() {
    for (const { input } of [width, height])
      input.value = Math.min(SIZE_MAX, Math.max(1, Math.round(Number(input.value)) || 1));
    sizeChanged();
  }

  function sizeChanged() {
    film.showSummary();
    command.later();
  }

  // ---- picture ----------------------------------------------------------------------------------------

  const pictureStatus = statusLine();
  const pictureButton = button("Save PNG", savePicture);
  const picture = element(
    "fieldset",
    { class: "panel-group" },
    element("legend", {}, "Picture"),
    element("div", { class: "field-grid pairs" }, choice.node, width.node, height.node),
    element("div", { class: "buttons" }, pictureButton),
    pictureStatus.node,
  );
  let pictures = 0;

  const timeName = () => (volumes.current()?.times > 1 ? `-time-${store.state.view.time}` : "");

  async function savePicture() {
    const [w, h] = size();
    pictureButton.disabled = true;
    pictureStatus.say(`Rendering ${w} × ${h}…`);
    try {
      const { blob: drawn } = await api.frame({
        view: requestView(store.state.view, w, h),
        quality: "still",
        format: "png",
        viewer: `export-${Math.random().toString(36).slice(2)}`,
        sequence: ++pictures,
      });
      const blob = await api.fileOf(drawn);
      const name = `${stem(volumes.current())}${timeName()}-${w}x${h}.png`;
      download(blob, name);
      pictureStatus.say(`${name}: ${bytesText(blob.size)}.`);
    } catch (error) {
      pictureStatus.say(error.message, true);
    }
    pictureButton.disabled = false;
  }

  // ---- animation, command, link -----------------------------------------------------------------------

  const film = createFilm({ store, api, volumes, size });
  const command = createCommandLine({ store, api, volumes, size });

  const linkStatus = statusLine();
  const linkText = field(
    LINK_LASTS ? "Opens this view again" : "Opens this view again while the viewer runs",
    element("input", { type: "text", readonly: true }),
  );
  const link = element(
    "fieldset",
    { class: "panel-group" },
    element("legend", {}, "Link"),
    linkText.node,
    element(
      "div",
      { class: "buttons" },
      button("Copy", () => {
        linkText.input.value = linkOf(store.state);
        copyFrom(linkText.input, linkStatus, "Link");
      }),
    ),
    linkStatus.node,
  );

  panel.classList.add("panel-export");
  panel.append(picture, film.node, command.node, link);

  let sized = false;
  function show() {
    panel.inert = volumes.current()?.state !== "ready";
    linkText.input.value = linkOf(store.state);
    if (!sized && stage.canvas.clientWidth > 1) {
      sized = true;
      chooseSize();
    }
  }
  new ResizeObserver(() => {
    if (["screen", "double"].includes(choice.input.value)) chooseSize();
    show();
  }).observe(stage.canvas);
  store.subscribe((state, previous, { live } = {}) => !live && show());
  api.about().then(
    ({ film_formats: formats }) => {
      film.node.hidden = !formats.length;
      film.offer(formats);
    },
    () => film.offer(["png"]),
  );
  volumes.subscribe(show);
  show();
}
