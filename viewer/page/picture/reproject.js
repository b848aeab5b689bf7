// Moves, turns and scales the last picture to match the current camera, if that is geometrically correct. With a
// slow connection, pans and zooms follow the pointer before the next picture arrives.

import { projector } from "../state/camera.js";

const RADIANS = Math.PI / 180;
const ALIKE = ["azimuth", "elevation", "fov"];

// {x, y, scale, angle} about the centre, from the view of the picture to the current view; null if no such
// transform exists.
export function reprojection(drawn, now, volume, width, height) {
  if (drawn.volume !== now.volume || drawn.mirror !== now.mirror || now.camera.fov > 0) return null;
  if (ALIKE.some((name) => drawn.camera[name] !== now.camera[name])) return null;
  const middle = projector(now, volume, width, height)(drawn.camera.look_at);
  const turned = (now.camera.roll - drawn.camera.roll) * RADIANS;
  return {
    x: middle.x - width / 2,
    y: middle.y - height / 2,
    scale: now.camera.zoom / drawn.camera.zoom,
    angle: now.mirror ? -turned : turned,
  };
}

export const isIdentity = ({ x, y, scale, angle }) =>
  Math.abs(x) < 0.01 && Math.abs(y) < 0.01 && Math.abs(scale - 1) < 1e-5 && Math.abs(angle) < 1e-5;

// Draws a bitmap with such a transform; width and height are pixels of the page.
export function drawMoved(context, bitmap, { x, y, scale, angle }, width, height, ground) {
  const { canvas } = context;
  context.setTransform(1, 0, 0, 1, 0, 0);
  context.fillStyle = ground;
  context.fillRect(0, 0, canvas.width, canvas.height);
  context.translate(canvas.width / 2 + (x * canvas.width) / width, canvas.height / 2 + (y * canvas.height) / height);
  context.rotate(angle);
  context.scale(scale, scale);
  context.drawImage(bitmap, -canvas.width / 2, -canvas.height / 2, canvas.width, canvas.height);
  context.setTransform(1, 0, 0, 1, 0, 0);
}
