// Builds the page: volumes, panels, and the events between them.

import { api } from "./state/api.js";
import { homeCamera } from "./state/camera.js";
import { channelsOf, sameChannels } from "./state/channels.js";
import { DEFAULT_VIEW } from "./state/default_view.js";
import { mountChannels } from "./panels/channels_panel.js";
import { joined } from "./state/bookmarks.js";
import { mountBookmarks } from "./bookmarks/bookmarks_panel.js";
import { FOV, mountCamera, VIEW_NAMES } from "./panels/camera_panel.js";
import { mountChooser } from "./bars/chooser.js";
import { mountClip } from "./panels/clip_panel.js";
import { mountCube } from "./picture/cube.js";
import { mountHelp } from "./input/help.js";
import { joinedMeasures, KINDS, rootOf } from "./state/measures.js";
import { listenToKeys } from "./input/keyboard.js";
import { mountLabels } from "./panels/labels_panel.js";
import { mountLight } from "./panels/light_panel.js";
import { hashOf, patchOf } from "./state/link.js";
import { modeOf, MODES, mountLook, setMode } from "./panels/look_panel.js";
import { mountNotice } from "./picture/notice.js";
import { mountOverlay } from "./picture/overlay.js";
import "./state/panel_state.js";
import { fittingOverlays, overlaysOf, overlayTransfers } from "./state/overlays.js";
import { mountOverlays } from "./panels/overlays_panel.js";
import { mountPicked } from "./picture/picked.js";
import { createPlayer } from "./picture/player.js";
import { mountQuality } from "./panels/quality_panel.js";
import { mountStatus } from "./bars/status.js";
import { merge, store } from "./state/store.js";
import { applyTheme, toggleTheme } from "./bars/theme.js";
import { mountTimeBar } from "./bars/time_bar.js";
import { spokenTime, timeIn } from "./state/times.js";
import { onFigures } from "./measure/shown.js";
import { onAdded, onChanged, START } from "./state/transport.js";
import { tool } from "./measure/tool.js";
import { createTurntable } from "./picture/turntable.js";
import { same } from "./state/view.js";
import { mountView3d } from "./picture/view3d.js";
import { volumes } from "./state/volumes.js";

const $ = (id) => document.getElementById(id);
const RETRY_MS = 2000;
const LINK_MS = 200;
const SECTION_SEEN = 160; // pixels of a section that must be visible

applyTheme();

let about = null;
let linked = patchOf(location.hash || START); // the state in the URL, until a volume is shown
let opened = null; // the volume that is shown
let reached = true; // the viewer program answers
const announce = (sentence) => ($("announce").textContent = sentence);

// ---- the picture and its overlays ---------------------------------------------------------------------

const status = mountStatus($("status"));
const notice = mountNotice($("notice"), retry);
const picked = mountPicked($("picked"));
let seesNothing = false; // every pixel of the still picture is background
let drawMarks = () => {};
let drawing = 0;
const drawSoon = () => (drawing ||= requestAnimationFrame(() => ((drawing = 0), drawMarks())));

const turntable = createTurntable((on) => {
  $("turn").setAttribute("aria-pressed", on);
  store.set({}, { live: on });
});

const player = createPlayer((on) => {
  timeBar.playing(on);
  announce(on ? "Playing" : spokenTime(volumes.current(), store.state.view.time));
});
const timeBar = mountTimeBar($("time"), player);

const view3d = mountView3d($("canvas"), {
  shown(frame, again) {
    drawSoon();
    if (again) return;
    status.shown(frame);
    if (frame.timing.quality === "still") {
      seesNothing = frame.timing.server.empty === true;
      showState();
    }
    timeBar.shown(frame.view);
    player.next(frame.view);
    turntable.next();
  },
  busy: (yes) => reached && status.state(yes ? "busy" : "idle"),
  failed(sentence, code) {
    if (sentence === null) return showState();
    player.stop();
    if (code !== 0 && volumes.current()?.state === "ready") notice.failed(sentence);
    if (code === 503) retryTimer = setTimeout(retry, RETRY_MS); // the program is ending
  },
  picked(answer) {
    picked.show(answer);
    if (answer.hit) tool.place(answer.sample);
  },
  touched: turntable.stop,
});
window.cvol = { store, volumes, api, view3d }; // for tests and for the console

