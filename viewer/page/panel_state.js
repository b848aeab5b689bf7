// What panels keep in state.page, as it begins, and what of it a link may say. Loaded before any link is read.

import { carryInLink } from "./link.js";

/** How volumes are compared: side by side or by their difference, with which other one. */
export const COMPARE = { mode: "side", other: null, gain: 8 };

/** Values that slices show as black and white, by volume: null is what fits. */
export const SLICES = { windows: {} };

const compareFits = {
  mode: (value) => value === "side" || value === "difference",
  other: (value) => value === null || typeof value === "string",
  gain: (value) => Number.isFinite(value) && value >= 1 && value <= 100,
};
const isWindow = (value) =>
  value === null || (Array.isArray(value) && value.length === 2 && value.every(Number.isFinite) && value[0] < value[1]);

carryInLink("compare", COMPARE, ([field, ...rest], value) =>
  Boolean(!rest.length && Object.hasOwn(compareFits, field) && compareFits[field](value)),
);
carryInLink("slices", SLICES, ([field, id, ...rest], value) =>
  Boolean(field === "windows" && id && !rest.length && isWindow(value)),
);
