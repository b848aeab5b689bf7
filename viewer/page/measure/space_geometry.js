// Measurements as lines in space.

const SIDES = 48; // of an ellipse

/** The lines of a measurement, each a list of places in samples. */
export function linesOf({ kind, points, box }) {
  if (!box) return [points];
  const faces = [0, 1, 2].map((a) => [box[2 * a] - 0.5, box[2 * a + 1] - 0.5]);
  const pairs = [
    [0, 1],
    [1, 2],
    [2, 0],
  ];
  if (kind === "ellipsoid") {
    const middle = faces.map(([from, to]) => (from + to) / 2);
    const radius = faces.map(([from, to]) => (to - from) / 2);
    const ellipse = ([a, b]) =>
      Array.from({ length: SIDES + 1 }, (_, i) => {
        const angle = (2 * Math.PI * i) / SIDES;
        const place = [...middle];
        place[a] += radius[a] * Math.cos(angle);
        place[b] += radius[b] * Math.sin(angle);
        return place;
      });
    const flat = pairs.filter((pair) => pair.every((a) => box[2 * a + 1] - box[2 * a] > 1));
    return (flat.length === 1 ? flat : pairs).map(ellipse);
  }
  const corner = (...ends) => ends.map((end, a) => faces[a][end]);
  return [0, 1].flatMap((z) => [
    [corner(0, 0, z), corner(1, 0, z), corner(1, 1, z), corner(0, 1, z), corner(0, 0, z)],
    ...(z ? [[0, 0], [1, 0], [1, 1], [0, 1]].map(([x, y]) => [corner(x, y, 0), corner(x, y, 1)]) : []),
  ]);
}
