// Numbers and lengths as text.

const BYTES = ["bytes", "kB", "MB", "GB", "TB"];

export function bytesText(bytes) {
  let size = bytes;
  let name = 0;
  while (size >= 999.5 && name < BYTES.length - 1) {
    size /= 1000;
    name++;
  }
  return `${name ? size.toPrecision(3) : size} ${size === 1 && !name ? "byte" : BYTES[name]}`;
}

// "1/30" of the raw bytes; of files that are larger "93 times".
export function ratioText(ratio) {
  return ratio < 1 ? `${Number((1 / ratio).toPrecision(3))} times` : `1/${Number(ratio.toPrecision(3))}`;
}

const METRES = { nm: 1e-9, um: 1e-6, µm: 1e-6, mm: 1e-3, cm: 1e-2, m: 1, km: 1e3 };
const LENGTHS = [
  ["nm", 1e-9],
  ["µm", 1e-6],
  ["mm", 1e-3],
  ["m", 1],
  ["km", 1e3],
];

// A length in its unit, or in another one if the number would be too large or too small.
export function lengthText(length, unit) {
  const known = METRES[unit];
  let [shown, name] = [length, unit];
  if (known && (length >= 1000 || length < 0.1)) {
    const metres = length * known;
    const [best, size] = LENGTHS.findLast(([, metre]) => metres >= metre * 0.999) ?? LENGTHS[0];
    [shown, name] = [metres / size, best];
  }
  const text = String(Number(shown.toPrecision(6)));
  return name ? `${text} ${name === "um" ? "µm" : name}` : text;
}

// The largest of 1, 2, 5 times a power of ten that is at most `length`.
export function roundLength(length) {
  const power = 10 ** Math.floor(Math.log10(length));
  return [5, 2, 1].find((digit) => digit * power <= length * (1 + 1e-9)) * power;
}
