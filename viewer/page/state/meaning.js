// The meaning of samples: Hounsfield units if known, or the scale and offset of the file; and numbers as text.

/** {to(sample), from(meaning), unit, step, digits, text(sample)} of a volume (the description of api/1/volumes).
 * digits: decimals that resolve a thousandth of the range of the samples, all of integers; below 0: tens, hundreds, ... */
export function meaningOf(volume) {
  const [scale, offset, unit] = volume?.rescale
    ? [...volume.rescale, "HU"]
    : [volume?.value_scale || 1, volume?.value_offset || 0, ""];
  const whole = /int/.test(volume?.type || "") && Number.isInteger(scale) && Number.isInteger(offset);
  const [min, max] = [volume?.min ?? 0, volume?.max ?? 1].map((sample) => scale * sample + offset);
  const digits = whole ? 0 : digitsOf(Math.abs(max - min) || Math.abs(max) || 1);
  return {
    unit,
    step: whole ? 1 : 10 ** -digits,
    to: (sample) => scale * sample + offset,
    from: (meaning) => (meaning - offset) / scale,
    digits,
    text(sample) {
      return shortNumber(scale * sample + offset, digits) + (unit && ` ${unit}`);
    },
  };
}

// Integers keep all digits up to ranges of a million.
function digitsOf(span) {
  const digits = 3 - Math.floor(Math.log10(span));
  return digits >= 0 ? Math.min(digits, 100) : Math.min(digits + 3, 0);
}

/** The value in units of 10^-digits. */
export function rounded(value, digits) {
  if (digits >= 0) return Number(value.toFixed(Math.min(digits, 100)));
  const unit = 10 ** -digits;
  return Math.round(value / unit) * unit;
}

/** A number as text in units of 10^-digits (or of four digits), without needless digits and with a minus sign. */
export function shortNumber(value, digits = digitsOf(Math.abs(value) || 1)) {
  if (!Number.isFinite(value)) return "none";
  const number = rounded(value, digits);
  const size = Math.abs(number);
  const short = size !== 0 && (size < 1e-4 || (size >= 1e6 && digits < 0));
  const text = short ? Number(number.toPrecision(12)).toExponential() : String(number);
  return text.replaceAll("-", "\u2212");
}
