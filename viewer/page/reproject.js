// What a picture would look like from where the camera is now, as far as that is the same picture moved, turned and
// enlarged: while the next one is on its way over a slow line, pans and zooms follow the hand all the same.

import { projector } from "./camera.js";

const RADIANS = Math.PI / 180;
const ALIKE = ["azimuth", "elevation", "fov"];

// {x, y, scale, angle} about the picture's middle, from the view that it was drawn for to the one of now; null where
// another picture is needed to tell.
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

// Draws a bitmap so; width and height are the page's pixels that it covers.
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
