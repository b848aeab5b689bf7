// Translates mouse and touch events into movements: turn, pan, zoom, roll, tap. Each ends with finish().

const CLICK_SLACK = 4; // largest movement of a click, in pixels
const DOUBLE_MS = 350;
const WHEEL_REST_MS = 160;
const ZOOM_PER_PIXEL = 0.0018;

const LINE_PIXELS = 16;
const TWIST_DEGREES = 12; // rotation of two fingers before it counts as a roll

// on: {turn(dx, dy), pan(dx, dy), zoom(factor, x, y), roll(degrees), finish(), tap(x, y), doubleTap(x, y), start()};
// pixels of the page; positions from the top left of the element.
export function listenToGestures(element, on) {
  const pointers = new Map(); // pointerId: {x, y}
  let kind = null;
  let travelled = 0;
  let lastTap = { time: -Infinity, x: 0, y: 0 };
  let twist = 0;
  let wheelTimer = 0;

  const place = (event) => {
    const box = element.getBoundingClientRect();
    return { x: event.clientX - box.left, y: event.clientY - box.top };
  };

  const kindOf = (event) => {
    if (event.altKey) return "roll";
    if (event.shiftKey || event.button === 1 || event.button === 2) return "pan";
    return "turn";
  };

  function pair() {
    const [a, b] = [...pointers.values()];
    return {
      x: (a.x + b.x) / 2,
      y: (a.y + b.y) / 2,
      length: Math.max(1, Math.hypot(b.x - a.x, b.y - a.y)),
      angle: Math.atan2(b.y - a.y, b.x - a.x),
    };
  }

  function tap(at, time) {
    const again = time - lastTap.time < DOUBLE_MS && Math.hypot(at.x - lastTap.x, at.y - lastTap.y) < 20;
    lastTap = again ? { time: -Infinity, x: 0, y: 0 } : { time, ...at };
    if (again) on.doubleTap(at.x, at.y);
    else on.tap(at.x, at.y);
  }

  const degreesBetween = (from, to) => {
    let turn = ((to - from) * 180) / Math.PI;
    if (turn > 180) turn -= 360;
    if (turn < -180) turn += 360;
    return turn;
  };

  function movedBy(before, now) {
    const [dx, dy] = [now.x - before.x, now.y - before.y];
    if (kind === "pan") on.pan(dx, dy);
    else if (kind === "roll") {
      const middle = { x: element.clientWidth / 2, y: element.clientHeight / 2 };
      const angle = (p) => Math.atan2(p.y - middle.y, p.x - middle.x);
      on.roll(degreesBetween(angle(before), angle(now)));
    } else on.turn(dx, dy);
  }

  element.addEventListener("pointerdown", (event) => {
    if (event.pointerType === "mouse" && pointers.size) return;
    element.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, place(event));
    kind = pointers.size > 1 ? "two" : kindOf(event);
    travelled = pointers.size === 1 ? 0 : Infinity;
    twist = 0;
    on.start?.();
  });

  element.addEventListener("pointermove", (event) => {
    const before = pointers.get(event.pointerId);
    if (!before) return;
    const now = place(event);
    travelled += Math.hypot(now.x - before.x, now.y - before.y);
    if (pointers.size > 1) {
      const was = pair();
      pointers.set(event.pointerId, now);
      const is = pair();
      on.pan(is.x - was.x, is.y - was.y);
      on.zoom(is.length / was.length, is.x, is.y);
      const turned = degreesBetween(was.angle, is.angle);
      twist += turned;
      if (Math.abs(twist) > TWIST_DEGREES) on.roll(turned);
      return;
    }
    if (travelled < CLICK_SLACK) return;
    pointers.set(event.pointerId, now);
    movedBy(before, now);
  });

  const lift = (event) => {
    const at = pointers.get(event.pointerId);
    if (!at) return;
    pointers.delete(event.pointerId);
    if (pointers.size) return;
    if (event.type === "pointerup" && travelled < CLICK_SLACK && event.button === 0 && kind === "turn")
      tap(at, event.timeStamp);
    else on.finish();
    kind = null;
  };
  element.addEventListener("pointerup", lift);
  element.addEventListener("pointercancel", lift);

  // Replaces the zoom of the page (Ctrl with wheel, which touch pads send for pinches).
  element.addEventListener(
    "wheel",
    (event) => {
      event.preventDefault();
      const at = place(event);
      const pixels = event.deltaY * (event.deltaMode === 1 ? LINE_PIXELS : event.deltaMode === 2 ? 400 : 1);
      const speed = event.ctrlKey ? 6 : 1;
      on.zoom(Math.exp(-Math.max(-300, Math.min(300, pixels)) * ZOOM_PER_PIXEL * speed), at.x, at.y);
      clearTimeout(wheelTimer);
      wheelTimer = setTimeout(on.finish, WHEEL_REST_MS);
    },
    { passive: false },
  );
  element.addEventListener("contextmenu", (event) => event.preventDefault());
}
