// Numbers beside the hand of a view: trial and time, joint angles, what each channel gives.
import { element } from "./element.js";
import { roleColour } from "./colours.js";

const NAMES = { truth: "true", estimate: "tracker" };

/**
 * Fills `place`.
 *
 * @param readout {groups: [{title, joints}], hands, channels}: joints are in the order of a frame's angles
 * @returns show(frame)
 */
export function createReadout(place, { groups, hands, channels }) {
  const cells = []; // by joint, a cell a hand
  const title = element("h2");
  const tables = groups.map((group) => element("table", {}, element("caption", {}, `${group.title}, deg`),
    element("thead", {}, element("tr", {}, element("td"), ...hands.map((hand) => element("th", { scope: "col" }, NAMES[hand])))),
    element("tbody", {}, ...group.joints.map((joint) => {
      const row = hands.map(() => element("td"));
      cells.push(row);
      return element("tr", {}, element("th", { scope: "row" }, joint), ...row);
    }))));
  const strips = Array.from({ length: channels }, (_, channel) => pulseRow(channel));
  if (channels > 0) {
    tables.push(element("table", { class: "pulses" }, element("caption", {}, "Stimulation: bars are charge of a pulse"),
      element("tbody", {}, ...strips.map(({ row }) => row))));
  }
  place.replaceChildren(title, ...tables);
  place.hidden = tables.length === 0;
  let most = 0; // of all that was seen: bars have one scale

  return ({ trial, time_s, readings }) => {
    title.textContent = `Trial ${trial}, ${time_s.toFixed(2)} s`;
    hands.forEach((hand, i) => cells.forEach((row, joint) => {
      row[i].textContent = worded(readings.angles?.[hand]?.[joint]);
    }));
    const pulses = readings.pulses ?? [];
    most = Math.max(most, ...pulses.map(([current, width]) => current * width));
    strips.forEach(({ bar, text }, channel) => {
      const [current, width] = pulses[channel] ?? [null, null];
      bar.style.width = `${most > 0 ? (100 * current * width) / most : 0}%`;
      text.textContent = current * width > 0 ? `${current.toFixed(1)} mA · ${Math.round(width)} µs` : "off";
    });
  };
}

function pulseRow(channel) {
  const bar = element("i");
  bar.style.setProperty("--of", roleColour(`channel-${channel % 8}`));
  const text = element("td");
  const row = element("tr", {}, element("th", { scope: "row" }, `channel ${channel}`),
    element("td", {}, element("span", { class: "level", "aria-hidden": "true" }, bar)), text);
  return { row, bar, text };
}

/** An angle with one decimal, its minus sign a real one; a dash where it is not known. */
function worded(value) {
  return value === null || value === undefined ? "–" : value.toFixed(1).replace("-", "−");
}