function named(name) {
  const camera = volumes.current()?.views?.[name];
  if (!camera) return;
  turntable.stop();
  view3d.fly({ ...store.state.view.camera, ...camera });
  announce(`From the ${name}`);
}

const drawOverlay = mountOverlay($("overlay"), $("scale"), view3d);
const drawCube = mountCube($("cube"), named);
drawMarks = () => {
  drawOverlay();
  drawCube();
};

tool.subscribe(() => {
  document.body.toggleAttribute("data-tool", tool.kind !== null);
  drawSoon();
});
onFigures(drawSoon);

// Scrolls the panel, and nothing else.
function showSection(name) {
  const panel = $("panel-sections");
  const [top, box] = [document.querySelector(`[data-section="${name}"]`).getBoundingClientRect().top, panel.getBoundingClientRect()];
  if (top < box.top || top > box.bottom - SECTION_SEEN) panel.scrollTop += top - box.top;
}

// Measuring tools show their section, with the figures.
function chooseTool(kind) {
  if (volumes.current()?.state !== "ready") return;
  tool.choose(kind);
  if (tool.kind) {
    store.set({ page: { open: { measure: true } } }, { undo: false });
    showSection("measure");
  }
  announce(tool.kind ? `${KINDS[kind].name}: place ${KINDS[kind].how}` : "No measuring tool");
}

function reasonOfEmpty(volume) {
  if (!volume.has_values) return "The picture is empty: no sample has a value.";
  return "The picture is empty: colours and opacity, clip or camera show no sample. Reset all settings (Look) shows the volume again.";
}

function showState() {
  const volume = volumes.current();
  const ready = volume?.state === "ready";
  $("panel-sections").inert = !ready;
  // The picture of another volume must not show.
  $("stage-3d").dataset.empty = !ready && view3d.frame?.view.volume !== volume?.id;
  if (!reached) return notice.gone();
  if (ready && seesNothing) return notice.empty(reasonOfEmpty(volume));
  if (!volume || ready) return notice.clear();
  if (volume.state === "failed") notice.failed(volume.error ?? `cannot read ${volume.name}`);
  else notice.working(volume);
}

// ---- panels -------------------------------------------------------------------------------------------

const sections = [...document.querySelectorAll(".section")];
const refreshers = [
  mountLook($("panel-look"), { first: allAsAtFirst }),
  mountLight($("panel-light")),
  mountClip($("panel-clip")),
];
mountLabels($("panel-look"));
mountChannels($("panel-transfer"), (id) => (opened = id));
mountOverlays($("panel-overlays"));
mountCamera($("panel-camera"), { view3d, turntable, named });
mountQuality($("panel-quality"));
const bookmarks = mountBookmarks($("panel-bookmarks"), { show: showBookmark });

async function mountOthers() {
  const others = {
    "transfer/transfer": "transfer",
    "slices/slices": "slices",
    "measure/measure": "measure",
    "compare/compare": "compare",
    "exports/exports": "export",
  };
  const stage = { canvas: $("canvas"), slices: $("stage-slices"), compare: $("stage-compare") };
  for (const [module, name] of Object.entries(others)) {
    try {
      const { mount } = await import(`./${module}.js`);
      mount($(`panel-${name}`), { store, api, volumes, stage, view3d });
    } catch (error) {
      console.warn(`${module}.js: ${error.message}`);
      document.querySelector(`[data-section="${name}"]`).hidden = true;
    }
  }
}

