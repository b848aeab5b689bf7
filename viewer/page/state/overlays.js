// The overlays of a view: state.view.overlays is a list of {on, opacity, depth, and transfer and window (of values) or
// labels (the drawn ones)}, or null. A null field has its initial value; the window null is automatic, labels null are
// all. The description of a volume has the overlays of the program: volume.overlays.

import { meaningOf, shortNumber } from "./meaning.js";

const MOST = 4;

const isNumber = (value, low, high) => Number.isFinite(value) && value >= low && value <= high;
const isWindow = (low, high) => [low, high, high - low].every(Number.isFinite) && low < high;
const fits = {
  on: (value) => typeof value === "boolean",
  opacity: (value) => isNumber(value, 0, 1),
  depth: (value) => value === null || isNumber(value, 0, 1e30),
  transfer: (value, names) => names.includes(value),
  window: (value) => value === null || (Array.isArray(value) && value.length === 2 && isWindow(...value)),
  labels: (value) => value === null || (Array.isArray(value) && value.every(Number.isInteger)),
};

// 1 if a value from a link can be a list of overlays.
export const areOverlays = (value) => value === null || (Array.isArray(value) && value.length <= MOST);

// The overlays of a volume as they are first shown; null: it has none.
export function overlaysOf(volume) {
  if (!volume?.overlays?.length) return null;
  return volume.overlays.map(({ opacity, values }) => ({
    on: true,
    opacity,
    depth: null,
    ...(values ? { transfer: values.transfer, window: values.window } : { labels: null }),
  }));
}

// The names of transfer functions that every overlay of values can have, of the description of the program.
export const overlayTransfers = (about) => (about?.transfers ?? []).filter((name) => !about.ct_transfers?.includes(name));

// The settings of a list for a volume: those that fit its overlays, and the initial ones for others. names: of transfer
// functions, besides that of the overlay.
export function fittingOverlays(list, volume, names = []) {
  const own = overlaysOf(volume);
  if (!own || list?.length !== own.length) return own;
  return own.map((first, i) => {
    const known = volume.overlays[i].labels?.map(({ value }) => value);
    const allowed = [...names, first.transfer];
    const kept = Object.entries(list[i] ?? {}).filter(([name, value]) => name in first && fits[name](value, allowed));
    const { labels, ...one } = { ...first, ...Object.fromEntries(kept) };
    if (labels === undefined) return one;
    return { ...one, labels: labels && [...new Set(labels)].filter((value) => known.includes(value)) };
  });
}

const ENDINGS = /(\.(seg|cvol|nii|nrrd|nhdr|mha|mhd|tiff?|npy|vti|mrc|vtk|h5|gz))+$/i;

// "pet 3120" or "Motor cortex": the values or labels of the drawn overlays at a place, of an answer about it.
export function overlayTexts(answers, { overlays: shown }, volume) {
  return (answers ?? []).flatMap((one, i) => {
    const described = volume?.overlays?.[i];
    if (!one || one.value === null || !described || (shown?.[i] && !isDrawn(shown[i], one.value))) return [];
    const { values, name } = described;
    const { to, digits } = meaningOf(values ?? { type: "int32" }); // labels are integers
    const text = shortNumber(to(one.value), digits + 1);
    return [one.label ?? `${name.replace(ENDINGS, "")} ${text}`];
  });
}

// 1 if an overlay is drawn where it has this value.
const isDrawn = ({ on, opacity, labels = null }, value) => on && opacity > 0 && showsLabel({ labels }, value);

// The overlays of a request; undefined: those of the program, as it began.
export function requestOverlays({ overlays }) {
  return overlays?.map(({ depth, labels, ...one }) => ({
    ...one,
    ...(depth === null ? {} : { depth }),
    ...(labels ? { labels } : {}),
  }));
}

// The patch that changes overlay i of a view.
export const overlayPatch = ({ overlays }, i, change) => ({
  view: { overlays: overlays.map((one, k) => (k === i ? { ...one, ...change } : one)) },
});

// 1 if a label is drawn.
export const showsLabel = ({ labels }, value) => labels === null || labels.includes(value);

// The change of an overlay that shows a label or not.
export function labelChange({ labels }, all, value, on) {
  const shown = (labels ?? all).filter((other) => other !== value);
  const next = all.filter((other) => (other === value ? on : shown.includes(other)));
  return { labels: next.length === all.length ? null : next };
}
