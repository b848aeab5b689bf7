// The camera and its movements: the mathematics of cvol/camera.h, in world lengths from the centre of the box of sample
// centres. Pixels are those of the page.

const RADIANS = Math.PI / 180;
export const ZOOM_MIN = 0.05;
export const ZOOM_MAX = 500;

export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const sum = (...terms) => [0, 1, 2].map((i) => terms.reduce((total, [weight, v]) => total + weight * v[i], 0));
export const unit = (v) => {
  const length = Math.hypot(...v);
  return length > 0 ? v.map((part) => part / length) : [0, 0, 1];
};

export function wrapDegrees(degrees) {
  const turn = ((degrees % 360) + 360) % 360;
  return turn > 180 ? turn - 360 : turn;
}

const rounded = (value, digits) => Number(value.toFixed(digits));
const precise = (value) => Number(value.toPrecision(6));

// A camera with rounded numbers, for links and commands.
export function tidy(camera) {
  return {
    ...camera,
    azimuth: rounded(wrapDegrees(camera.azimuth), 2),
    elevation: rounded(camera.elevation, 2),
    roll: rounded(wrapDegrees(camera.roll), 2),
    zoom: precise(Math.min(ZOOM_MAX, Math.max(ZOOM_MIN, camera.zoom))),
    look_at: camera.look_at.map(precise),
  };
}

export const extent = (volume) => volume.dims.map((n, a) => (n - 1) * volume.spacing[a]);

export function diagonal(volume) {
  const length = Math.hypot(...extent(volume));
  return length > 0 ? length : Math.max(...volume.spacing);
}

export const worldOf = (volume, sample) => sample.map((s, a) => (s - (volume.dims[a] - 1) / 2) * volume.spacing[a]);
export const sampleOf = (volume, world) => world.map((w, a) => w / volume.spacing[a] + (volume.dims[a] - 1) / 2);

// The directions right and up on the screen; reversed in a mirrored picture.
export function directions(camera, mirror) {
  const [ca, sa] = [Math.cos(camera.azimuth * RADIANS), Math.sin(camera.azimuth * RADIANS)];
  const [ce, se] = [Math.cos(camera.elevation * RADIANS), Math.sin(camera.elevation * RADIANS)];
  const [cr, sr] = [Math.cos(camera.roll * RADIANS), Math.sin(camera.roll * RADIANS)];
  const right = [ca, sa, 0];
  const up = [-se * sa, se * ca, ce];
  const turned = sum([cr, right], [sr, up]);
  return {
    eye: [ce * sa, -ce * ca, se],
    right: mirror ? turned.map((part) => -part) : turned,
    up: sum([cr, up], [-sr, right]),
  };
}

// The size of a pixel in world length, at the centre of the picture.
export function pixelLength(camera, volume, height) {
  return diagonal(volume) / camera.zoom / height;
}

// From world to page: {x, y, depth}, in pixels from the top left of the picture; depth grows towards the eye. Null
// if the point is behind the eye.
export function projector(view, volume, width, height) {
  const { eye, right, up } = directions(view.camera, view.mirror);
  const pixel = pixelLength(view.camera, volume, height);
  const { fov, look_at } = view.camera;
  const distance = fov > 0 ? (pixel * height) / 2 / Math.tan((fov / 2) * RADIANS) : Infinity;
  return (world) => {
    const p = sum([1, world], [-1, look_at]);
    const depth = dot(p, eye);
    const scale = distance === Infinity ? 1 : distance / (distance - depth);
    if (scale <= 0) return null;
    return {
      x: width / 2 + (dot(p, right) * scale) / pixel,
      y: height / 2 - (dot(p, up) * scale) / pixel,
      depth,
    };
  };
}

// Movements: functions from camera to camera. dx and dy are pixels to the right and downwards.

export function orbited(camera, mirror, dx, dy, height) {
  const degrees = 200 / height;
  const side = mirror ? -dx : dx;
  const [c, s] = [Math.cos(camera.roll * RADIANS), Math.sin(camera.roll * RADIANS)];
  const across = side * c + dy * s;
  const down = dy * c - side * s;
  return {
    ...camera,
    azimuth: camera.azimuth - across * degrees,
    elevation: Math.min(90, Math.max(-90, camera.elevation + down * degrees)),
  };
}

export function panned(camera, mirror, volume, dx, dy, height) {
  const { right, up } = directions(camera, mirror);
  const pixel = pixelLength(camera, volume, height);
  return { ...camera, look_at: sum([1, camera.look_at], [-dx * pixel, right], [dy * pixel, up]) };
}

// The point at (x, y), in pixels from the centre, stays in place.
export function zoomed(camera, mirror, volume, factor, x, y, height) {
  const zoom = Math.min(ZOOM_MAX, Math.max(ZOOM_MIN, camera.zoom * factor));
  const share = 1 - camera.zoom / zoom;
  const moved = panned(camera, mirror, volume, -x * share, -y * share, height);
  return { ...moved, zoom };
}

// Turns the picture counter-clockwise by some degrees, with the pointer.
export function rolled(camera, mirror, clockwise) {
  return { ...camera, roll: camera.roll + (mirror ? -clockwise : clockwise) };
}

// The zoom at which the whole volume fits, from this direction, with a margin.
export function fittingZoom(camera, volume, width, height) {
  if (!(width > 1 && height > 1)) return 1; // the stage has no size yet
  const { right, up } = directions(camera, false);
  const size = extent(volume);
  const spans = [right, up].map((axis) => size.reduce((total, s, a) => total + s * Math.abs(axis[a]), 0));
  const pixel = Math.max(spans[0] / width, spans[1] / height, 1e-12);
  return precise(Math.min(ZOOM_MAX, (0.9 * diagonal(volume)) / (pixel * height)));
}

// The initial camera: the volume's default view; what is visible in it fills CVOL_FIT_SHARE of the stage.
const FIT_SHARE = 0.88;
export function homeCamera(volume, width, height) {
  const home = volume.home ?? { azimuth: 30, elevation: 15, roll: 0, look_at: [0, 0, 0] };
  const camera = {
    azimuth: home.azimuth,
    elevation: home.elevation,
    roll: home.roll,
    zoom: 1,
    fov: 0,
    look_at: home.look_at,
  };
  if (!home.size) return tidy({ ...camera, zoom: fittingZoom(camera, volume, width, height) });
  if (!(width > 1 && height > 1)) return tidy(camera); // the stage has no size yet
  const pixel = Math.max(home.size[0] / width, home.size[1] / height, 1e-12) / FIT_SHARE;
  return tidy({ ...camera, zoom: diagonal(volume) / (pixel * height) });
}
