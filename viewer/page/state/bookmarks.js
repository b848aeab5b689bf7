// Bookmarks: [name, file, link], where the link is the part of an address after # (state/link.js). They are in the state,
// so that a link has them, and in the browser's storage, for each file.

export const MOST = 100;
const NAME_MOST = 80; // characters
const KEY = "cvol bookmarks ";

const isText = (text, most) => typeof text === "string" && text.length > 0 && text.length <= most;

export const areBookmarks = (value) =>
  Array.isArray(value) &&
  value.length <= MOST &&
  value.every((one) => Array.isArray(one) && one.length === 3 && isText(one[0], NAME_MOST) && isText(one[1], 1000) && typeof one[2] === "string");

/** The file of a volume, by what stays when it is opened again. */
export const fileOf = ({ name, dims }) => `${name} ${dims.join("x")}`;

/** The name, or with a number that no bookmark of the file has. */
export function freeName(list, file, wanted) {
  const taken = new Set(list.filter((one) => one[1] === file).map(([name]) => name));
  const name = wanted.trim().slice(0, NAME_MOST - 4);
  for (let i = 2; taken.has(name); i++) if (!taken.has(`${name} ${i}`)) return `${name} ${i}`;
  return name;
}

/** The list with a bookmark of another name; the same list if there is nothing to change. */
export function renamed(list, bookmark, wanted) {
  const [name, file, link] = bookmark;
  const next = freeName(list.filter((one) => one !== bookmark), file, wanted);
  return !next || next === name ? list : list.map((one) => (one === bookmark ? [next, file, link] : one));
}

/** "View 1": the first number that is free. */
export function nextName(list, file) {
  const taken = new Set(list.filter((one) => one[1] === file).map(([name]) => name));
  let i = 1;
  while (taken.has(`View ${i}`)) i++;
  return `View ${i}`;
}

/** The list with more bookmarks; the same view of a file is not there twice, nor is a name. */
export function joined(list, more) {
  const out = [...list];
  for (const [name, file, link] of more) {
    if (out.length >= MOST) break;
    if (out.some((one) => one[1] === file && one[2] === link)) continue;
    out.push([freeName(out, file, name), file, link]);
  }
  return out.length === list.length ? list : out;
}

/** The kept bookmarks of a file; none if the browser keeps nothing. */
export function readKept(file) {
  try {
    const kept = JSON.parse(localStorage.getItem(KEY + file) ?? "[]").map(([name, link]) => [name, file, link]);
    return areBookmarks(kept) ? kept : [];
  } catch {
    return [];
  }
}

export function writeKept(file, list) {
  const kept = list.filter((one) => one[1] === file).map(([name, , link]) => [name, link]);
  try {
    if (kept.length) localStorage.setItem(KEY + file, JSON.stringify(kept));
    else localStorage.removeItem(KEY + file);
  } catch {
    // the browser keeps nothing, or has no room: the link has them
  }
}
