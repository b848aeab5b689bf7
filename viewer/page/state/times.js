// Times of a volume: which one a view shows, and their text.

// The time of a view in a volume: that of the view if the volume has it.
export const timeIn = (volume, time) => Math.max(0, Math.min(time, (volume?.times ?? 1) - 1));

// The time of another volume that belongs to a time of this one: the same, if both have as many.
export const timeOf = (other, volume, time) => (other?.times === volume?.times ? time : 0);

// The time of the other picture of a comparison: the chosen one, if that is of the same volume.
export function comparedTime(comparison, volume, other, time) {
  return other?.id === volume?.id ? timeIn(volume, comparison.time) : timeOf(other, volume, time);
}

const rounded = (value) => String(Number(value.toPrecision(6))).replace("-", "\u2212");

// "12 s"; "" if the file does not state it.
export function valueText({ time_values: values, time_unit: unit }, time) {
  const value = values?.[time];
  if (!Number.isFinite(value) || (!unit && value === time)) return "";
  return unit ? `${rounded(value)} ${unit}` : rounded(value);
}

// "Time 3 of 0 to 11, 6 s", for screen readers.
export function spokenTime(volume, time) {
  return [`Time ${time} of 0 to ${volume.times - 1}`, valueText(volume, time)].filter(Boolean).join(", ");
}
