// The clip panel: a box of samples, and a plane.

import { ball } from "../controls/ball.js";
import { diagonal, directions, unit } from "../state/camera.js";
import { bind, button, check, group, hint, make, slider, span } from "../controls/controls.js";
import { store } from "../state/store.js";
import { volumes } from "../state/volumes.js";

const UNCLIPPED = [null, null, null, null, null, null];

// The clip box, with null for faces that cut nothing; null if no face cuts.
export function tidyBox(box, dims) {
  const faces = box.map((face, i) => {
    if (face === null) return null;
    const last = dims[i >> 1] - 1;
    const rounded = Number(face.toFixed(1));
    return i % 2 ? (rounded >= last ? null : rounded) : rounded <= 0 ? null : rounded;
  });
  return faces.some((face) => face !== null) ? faces : null;
}

export const facesOf = (box, dims) => (box ?? UNCLIPPED).map((face, i) => face ?? (i % 2 ? dims[i >> 1] - 1 : 0));

// The planes with a change of the first one.
export const planePatch = (planes, plane) => ({ view: { clip: { planes: [plane, ...planes.slice(1)] } } });

export function mountClip(panel) {
  const dims = () => (volumes.current()?.state === "ready" ? volumes.current().dims : [2, 2, 2]);
  const plane = (state) => state.view.clip.planes[0];

  const sides = ["x", "y", "z"].map((name, axis) =>
    span({
      label: name,
      limits: () => ({ max: Math.max(1, dims()[axis] - 1) }),
      read: (state) => facesOf(state.view.clip.box, dims()).slice(2 * axis, 2 * axis + 2),
      write(ends) {
        const faces = facesOf(store.state.view.clip.box, dims());
        faces.splice(2 * axis, 2, ...ends);
        return { view: { clip: { box: tidyBox(faces, dims()) } } };
      },
    }),
  );

  const facing = () => directions(store.state.view.camera, false).eye.map((part) => Number((-part || 0).toFixed(3)));
  const set = (change) => {
    const { planes } = store.state.view.clip;
    store.set(planePatch(planes, change(planes[0] ?? [...facing(), 0])));
  };

  const cut = check({
    label: "Clip plane",
    read: (state) => state.view.clip.planes.length > 0,
    write: (on) => ({ view: { clip: { planes: on ? [[...facing(), 0]] : [] } } }),
  });
  const normal = ball({
    label: "Normal of the clip plane",
    read: (state) => (plane(state) ? plane(state).slice(0, 3) : null),
    write: (n) => planePatch(store.state.view.clip.planes, [...n, plane(store.state)?.[3] ?? 0]),
    enabled: (state) => plane(state) !== undefined,
  });
  const has = (state) => plane(state) !== undefined;
  const turns = group(make("div"), [
    cut,
    group(make("div", { class: "buttons" }), [
      button({
        label: "Face me",
        title: "Turn the plane to the eye",
        enabled: has,
        press: () => set((p) => [...facing(), p[3]]),
      }),
      button({
        label: "Flip",
        title: "Keep the other side",
        enabled: has,
        press: () => set((p) => p.map((part) => -part || 0)),
      }),
    ]),
    hint("The spot marks the side that stays visible."),
  ]);

  return bind(panel, [
    hint("Drag the handles in the picture or the ends of these sliders."),
    ...sides,
    group(make("div", { class: "buttons" }), [
      button({
        label: "Whole volume",
        press: () => store.set({ view: { clip: { box: null } } }),
        enabled: (state) => state.view.clip.box !== null,
      }),
    ]),
    group(make("div", { class: "ball-row" }), [normal, turns]),
    slider({
      label: "Distance",
      title: "Distance of the plane from the centre of the volume",
      initial: 0,
      limits() {
        const volume = volumes.current();
        const half = volume?.state === "ready" ? Number((diagonal(volume) / 2).toPrecision(3)) : 1;
        return { min: -half, max: half, step: half / 200 };
      },
      read: (state) => plane(state)?.[3] ?? 0,
      write(d) {
        const now = plane(store.state);
        return planePatch(store.state.view.clip.planes, [
          ...unit(now.slice(0, 3)).map((n) => Number(n.toFixed(3))),
          Number(d.toPrecision(4)),
        ]);
      },
      enabled: has,
    }),
  ]);
}
