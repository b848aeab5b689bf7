// Fields of the panels in state.page: initial values, and checks for links. Loaded before any link is read.

import { areBookmarks } from "./bookmarks.js";
import { carryInLink } from "./link.js";
import { areMeasures } from "./measures.js";

/** Comparison: side by side or difference, and the other volume, or another time of the same one. */
export const COMPARE = { mode: "side", other: null, gain: 8, time: 0 };

/** Values of black and white in slices, by volume; null: automatic. */
export const SLICES = { windows: {} };

/** Measurements (state/measures.js), and whether pictures show them. */
export const MEASURES = { list: [], shown: true };

/** Bookmarks (state/bookmarks.js). */
export const BOOKMARKS = { list: [] };

const compareFits = {
  mode: (value) => value === "side" || value === "difference",
  other: (value) => value === null || typeof value === "string",
  time: (value) => Number.isInteger(value) && value >= 0,
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
carryInLink("measures", MEASURES, ([field, ...rest], value) =>
  Boolean(!rest.length && (field === "list" ? areMeasures(value) : field === "shown" && typeof value === "boolean")),
);
carryInLink("bookmarks", BOOKMARKS, ([field, ...rest], value) => Boolean(!rest.length && field === "list" && areBookmarks(value)));
