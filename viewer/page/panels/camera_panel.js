// The camera panel.

import { fittingZoom, tidy } from "../state/camera.js";
import { bind, button, check, choice, group, make, slider } from "../controls/controls.js";
import { store } from "../state/store.js";
import { volumes } from "../state/volumes.js";

export const VIEW_NAMES = ["front", "back", "left", "right", "top", "bottom"];
export const FOV = 40;

export function mountCamera(panel, { view3d, turntable, named }) {
  const camera = (name) => ({
    read: (state) => state.view.camera[name],
    write: (value) => ({ view: { camera: { [name]: value } } }),
  });
  const views = VIEW_NAMES.map((name, index) =>
    button({
      label: name[0].toUpperCase() + name.slice(1),
      title: `From the ${name} (${index + 1})`,
      press: () => named(name),
    }),
  );
  const fit = () => {
    const volume = volumes.current();
    if (volume?.state !== "ready") return;
    const now = store.state.view.camera;
    const zoom = fittingZoom(now, volume, view3d.size.width, view3d.size.height);
    view3d.fly(tidy({ ...now, zoom, look_at: [0, 0, 0] }));
  };
  bind(panel, [
    group(make("div", { class: "buttons thirds", role: "group", "aria-label": "Views" }), views),
    choice({
      label: "Projection",
      style: "two",
      options: [
        ["parallel", "Parallel"],
        ["perspective", "Perspective"],
      ],
      read: (state) => (state.view.camera.fov > 0 ? "perspective" : "parallel"),
      write: (name) => ({ view: { camera: { fov: name === "parallel" ? 0 : FOV } } }),
    }),
    slider({
      label: "Field of view",
      title: "Vertical field of view, in degrees",
      min: 1,
      max: 150,
      step: 1,
      initial: FOV,
      read: (state) => state.view.camera.fov || FOV,
      write: (fov) => ({ view: { camera: { fov } } }),
      enabled: (state) => state.view.camera.fov > 0,
    }),
    slider({ label: "Azimuth", min: -180, max: 180, step: 1, ...camera("azimuth") }),
    slider({ label: "Elevation", min: -90, max: 90, step: 1, ...camera("elevation"), initial: 0 }),
    slider({ label: "Roll", min: -180, max: 180, step: 1, ...camera("roll"), initial: 0 }),
    slider({ label: "Zoom", min: 0.1, max: 50, log: true, ...camera("zoom"), initial: 1 }),
    group(make("div", { class: "buttons even" }), [
      button({ label: "Fit", title: "Show the whole volume, centred", press: fit }),
      button({ label: "Reset", title: "The initial view of the volume (r)", press: view3d.home }),
      button({
        label: "Turntable",
        title: "Turn the volume continuously (t)",
        press: turntable.toggle,
        pressed: () => turntable.on,
      }),
    ]),
    slider({
      label: "Speed, °/s",
      title: "Degrees per second",
      min: 4,
      max: 120,
      step: 1,
      initial: 24,
      undo: false,
      read: (state) => state.page.turning,
      write: (turning) => ({ page: { turning } }),
    }),
    check({
      label: "Orientation cube and scale bar",
      undo: false,
      read: (state) => state.page.marks,
      write: (marks) => ({ page: { marks } }),
    }),
  ]);
}
