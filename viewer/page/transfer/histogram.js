// A histogram as an SVG path, linear or logarithmic, over a range of values.

/** A path (SVG) in a box `width` by `height`, y downwards, of the values low to high. */
export function histogramPath({ min, max, bins }, { width, height, low, high, logarithmic }) {
  const { from, size, counts } = bars({ min, max, bins });
  const scaled = logarithmic ? (count) => Math.log10(1 + count) : (count) => count;
  const top = peak(counts.map(scaled), logarithmic);
  const x = (value) => ((value - low) / (high - low)) * width;
  let path = `M${x(from).toFixed(2)} ${height}`;
  counts.forEach((count, i) => {
    const y = (height * (1 - Math.min(1, scaled(count) / top))).toFixed(2);
    path += `L${x(from + i * size).toFixed(2)} ${y}L${x(from + (i + 1) * size).toFixed(2)} ${y}`;
  });
  return `${path}L${x(from + counts.length * size).toFixed(2)} ${height}Z`;
}

/** Bars: the bins, or one per integer if there are fewer integers than bins. */
function bars({ min, max, bins }) {
  const span = max - min;
  const size = span / bins.length;
  const filled = bins.filter((count) => count > 0).length;
  const gaps = bins.filter((count, i) => count === 0 && bins[i - 1] > 0 && bins[i + 1] > 0).length;
  if (!Number.isInteger(min) || !Number.isInteger(max) || span >= bins.length || gaps < 0.1 * filled)
    return { from: min, size: size || 1, counts: bins };
  const counts = new Array(span + 1).fill(0);
  bins.forEach((count, i) => (counts[Math.min(span, Math.ceil(i * size))] += count));
  return { from: min - 0.5, size: 1, counts };
}

/** The count at full height; linear bars ignore the peak of the background, which would flatten the rest. */
function peak(heights, logarithmic) {
  const sorted = [...heights].sort((a, b) => b - a);
  return (logarithmic ? sorted[0] : Math.min(sorted[0], 3 * sorted[Math.floor(sorted.length / 50)])) || 1;
}

/** The range of values without these shares of the samples at both ends. */
export function robustRange({ min, max, bins }, below = 0.005, above = 0.005) {
  const total = bins.reduce((sum, count) => sum + count, 0);
  const size = (max - min) / bins.length;
  let sum = 0;
  let low = min;
  let high = max;
  for (let i = 0; i < bins.length; i++) {
    if (sum <= below * total) low = min + i * size;
    sum += bins[i];
    if (sum >= (1 - above) * total) {
      high = min + (i + 1) * size;
      break;
    }
  }
  return high > low ? [low, high] : [min, max];
}

/** About `count` round values in a range. */
export function ticks(low, high, count) {
  const rough = (high - low) / count || 1;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((k) => k * power).find((s) => s >= rough);
  const result = [];
  for (let k = Math.ceil(low / step); k * step <= high + 1e-9 * step; k++) result.push(k * step + 0); // -0 is 0
  return result;
}