for (const section of sections) {
  section.addEventListener("toggle", () => {
    store.set({ page: { open: { [section.dataset.section]: section.open } } }, { undo: false });
  });
}

const drawerOpen = (open) => {
  document.body.dataset.drawer = open ? "open" : "closed";
  $("drawer").setAttribute("aria-expanded", open);
};
drawerOpen(false);
$("drawer").addEventListener("click", () => drawerOpen(document.body.dataset.drawer !== "open"));

function togglePanel() {
  const open = document.body.dataset.panel === "closed";
  document.body.dataset.panel = open ? "open" : "closed";
  $("panel-button").setAttribute("aria-expanded", open);
}

// ---- the bar and the keys -----------------------------------------------------------------------------

function stepBack() {
  turntable.stop();
  if (store.undo()) announce("Undone");
}
function stepForward() {
  turntable.stop();
  if (store.redo()) announce("Redone");
}
const reset = () => {
  turntable.stop();
  view3d.home();
};
const help = mountHelp($("help"), () => about);

$("undo").addEventListener("click", stepBack);
$("redo").addEventListener("click", stepForward);
$("reset").addEventListener("click", reset);
$("turn").addEventListener("click", turntable.toggle);
$("theme").addEventListener("click", () => announce(`${toggleTheme()} page`));
$("help-button").addEventListener("click", help);
$("panel-button").addEventListener("click", togglePanel);

listenToKeys({
  hand: view3d.hand,
  named: (index) => named(VIEW_NAMES[index]),
  reset,
  perspective: () => store.set({ view: { camera: { fov: store.state.view.camera.fov > 0 ? 0 : FOV } } }),
  turntable: turntable.toggle,
  mode() {
    const now = MODES.findIndex(([name]) => name === modeOf(store.state.view));
    const [name, text] = MODES[(now + 1) % MODES.length];
    setMode(name);
    announce(text);
  },
  measure: chooseTool,
  bookmark: bookmarks.save,
  nextBookmark: bookmarks.step,
  escape: tool.escape,
  play: player.toggle,
  time: (steps) => player.move(steps),
  undo: stepBack,
  redo: stepForward,
  panel: togglePanel,
  fullScreen: () =>
    (document.fullscreenElement ? document.exitFullscreen() : document.documentElement.requestFullscreen?.())?.catch(
      () => {},
    ),
  help,
});

// ---- volumes ------------------------------------------------------------------------------------------

function firstLook(volume) {
  const channels = channelsOf(volume, volumes.list());
  const own = channels?.find((channel) => channel.volume === volume.id);
  return {
    ...lookOf(volume),
    channels,
    overlays: overlaysOf(volume),
    ...(own && { transfer: own.transfer, opacity_scale: 1 }),
    // The pictures of dyes add up; light of each would not.
    ...(own && !volume.channel.component && { light: { on: false } }),
  };
}

const lookOf = (volume) => ({
  volume: volume.id,
  time: timeIn(volume, store.state.view.time),
  mirror: volume.mirrored === true,
  camera: homeCamera(volume, view3d.size.width, view3d.size.height),
  window: null,
  surface: { value: null },
  clip: { box: null, planes: [] },
  light: { on: volume.home?.lit !== false },
});

function allAsAtFirst() {
  const volume = volumes.current();
  if (volume?.state !== "ready") return;
  turntable.stop();
  store.set({ view: { ...DEFAULT_VIEW, ...firstLook(volume), time: 0 }, page: { sample: null } });
  announce("All settings have their initial values");
}

