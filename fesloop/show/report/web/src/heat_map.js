// A value in each cell of a grid, with curves over it, drawn by Observable Plot.
import * as Plot from "@observablehq/plot";
import { roleColour } from "./colours.js";
import { element } from "./element.js";
import { keyRow } from "./key.js";
import { linesWith } from "./lines.js";
import { number, shortened, SIZE, textWidth, valued } from "./text.js";
import { tellOf } from "./told.js";

const CELL_HIGH = 40; // px
const LABEL_MOST = 0.3; // of the width
const LEVEL_MOST = 140; // px, of a column's name

/** Draws a heat map at a width, px. */
export function drawHeatMap(place, heat, array, width) {
  const values = array(heat.values);
  const columns = heat.x_levels.length;
  const cells = Array.from(values, (value, i) => cell(heat, value, i % columns, Math.floor(i / columns)));
  const contours = linesWith(heat.contours, array);
  const svg = plotted(heat, cells, contours, width);
  place.replaceChildren(svg);
  place.parentElement.querySelectorAll(":scope > .key, :scope > .ramp").forEach((old) => old.remove());
  if (heat.low !== null) place.before(ramp(heat));
  if (contours.length > 0) place.before(keyRow(contours));
  const [x, y] = [svg.scale("x"), svg.scale("y")];
  tellOf(place, svg, (atX, atY) => {
    const [column, row] = [Math.round(x.invert(atX)), Math.round(y.invert(atY))];
    const told = heat.told[row]?.[column];
    if (told === undefined) return null;
    const [across, upwards] = [valued(heat.x_label, heat.x_levels[column]), valued(heat.y_label, heat.y_levels[row])];
    return { head: `${across}, ${upwards}`, rows: [{ name: told, value: "" }] };
  });
  return {};
}

/** A cell's colour runs from the good end (0) to the bad one (1); without ends it has none. */
function cell(heat, value, column, row) {
  const along = Math.min(1, Math.max(0, (value - heat.low) / (heat.high - heat.low || 1)));
  const bad = heat.better === "low" ? along : 1 - along;
  const known = heat.low !== null && Number.isFinite(value);
  return {
    column, row, text: heat.cells[row][column],
    fill: known ? ramped(bad) : "var(--no-value)", ink: known ? inkOn(bad) : "var(--quiet)",
  };
}

function ramped(bad) {
  const [from, to, share] = bad < 0.5 ? ["good", "middling", bad * 2] : ["middling", "bad", bad * 2 - 1];
  return `color-mix(in oklab, var(--heat-${to}) ${(share * 100).toFixed(1)}%, var(--heat-${from}))`;
}

/** Texts change their colour where the next stands out more: by WCAG's contrast, 4.5 or more throughout. */
function inkOn(bad) {
  if (bad < 0.5) return "var(--on-good)";
  return bad < 0.88 ? "var(--on-middling)" : "var(--on-bad)";
}

function plotted(heat, cells, contours, width) {
  const [columns, rows] = [heat.x_levels.length, heat.y_levels.length];
  const left = Math.min(width * LABEL_MOST, 18 + Math.max(...heat.y_levels.map(textWidth)));
  const across = (width - left - 8) / columns;
  const fits = cells.every(({ text }) => textWidth(text) < across - 4);
  const widest = Math.min(LEVEL_MOST, Math.max(...heat.x_levels.map(textWidth)));
  const upright = widest > across - 6;
  const every = Math.ceil((upright ? SIZE + 2 : 1) / across);
  const below = upright ? widest + 30 : 38;
  return Plot.plot({
    width, height: 26 + below + CELL_HIGH * rows,
    marginLeft: left, marginRight: 8, marginTop: 26, marginBottom: below,
    style: { fontFamily: "inherit", fontSize: `${SIZE}px`, background: "none", overflow: "visible" },
    x: {
      domain: [-0.5, columns - 0.5], label: heat.x_label, labelArrow: "none", labelAnchor: "right",
      ticks: heat.x_levels.map((_, i) => i).filter((i) => i % every === 0), tickSize: 0,
      tickFormat: (i) => shortened(heat.x_levels[i], LEVEL_MOST), tickRotate: upright ? -90 : 0,
      labelOffset: below - 4,
    },
    y: {
      domain: [-0.5, rows - 0.5], label: heat.y_label, labelArrow: "none", tickSize: 0,
      ticks: heat.y_levels.map((_, i) => i), tickFormat: (i) => shortened(heat.y_levels[i], left - 12),
    },
    marks: [
      Plot.rect(cells, {
        x1: ({ column }) => column - 0.5, x2: ({ column }) => column + 0.5,
        y1: ({ row }) => row - 0.5, y2: ({ row }) => row + 0.5, fill: { value: "fill", scale: null }, inset: 1, rx: 2,
      }),
      fits ? Plot.text(cells, { x: "column", y: "row", text: "text", fill: { value: "ink", scale: null } }) : null,
      ...contours.flatMap(({ x, y, role, style }) => [
        Plot.line(x, { x, y, stroke: "var(--paper)", strokeWidth: 5, strokeOpacity: 0.8, clip: true }),
        Plot.line(x, {
          x, y, stroke: roleColour(role), strokeWidth: 2.25, clip: true,
          strokeDasharray: style === "dashed" ? "6 4" : undefined,
        }),
      ]),
    ],
  });
}

function ramp(heat) {
  const [first, last] = heat.better === "low" ? [heat.low, heat.high] : [heat.high, heat.low];
  return element("p", { class: "ramp" }, `${heat.value_label} `, element("span", {}, number(first)),
    element("i", { class: "scale", "aria-hidden": true }), element("span", {}, number(last)));
}
