// The patient orientation of the sample axes, from the named views of the volume.

const RADIANS = Math.PI / 180;

function eyeOf({ azimuth, elevation }) {
  const [a, e] = [azimuth * RADIANS, elevation * RADIANS];
  return [Math.cos(e) * Math.sin(a), -Math.cos(e) * Math.cos(a), Math.sin(e)];
}

/**
 * [[low end, high end] of x, y, z] as letters R L A P I S; null if the file has no patient orientation.
 */
export function lettersOf(volume) {
  const { left, front, top } = volume.views || {};
  if (!volume.patient || !left || !front || !top) return null;
  const eyes = [left, front, top].map(eyeOf);
  const names = [
    ["L", "R"],
    ["A", "P"],
    ["S", "I"],
  ];
  return [0, 1, 2].map((axis) => {
    const along = eyes.map((eye) => eye[axis]);
    const k = along.map(Math.abs).indexOf(Math.max(...along.map(Math.abs)));
    const [at, opposite] = names[k];
    return along[k] > 0 ? [opposite, at] : [at, opposite];
  });
}

/** The name of slices perpendicular to an axis. */
export function planeName(letters, axis) {
  if (!letters) return "xyz"[axis].toUpperCase();
  const word = { L: "Sagittal", R: "Sagittal", A: "Coronal", P: "Coronal", S: "Axial", I: "Axial" };
  return word[letters[axis][0]];
}
