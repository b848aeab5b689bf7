// The page is put together here: what is opened, which parts there are, and how they hear of each other.

import { api } from "./api.js";
import { homeCamera } from "./camera.js";
import { hashOf, patchOf } from "./link.js";
import { store } from "./store.js";
import { DEFAULT_VIEW } from "./view.js";
import { mountView3d } from "./view3d.js";
import { volumes } from "./volumes.js";

const $ = (id) => document.getElementById(id);

// For tests, and for the curious.
window.cvol = { store, volumes, api };

const stage = { canvas: $("canvas"), slices: $("stage-slices"), compare: $("stage-compare") };

async function mountPanels() {
  const panels = { transfer: "transfer", slices: "slices", compare: "compare", exports: "export" };
  for (const [module, name] of Object.entries(panels)) {
    try {
      const { mount } = await import(`./${module}.js`);
      mount($(`panel-${name}`), { store, api, volumes, stage });
    } catch {
      document.querySelector(`[data-section="${name}"]`).hidden = true;
    }
  }
}

const view3d = mountView3d($("canvas"), {
  shown: () => {},
  busy: () => {},
  failed: () => {},
  picked: () => {},
});
window.cvol.view3d = view3d;

function showLayout({ page }) {
  $("stage").dataset.layout = page.layout;
  $("stage-slices").hidden = page.layout !== "slices";
  $("stage-compare").hidden = page.layout !== "compare";
}

let linked = patchOf(location.hash);
let opened = null;

// The volume is first seen when it is ready: from its front, unless a link says from where.
function open() {
  const volume = volumes.current();
  if (volume?.state !== "ready" || opened === volume.id) return;
  opened = volume.id;
  const camera = homeCamera(volume, view3d.size.width, view3d.size.height);
  const first = { volume: volume.id, mirror: volume.mirrored === true, camera };
  store.set({ view: { ...first, ...(linked.view ?? {}), volume: volume.id } }, { undo: false });
  linked = {};
  view3d.refresh();
}

async function start() {
  await volumes.refresh();
  const wanted = linked.view?.volume;
  const first = volumes.get(wanted) ?? volumes.list()[0];
  store.set({ view: { ...DEFAULT_VIEW, volume: first?.id ?? null }, page: linked.page ?? {} }, { undo: false });
  open();
}

volumes.subscribe(open);
store.subscribe(showLayout);
let linkTimer = 0;
store.subscribe((state, previous, { live }) => {
  if (live || !opened) return;
  clearTimeout(linkTimer);
  linkTimer = setTimeout(() => history.replaceState(null, "", `#${hashOf(store.state)}`), 200);
});

mountPanels();
start();
