// Shares or sizes by name, as horizontal bars, drawn by Observable Plot.
import * as Plot from "@observablehq/plot";
import { roleColour } from "./colours.js";
import { keyRow } from "./key.js";
import { measured, number, shortened, SIZE, textWidth } from "./text.js";
import { tellOf } from "./told.js";

const BAR = { stacked: 26, beside: 14 }; // px, with the space about it
const NAME_MOST = 0.36; // of the width

/** Draws bars at a width, px. */
export function drawBars(place, bars, array, width) {
  const series = bars.series.map((each) => ({ ...each, values: array(each.values) }));
  const cells = series.flatMap(({ name, role, values }) =>
    bars.names.map((bar, i) => ({ bar: i, name, role, value: values[i] })));
  const left = Math.min(width * NAME_MOST, 16 + Math.max(...bars.names.map(textWidth)));
  const svg = plotted(bars, series, cells.filter(({ value }) => Number.isFinite(value)), width, left);
  place.replaceChildren(svg);
  place.parentElement.querySelector(":scope > .key")?.remove();
  if (series.length > 1) place.before(keyRow(series.map((each) => ({ ...each, style: "patch" }))));
  const rows = svg.scale(bars.stacked ? "y" : "fy");
  tellOf(place, svg, (_, y) => {
    const bar = bars.names.findIndex((_name, i) => y >= rows.apply(i) && y < rows.apply(i) + rows.bandwidth);
    if (bar < 0) return null;
    const told = cells.filter((cell) => cell.bar === bar);
    return {
      head: bars.names[bar],
      rows: told.map(({ name, role, value }) => ({ name, role, value: number(value) })),
    };
  });
  return {};
}

function plotted(bars, series, cells, width, left) {
  const rows = { label: null, tickFormat: (i) => shortened(bars.names[i], left - 12), tickSize: 0 };
  const many = bars.stacked ? 1 : series.length;
  const height = 44 + bars.names.length * (bars.stacked ? BAR.stacked : BAR.beside * many + 10);
  const colour = (cell) => roleColour(cell.role);
  const shown = Plot.text(cells, {
    x: "value", [bars.stacked ? "y" : "fy"]: "bar", ...(bars.stacked ? {} : { y: "name" }),
    text: (cell) => measured(cell.value), textAnchor: "start", dx: 5, fill: "var(--quiet)",
  });
  return Plot.plot({
    width, height, marginLeft: left, marginRight: 48, marginTop: 6, marginBottom: 36,
    style: { fontFamily: "inherit", fontSize: `${SIZE}px`, background: "none", overflow: "visible" },
    x: { label: bars.x_label, labelArrow: "none", labelAnchor: "right", ticks: Math.round(width / 110), zero: true },
    ...(bars.stacked
      ? { y: { ...rows, domain: bars.names.map((_, i) => i), padding: 0.25 } }
      : { fy: { ...rows, domain: bars.names.map((_, i) => i), padding: 0.2 },
          y: { axis: null, domain: series.map(({ name }) => name), padding: 0.1 } }),
    marks: [
      Plot.gridX({ stroke: "var(--rule)", strokeOpacity: 1, ticks: Math.round(width / 110) }),
      bars.stacked
        ? Plot.barX(cells, { x: "value", y: "bar", fill: colour, order: series.map(({ name }) => name), z: "name", insetRight: 1 })
        : Plot.barX(cells, { x: "value", fy: "bar", y: "name", fill: colour }),
      series.length === 1 || !bars.stacked ? shown : null,
      Plot.ruleX([0], { stroke: "var(--faint)" }),
    ],
  });
}
