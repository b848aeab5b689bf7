// The meaning of samples: Hounsfield units if known, or the scale and offset of the file.

/** {to(sample), from(meaning), unit, step, text(sample)} of a volume (the description of api/1/volumes). */
export function meaningOf(volume) {
  const [scale, offset, unit] = volume?.rescale
    ? [...volume.rescale, "HU"]
    : [volume?.value_scale || 1, volume?.value_offset || 0, ""];
  const whole = /int/.test(volume?.type || "") && Number.isInteger(scale) && Number.isInteger(offset);
  const span = Math.abs(((volume?.max ?? 1) - (volume?.min ?? 0)) * scale) || 1;
  const digits = whole ? 0 : Math.max(0, 3 - Math.floor(Math.log10(span)));
  return {
    unit,
    step: whole ? 1 : 10 ** -digits,
    to: (sample) => scale * sample + offset,
    from: (meaning) => (meaning - offset) / scale,
    digits: Math.min(digits, 12),
    text(sample) {
      return shortNumber(scale * sample + offset, Math.min(digits, 12)) + (unit && ` ${unit}`);
    },
  };
}

/** A number as text, without needless digits and with a minus sign. */
export function shortNumber(value, digits = 3) {
  if (!Number.isFinite(value)) return "none";
  const size = Math.abs(value);
  const text =
    size !== 0 && (size >= 1e6 || size < 1e-4) ? value.toPrecision(4) : String(Number(value.toFixed(digits)));
  return text.replace("-", "\u2212");
}
