// A chart's lines with their numbers, and what of them is nearest to an x.
import { number } from "./text.js";

/** Lines with arrays in place of the arrays' places. */
export function linesWith(lines, array) {
  const some = (place) => (place === null ? null : array(place));
  return lines.map((line) => ({
    ...line, x: array(line.x), y: array(line.y), low: some(line.low), high: some(line.high),
  }));
}

/** Index of a line's point that has a value and is nearest to x; -1 where there is none. */
export function nearest({ x, y }, at) {
  let found = -1;
  for (let i = 0; i < x.length; i += 1) {
    if (Number.isFinite(y[i]) && (found < 0 || Math.abs(x[i] - at) < Math.abs(x[found] - at))) found = i;
  }
  return found;
}

/** Value of a line at x: of "steps" the one that holds there, else that of the nearest point; NaN outside. */
export function valueAt(line, at) {
  const i = nearest(line, at);
  if (i < 0) return NaN;
  return line.style === "steps" && line.x[i] > at && i > 0 ? line.y[i - 1] : line.y[i];
}

/** Last value of a line, at its end; NaN where it has none. */
export function lastValue({ y }) {
  return y.findLast(Number.isFinite) ?? NaN;
}

/** Lowest and highest finite number of arrays; [0, 1] where there is none. */
export function extent(arrays) {
  let low = Infinity;
  let high = -Infinity;
  for (const numbers of arrays) {
    for (const value of numbers ?? []) {
      if (!Number.isFinite(value)) continue;
      if (value < low) low = value;
      if (value > high) high = value;
    }
  }
  return low <= high ? [low, high] : [0, 1];
}

/** What is told of lines where x, a scale, stands at so many px. */
export function toldAt({ x_label, x_levels = [] }, lines, x, at) {
  const value = x.invert(Math.min(Math.max(at, x.range[0]), x.range[1]));
  const shown = x_levels.length > 0 ? Math.round(value) : value;
  const rows = lines.map((line) => ({ name: line.name, value: number(valueAt(line, shown)), role: line.role }));
  return { head: x_levels[shown] ?? `${number(shown)} ${x_label}`, rows, x: x.apply(shown) };
}