// Another volume keeps the look, without settings in sample values; a copy keeps everything.
function choose(id) {
  const [before, next] = [volumes.current(), volumes.get(id)];
  if (!next || next === before) return;
  turntable.stop();
  player.stop();
  const kin = before && (next.parent === before.id || before.parent === next.id);
  if (kin || next.state !== "ready") {
    const time = before?.parent === id ? before.time : 0; // a copy has one time
    store.set({ view: { volume: id, time, channels: channelsOf(next, volumes.list()) } });
  } else {
    const look = firstLook(next);
    const { transfer, channels } = store.state.view;
    const usual = look.channels || (typeof transfer === "string" && !channels) ? {} : { transfer: "auto" };
    const overlays = fittingOverlays(store.state.view.overlays, next, overlayTransfers(about));
    store.set({ view: { ...usual, ...look, overlays }, page: { sample: null } });
  }
  if (kin) opened = id;
  else open();
}

// Shows a volume when it is ready: from the front, or as the link says.
function open() {
  const volume = volumes.current();
  if (volume?.state !== "ready" || opened === volume.id) return;
  const first = opened === null;
  opened = volume.id;
  if (first || same(store.state.view.camera, DEFAULT_VIEW.camera)) {
    store.set({ view: firstLook(volume) }, { undo: false });
    const time = timeIn(volume, linked.view?.time ?? 0);
    const channels = sameChannels(linked.view?.channels, store.state.view.channels) ?? store.state.view.channels;
    const overlays = fittingOverlays(linked.view?.overlays, volume, overlayTransfers(about));
    const view = { ...(linked.view ?? {}), volume: volume.id, time, channels, overlays };
    store.set({ view, page: pageOfLink(linked.page) }, { undo: false });
    linked = {};
    announce(`${volume.name} is ready`);
  }
  view3d.refresh();
}

const updateChooser = mountChooser($("chooser"), choose);

// Without a second volume, and without copies, there is nothing to compare.
function showSections() {
  const comparable = volumes.list().length > 1 || about?.limits.copies > 0;
  document.querySelector('[data-section="compare"]').hidden = !comparable;
}

let readyChannels = 0;
let homeBefore = null;

// A channel that becomes ready joins the picture.
function showReadyChannels() {
  const { channels } = store.state.view;
  const ready = (channels ?? []).filter(({ volume }) => volumes.get(volume)?.state === "ready").length;
  if (channels && ready !== readyChannels) view3d.refresh();
  readyChannels = ready;
  const volume = volumes.current();
  const home = channels && volume?.state === "ready" ? homeCamera(volume, view3d.size.width, view3d.size.height) : null;
  if (home && homeBefore && same(store.state.view.camera, homeBefore)) store.set({ view: { camera: home } }, { undo: false });
  homeBefore = home;
}

let arrivedBefore = null; // of a file that is arriving

// A finer level of the volume has arrived, or more of it, or all.
function showArrived() {
  const { arrived_level: level = 0, arrived_part: part = 0 } = volumes.current() ?? {};
  const arrived = `${level} ${part}`;
  if (arrivedBefore !== null && arrived !== arrivedBefore) view3d.refresh();
  arrivedBefore = arrived;
}

function volumesChanged() {
  open();
  showArrived();
  showReadyChannels();
  showSections();
  updateChooser();
  showState();
  refreshers.forEach((refresh) => refresh(store.state));
  drawSoon();
}
volumes.subscribe(volumesChanged);

// ---- showing the state --------------------------------------------------------------------------------

let linkTimer = 0;
store.subscribe((state, previous, { live }) => {
  const { page, view } = state;
  $("stage").dataset.layout = page.layout;
  $("stage-slices").hidden = page.layout !== "slices";
  $("stage-compare").hidden = page.layout !== "compare";
  if (page.open !== previous.page.open) {
    for (const section of sections) {
      const open = page.open[section.dataset.section];
      if (open !== undefined && section.open !== open) section.open = open;
    }
  }
  $("undo").disabled = !store.canUndo;
  $("redo").disabled = !store.canRedo;
  if (view.volume !== previous.view.volume) {
    updateChooser();
    showState();
    status.describe(volumes.current());
    open();
  }
  if (view.background !== previous.view.background) showGround();
  if (page.sample === null) picked.hide();
  drawSoon();
  if (live || opened === null) return;
  clearTimeout(linkTimer);
  linkTimer = setTimeout(() => history.replaceState(null, "", `#${hashOf(store.state)}`), LINK_MS);
});

