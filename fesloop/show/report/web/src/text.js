// How wide texts are in a figure, and numbers as texts.

export const SIZE = 12; // px, of the texts in figures
const FONT = `${SIZE}px system-ui, sans-serif`;
const measure = document.createElement("canvas").getContext("2d");
measure.font = FONT;

/** Width of a text in a figure, px. */
export function textWidth(text) {
  return measure.measureText(text).width;
}

/** Width of the widest number along the y axis of what Plot drew, px. */
export function widestTick(svg) {
  const ticks = [...svg.querySelectorAll('[aria-label="y-axis tick label"] text')];
  return Math.max(0, ...ticks.map(({ textContent }) => textWidth(textContent)));
}

/** A text, cut so that it is no wider than so many px. */
export function shortened(text, width) {
  if (textWidth(text) <= width) return text;
  let end = text.length - 1;
  while (end > 0 && textWidth(`${text.slice(0, end)}…`) > width) end -= 1;
  return `${text.slice(0, end).trimEnd()}…`;
}

/** A value with the name and the unit that stand in the label of its axis ("time, s"): "time 1.5 s". */
export function valued(label, value) {
  const unit = label.lastIndexOf(", ");
  return unit < 0 ? `${label} ${value}` : `${label.slice(0, unit)} ${value} ${label.slice(unit + 2)}`;
}

/** A number with so many digits, its minus sign a real one. */
export function number(value, digits = 4) {
  if (!Number.isFinite(value)) return "none";
  return String(Number(value.toPrecision(digits))).replace("-", "−");
}

/** A measured number with so many digits, zeros at its end among them, as tables show it; counts as they are. */
export function measured(value, digits = 3) {
  if (!Number.isFinite(value) || Number.isInteger(value) || Math.abs(value) >= 10 ** digits) return number(value, digits);
  return value.toPrecision(digits).replace("-", "−");
}
