// A chart's lines with their numbers, and what of them is nearest to an x.
import { number, valued } from "./text.js";

const BESIDE = 0.5; // of the distance of two levels: points of several lines stand beside each other

/** Lines with arrays in place of the arrays' places. */
export function linesWith(lines, array) {
  const some = (place) => (place === null ? null : array(place));
  return lines.map((line) => ({
    ...line, x: array(line.x), y: array(line.y), low: some(line.low), high: some(line.high),
  }));
}

/** Index of the number that is nearest to another; -1 where there is none. */
export function nearest(numbers, at) {
  let found = -1;
  for (let i = 0; i < numbers.length; i += 1) {
    if (!Number.isFinite(numbers[i])) continue;
    if (found < 0 || Math.abs(numbers[i] - at) < Math.abs(numbers[found] - at)) found = i;
  }
  return found;
}

/** Value of a line at x, as it is drawn; of points the one no farther than `reach`; NaN in a gap, and outside. */
export function valueAt({ x, y, style }, at, reach = 0) {
  if (style === "points") {
    const i = nearest(x, at);
    return i >= 0 && Math.abs(x[i] - at) <= reach ? y[i] : NaN;
  }
  const after = x.findIndex((value) => value > at);
  const last = (after < 0 ? x.length : after) - 1;
  if (last < 0) return NaN;
  if (x[last] === at) return y[last];
  if (after < 0) return NaN;
  if (style === "steps") return y[last];
  return y[last] + ((at - x[last]) / (x[after] - x[last])) * (y[after] - y[last]);
}

/** Whether a line stands upright: it has no value at an x. */
const isUpright = ({ x }) => x.length > 1 && x[0] === x[1];

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

/** What is told of lines where x, a scale, stands at so many px: of the x of the nearest point. */
export function toldAt({ x_label, x_levels = [] }, lines, x, at) {
  const pointed = x.invert(Math.min(Math.max(at, x.range[0]), x.range[1]));
  const points = lines.filter((line) => !isUpright(line));
  const known = points.map((line) => line.x[nearest(line.x, pointed)]);
  const levels = x_levels.length > 0;
  const shown = levels ? Math.round(pointed) : known[nearest(known, pointed)] ?? pointed;
  const value = (line) => number(valueAt(line, shown, levels ? BESIDE : 0));
  const rows = points.map((line) => ({ name: line.name, value: value(line), role: line.role }));
  return { head: x_levels[shown] ?? valued(x_label, number(shown)), rows, x: x.apply(shown) };
}