// Overlays are dark on a light background.
function showGround() {
  const { background } = store.state.view;
  const [r, g, b] = background;
  $("stage-3d").style.backgroundColor = `rgb(${background.map((c) => Math.round(255 * c)).join(" ")})`;
  $("stage-3d").dataset.ground = 0.3 * r + 0.6 * g + 0.1 * b > 0.45 ? "light" : "dark";
}

// With --once the program ends when the page closes.
window.addEventListener("pagehide", (event) => {
  if (about?.once && !event.persisted) api.endLater();
});

// The view of a link: fields that it lacks get their initial values.
function viewOfLink(view, volume) {
  const first = volume?.state === "ready" ? firstLook(volume) : {};
  opened = volume?.id ?? opened;
  const time = timeIn(volume, view.time ?? 0);
  const channels = sameChannels(view.channels, first.channels) ?? first.channels ?? null;
  const overlays = fittingOverlays(view.overlays, volume, overlayTransfers(about));
  return merge(merge(DEFAULT_VIEW, first), { ...view, volume: volume?.id ?? null, time, channels, overlays });
}

// The page of a link keeps the bookmarks that are there.
function pageOfLink({ bookmarks: more, ...page } = {}) {
  const { list } = store.state.page.bookmarks;
  return { ...page, bookmarks: { list: joined(list, more?.list ?? []) } };
}

// Another link in the address bar.
window.addEventListener("hashchange", () => {
  if (opened === null || hashOf(store.state) === location.hash.slice(1)) return;
  const { view = {}, page } = patchOf(location.hash);
  const volume = volumes.get(view.volume) ?? volumes.current();
  store.set({ view: viewOfLink(view, volume), page: pageOfLink(page) });
});

// A bookmark of the file of `root`: measurements that were made since then stay.
function showBookmark(link, root) {
  turntable.stop();
  player.stop();
  const { view = {}, page = {} } = patchOf(link);
  const own = volumes.get(view.volume);
  const volume = own?.state === "ready" && rootOf(own, volumes.get) === root.id ? own : root;
  const list = joinedMeasures(store.state.page.measures.list, page.measures?.list ?? [], root.id);
  store.set({
    view: viewOfLink(view, volume),
    page: { layout: "single", sample: null, ...page, measures: { shown: true, ...page.measures, list } },
  });
}

// ---- connection to the program ------------------------------------------------------------------------

let retryTimer = 0;

async function retry() {
  clearTimeout(retryTimer);
  try {
    about = await api.about();
    if (!volumes.list().length) await start();
    else await volumes.refresh();
    view3d.refresh();
  } catch (error) {
    if (error.status === 0) retryTimer = setTimeout(retry, RETRY_MS);
    else notice.failed(error.message);
  }
}

api.onReach((yes) => {
  reached = yes;
  status.state(yes ? "idle" : "gone");
  announce(yes ? "The viewer answers again" : "The viewer does not answer");
  if (!yes) {
    turntable.stop();
    player.stop();
    clearTimeout(retryTimer);
    retryTimer = setTimeout(retry, RETRY_MS);
  }
  showState();
});

onChanged(() => volumes.refresh());

onAdded(async () => {
  await volumes.refresh();
  choose(volumes.list().at(-1)?.id);
});

async function start() {
  await volumes.refresh();
  const first = volumes.get(linked.view?.volume) ?? volumes.list()[0];
  store.set({ view: { volume: first?.id ?? null } }, { undo: false });
  volumesChanged();
  status.describe(volumes.current());
}

showGround();
// Set the layout of the link before its zoom, which depends on the layout.
store.set({ page: linked.page ?? {} }, { undo: false });
mountOthers();
retry();
