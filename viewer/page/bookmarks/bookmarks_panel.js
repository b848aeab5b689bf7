// The panel of bookmarks: saved views with a name, which can be shown, sent as a link, renamed, and deleted.

import { button, copyFrom, download, element, field, statusLine, stem } from "../controls/panel_kit.js";
import { areBookmarks, fileOf, freeName, joined, MOST, nextName, readKept, renamed, writeKept } from "../state/bookmarks.js";
import { rootOf } from "../state/measures.js";
import { hashOf } from "../state/link.js";
import { store } from "../state/store.js";
import { LINK_LASTS } from "../state/transport.js";
import { volumes } from "../state/volumes.js";

const LARGEST = 1 << 20; // bytes of a file

/** show(link, volume): shows a saved view. Returns {save, step(by)} for keys. */
export function mountBookmarks(panel, { show }) {
  const list = () => store.state.page.bookmarks.list;
  // Bookmarks are no undo steps: to undo a movement must not lose a view that was saved after it.
  const change = (next) => store.set({ page: { bookmarks: { list: next } } }, { undo: false });
  const open = new Set(); // files whose kept bookmarks are in the list
  const status = statusLine();
  let last = null; // shown or saved last
  let edited = null; // the bookmark that gets another name

  const root = () => volumes.get(rootOf(volumes.current(), volumes.get));
  const currentFile = () => (root()?.state === "ready" ? fileOf(root()) : null);
  const listed = () => list().filter(([, file]) => open.has(file));

  // ---- elements ---------------------------------------------------------------------------------------

  const name = field("Name of this view", element("input", { type: "text", maxlength: 76, onkeydown: typed }), button("Save", save, { title: "Save this view (s)" }));
  const rows = element("ol", { class: "bookmark-list" });
  const restore = element("div", { class: "buttons" });
  const link = element("input", { type: "text", readonly: true, "aria-label": "Link to the view" });
  const linkBox = element("div", { class: "field", hidden: true }, link);
  const input = element("input", { type: "file", accept: ".json,application/json", class: "unseen", onchange: load, tabindex: -1, "aria-label": "File of bookmarks" });
  panel.classList.add("panel-bookmarks");
  panel.append(
    name.node,
    rows,
    restore,
    linkBox,
    status.node,
    element("div", { class: "buttons" }, button("Save as a file", saveFile), button("Load…", () => input.click()), input),
    element(
      "p",
      { class: "hint" },
      LINK_LASTS
        ? "This browser keeps them for the file, and the address in the bar has them."
        : "The address in the bar has them; this browser keeps them for the file and the port (cvol view --port).",
    ),
  );

  // ---- changes ----------------------------------------------------------------------------------------

  function save() {
    const file = currentFile();
    if (!file) return;
    if (list().length >= MOST) return status.say(`There are ${MOST} bookmarks: delete some first.`, true);
    const { view, page } = store.state;
    const wanted = name.input.value.trim();
    const saved = [wanted ? freeName(list(), file, wanted) : nextName(list(), file), file, hashOf({ view, page: { ...page, bookmarks: undefined } })];
    change([...list(), saved]);
    name.input.value = "";
    last = saved;
    status.say(`Saved ${saved[0]}.`);
    update();
  }

  function typed(event) {
    if (event.key === "Enter") save();
  }

  function apply(bookmark) {
    const [title, file, address] = bookmark;
    const volume = volumes.list().find((one) => one.state === "ready" && !one.parent && fileOf(one) === file);
    if (!volume) return;
    last = bookmark;
    show(address, volume);
    status.say(`${title} is shown.`);
    update();
  }

  function step(by) {
    const all = listed();
    if (!all.length) return status.say("There are no bookmarks: s saves this view.");
    const at = all.indexOf(last);
    apply(all[at < 0 ? (by > 0 ? 0 : all.length - 1) : (at + by + all.length) % all.length]);
  }

  function remove(bookmark) {
    const at = listed().indexOf(bookmark);
    change(list().filter((one) => one !== bookmark));
    status.say(`Deleted ${bookmark[0]}.`);
    restore.replaceChildren(
      button(`Restore ${bookmark[0]}`, () => {
        change(joined(list(), [bookmark]));
        restore.replaceChildren();
        status.say(`${bookmark[0]} is back.`);
        rows.querySelector("li:last-child .link")?.focus();
      }),
    );
    const left = [...rows.querySelectorAll("[data-delete]")];
    (left[Math.min(at, left.length - 1)] ?? name.input).focus();
  }

  function rename(bookmark) {
    edited = bookmark;
    update();
    const input = rows.querySelector("input");
    input.focus();
    input.select();
  }

  // Gives the edited bookmark the typed name, or none: it keeps its own.
  function endRename(wanted = "") {
    if (!edited) return;
    const [bookmark, at] = [edited, list().indexOf(edited)];
    const next = renamed(list(), bookmark, wanted);
    edited = null;
    if (next === list()) return update();
    if (last === bookmark) last = next[at];
    change(next);
    status.say(`${bookmark[0]} is now ${next[at][0]}.`);
  }

  async function copyLink([, , address]) {
    const here = new URL(location.href);
    here.hash = address;
    linkBox.hidden = false;
    link.value = here.href;
    await copyFrom(link, status, "Link");
  }

  function saveFile() {
    const saved = listed().map(([title, file, address]) => ({ name: title, file, link: address }));
    download(`${JSON.stringify({ bookmarks: saved }, null, 1)}\n`, `${stem(volumes.current())}-bookmarks.json`);
  }

  async function load() {
    const [file] = input.files;
    input.value = "";
    if (!file) return;
    try {
      if (file.size > LARGEST) throw new Error(`${file.name} has ${file.size} bytes, must have at most ${LARGEST}.`);
      let read;
      try {
        read = JSON.parse(await file.text()).bookmarks.map((one) => [one.name, one.file, one.link]);
      } catch {
        read = null;
      }
      if (!areBookmarks(read)) throw new Error(`${file.name} is not a file of bookmarks: it must have a list "bookmarks" with name, file and link.`);
      const before = list().length;
      change(joined(list(), read));
      const others = read.filter(([, of]) => !open.has(of)).length;
      status.say(`${file.name}: ${list().length - before} more bookmarks${others ? `, ${others} of other files` : ""}.`);
    } catch (error) {
      status.say(error.message, true);
    }
  }

  // ---- updates ----------------------------------------------------------------------------------------

  function nameInput(bookmark, at) {
    const typedName = (event) => {
      if (event.key !== "Enter" && event.key !== "Escape") return;
      event.preventDefault(); // not a click on what has the focus next
      event.stopPropagation();
      endRename(event.key === "Enter" ? event.target.value : "");
      rows.querySelector(`[data-at="rename ${at}"]`)?.focus();
    };
    const [value, label] = [bookmark[0], `Name of ${bookmark[0]}`];
    const events = { onkeydown: typedName, onblur: (event) => endRename(event.target.value) };
    return element("input", { type: "text", maxlength: 76, value, "aria-label": label, "data-at": `name ${at}`, ...events });
  }

  function rowOf(bookmark, i) {
    const [title] = bookmark;
    if (bookmark === edited) return element("li", {}, nameInput(bookmark, i));
    const current = bookmark === last ? "true" : null;
    const small = (sign, name, fn, attributes) => button(sign, fn, { class: "icon small", "aria-label": `${name} ${title}`, title: name, ...attributes });
    return element(
      "li",
      {},
      button(title, () => apply(bookmark), { class: "link", title: "Show this view", "aria-current": current, "data-at": `show ${i}` }),
      button("Link", () => copyLink(bookmark), { "aria-label": `Copy the link to ${title}`, title: "Copy its link", "data-at": `link ${i}` }),
      small("✎", "Rename", () => rename(bookmark), { "data-at": `rename ${i}` }),
      small("✕", "Delete", () => remove(bookmark), { "data-delete": true, "data-at": `delete ${i}` }),
    );
  }

  function update() {
    panel.inert = !currentFile();
    const at = panel.contains(document.activeElement) ? document.activeElement.dataset.at : null;
    if (!listed().includes(edited)) edited = null;
    if (!edited || !rows.querySelector("input")) rows.replaceChildren(...listed().map(rowOf)); // else: a name is being typed
    if (at) rows.querySelector(`[data-at="${at}"]`)?.focus();
    const file = currentFile();
    name.input.placeholder = file ? nextName(list(), file) : "";
  }

  // The kept bookmarks of a file join the list when it is open.
  function joinKept() {
    for (const volume of volumes.list()) {
      if (volume.state !== "ready" || volume.parent || open.has(fileOf(volume))) continue;
      open.add(fileOf(volume));
      change(joined(list(), readKept(fileOf(volume))));
      writeKept(fileOf(volume), list());
    }
    update();
  }

  volumes.subscribe(joinKept);
  store.subscribe((state, previous) => {
    if (state.page.bookmarks !== previous.page.bookmarks) for (const file of open) writeKept(file, list());
    if (state.page.bookmarks !== previous.page.bookmarks || state.view.volume !== previous.view.volume) update();
  });
  joinKept();
  return { save, step };
}
