// Numbers of a page, as Python left them in its JSON.

const LEVELS_BELOW = 32767; // the lowest of 65535 levels stands for the range's low end
const NONE = -32768;

/** What a page holds: its trials, the one shown first and at what time, and its parts with arrays in place of their numbers. */
export function readPage(text) {
  const { trials, shown, at, parts, arrays } = JSON.parse(text);
  const decoded = arrays.map(() => null);
  const array = (place) => (decoded[place] ??= decode(arrays[place]));
  return { trials, shown, at, parts: new Map(Object.entries(parts)), array };
}

/** An array as it was encoded: evenly spaced, 64-bit floats, whole numbers, or 16-bit levels. */
export function decode(encoded) {
  if ("count" in encoded) return evenlySpaced(encoded.from, encoded.to, encoded.count);
  if ("f8" in encoded) return new Float64Array(bytes(encoded.f8));
  if ("u4" in encoded) return new Uint32Array(bytes(encoded.u4));
  const levels = new Int16Array(bytes(encoded.i2));
  return Float64Array.from(levels, (level) =>
    level === NONE ? NaN : encoded.low + (level + LEVELS_BELOW) * encoded.step);
}

function evenlySpaced(from, to, count) {
  return Float64Array.from({ length: count }, (_, i) => from + ((to - from) * i) / (count - 1));
}

function bytes(base64) {
  return Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0)).buffer;
}
