// Keys for all gestures. They do nothing in text fields, and in controls that use the same keys.

const TURN_PIXELS = 24;
const PAN_PIXELS = 32;
const ROLL_DEGREES = 5;
const REST_MS = 250;

export const KEYS = [
  ["Turn", ["← → ↑ ↓"]],
  ["Move", ["shift ← → ↑ ↓"]],
  ["Roll", [",", "."]],
  ["Zoom in, zoom out", ["+", "-"]],
  ["Front, back, left, right, top, bottom", ["1 … 6"]],
  ["Value at the centre of the picture", ["enter"]],
  ["Reset the view", ["r"]],
  ["Perspective on or off", ["p"]],
  ["Turntable", ["t"]],
  ["Next mode", ["m"]],
  ["Play or stop a series", ["space"]],
  ["Time before, time after", ["j", "k"]],
  ["Measure: distance, angle, box, ellipse", ["d", "a", "b", "e"]],
  ["Place a point, end measuring", ["enter", "esc"]],
  ["Save this view, view before, view after", ["s", "[", "]"]],
  ["Undo, redo", ["z", "shift z"]],
  ["Panel", ["\\"]],
  ["Full screen", ["f"]],
  ["This help", ["?"]],
];

const typing = (target) =>
  target.closest?.(
    "input:not([type=checkbox], [type=radio], [type=range], [type=color]), textarea, select, [contenteditable], dialog",
  );
const usesArrows = (target) => target.closest?.("input, select, textarea, [role=slider], [data-arrows]");

// The space bar presses a focused control.
const usesSpace = (target) => target.closest?.("button, input, select, summary, a, label, [role=button]");

// actions: {hand, named(index), reset, perspective, turntable, mode, measure(kind), escape, bookmark, nextBookmark(by), play, time(steps), undo, redo, panel, fullScreen, help}.
export function listenToKeys(actions) {
  const { hand } = actions;
  let restTimer = 0;

  function gesture(move) {
    move();
    clearTimeout(restTimer);
    restTimer = setTimeout(hand.finish, REST_MS);
  }

  const ways = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

  function arrow(event) {
    const [x, y] = ways[event.key];
    if (event.shiftKey) gesture(() => hand.pan(x * PAN_PIXELS, y * PAN_PIXELS));
    else gesture(() => hand.turn(x * TURN_PIXELS, y * TURN_PIXELS));
  }

  const plain = {
    "+": () => gesture(() => hand.zoom(1.15)),
    "=": () => gesture(() => hand.zoom(1.15)),
    "-": () => gesture(() => hand.zoom(1 / 1.15)),
    _: () => gesture(() => hand.zoom(1 / 1.15)),
    ",": () => gesture(() => hand.roll(-ROLL_DEGREES)),
    ".": () => gesture(() => hand.roll(ROLL_DEGREES)),
    r: actions.reset,
    p: actions.perspective,
    t: actions.turntable,
    m: actions.mode,
    j: () => actions.time(-1),
    k: () => actions.time(1),
    f: actions.fullScreen,
    s: actions.bookmark,
    "[": () => actions.nextBookmark(-1),
    "]": () => actions.nextBookmark(1),
    d: () => actions.measure("distance"),
    a: () => actions.measure("angle"),
    b: () => actions.measure("box"),
    e: () => actions.measure("ellipsoid"),
    "\\": actions.panel,
    "?": actions.help,
  };

  document.addEventListener("keydown", (event) => {
    if (event.defaultPrevented || event.altKey || typing(event.target)) return;
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    const command = event.ctrlKey || event.metaKey;
    if (key === "z") (event.shiftKey ? actions.redo : actions.undo)();
    else if (command && key === "y") actions.redo();
    else if (command) return;
    else if (ways[key] && !usesArrows(event.target)) arrow(event);
    else if (/^[1-6]$/.test(key)) actions.named(Number(key) - 1);
    else if (key === "Enter" && event.target.matches("canvas")) hand.tap();
    else if (key === "Escape") {
      if (!actions.escape()) return;
    } else if (key === " " && !usesSpace(event.target)) actions.play();
    else if (Object.hasOwn(plain, key)) plain[key]();
    else return;
    event.preventDefault();
  });
}
