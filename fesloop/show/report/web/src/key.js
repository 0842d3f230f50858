// Which colour is what: a row over a figure, or names at the lines' ends.
import { element } from "./element.js";
import { roleColour } from "./colours.js";
import { textWidth } from "./text.js";

export const END_STROKE = 10; // px, of a line's colour before its name at its end
const LINE_HEIGHT = 15; // px
const BOLD = 1.12; // width of semibold letters, times that of upright ones (chosen: a little more than most)

/** A row of names, each with a stroke or a patch of its colour. */
export function keyRow(entries) {
  return element("ul", { class: "key" }, ...entries.map(({ name, role, style }) => {
    const swatch = element("span", { class: `swatch ${style}` });
    swatch.style.setProperty("--of", roleColour(role));
    return element("li", {}, swatch, name);
  }));
}

/** Width that names at the lines' ends take, px. */
export function endWidth(lines) {
  return 18 + END_STROKE + BOLD * Math.max(...lines.map(({ name }) => textWidth(name)));
}

/** Where names stand at the lines' ends: as near to their line as they can be without touching, px. */
export function endPlaces(wanted, top, bottom) {
  const order = wanted.map((at, i) => ({ at, i })).sort((a, b) => a.at - b.at);
  const places = order.map(({ at }) => at);
  for (let i = 1; i < places.length; i += 1) places[i] = Math.max(places[i], places[i - 1] + LINE_HEIGHT);
  let room = bottom;
  for (let i = places.length - 1; i >= 0; i -= 1) {
    places[i] = Math.max(top, Math.min(places[i], room));
    room = places[i] - LINE_HEIGHT;
  }
  const found = [];
  order.forEach(({ i }, rank) => { found[i] = places[rank]; });
  return found;
}
