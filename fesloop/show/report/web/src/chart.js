// Lines over a common x, drawn by Observable Plot.
import * as Plot from "@observablehq/plot";
import { roleColour } from "./colours.js";
import { shape } from "./element.js";
import { END_STROKE, endPlaces, endWidth, keyRow } from "./key.js";
import { bandMark, strokeMark } from "./line_marks.js";
import { extent, lastValue, linesWith, toldAt } from "./lines.js";
import { markMarks } from "./marks.js";
import { createPlayHead } from "./play_head.js";
import { tellOf } from "./told.js";
import { shortened, SIZE, textWidth, widestTick } from "./text.js";

const ENDS_FROM = 620; // px: from this width on names stand at the lines' ends
const ENDS_MOST = 6; // lines that have room for their names there
const ENDS_SHARE = 0.26; // of the width, that names take there at most
const LEVEL_MOST = 140; // px, of a kind's name
const MARKS_HIGH = 14; // px, of the row of marks' names
const MARGIN = { top: 26, right: 14, bottom: 36, left: 46 }; // px

/** Draws a chart at a width, px; where `clock` is given and x is time, a click moves the play head there. */
export function drawChart(place, chart, array, width, clock) {
  const lines = linesWith(chart.lines, array);
  const alone = !place.closest(".multiples");
  const named = alone && width >= ENDS_FROM && lines.length > 1 && lines.length <= ENDS_MOST
    && endWidth(lines) <= ENDS_SHARE * width;
  const margins = {
    ...MARGIN, top: MARGIN.top + (chart.marks.length > 0 ? MARKS_HIGH : 0),
    right: MARGIN.right + (named ? endWidth(lines) : 0),
  };
  let svg = plotted(chart, lines, width, margins);
  place.replaceChildren(svg);
  const left = 16 + widestTick(svg);
  if (left > margins.left) {
    margins.left = left;
    svg = plotted(chart, lines, width, margins);
    place.replaceChildren(svg);
  }
  place.parentElement.querySelector(":scope > .key")?.remove();
  if (named) nameEnds(svg, lines, width - margins.right);
  else if (alone && lines.length > 1) place.before(keyRow(lines));
  moveLabel(svg, margins.right - MARGIN.right);

  const x = svg.scale("x");
  tellOf(place, svg, (at) => toldAt(chart, lines, x, at));
  if (!chart.timed || !clock) return {};
  return createPlayHead(svg, x, clock, svg.scale("y").range);
}

function plotted(chart, lines, width, { top, right, bottom, left }) {
  const [low, high] = chart.limits ?? padded(extent(lines.flatMap(({ y, low: l, high: h }) => [y, l, h])));
  const inner = width - left - right;
  const turned = turnedLevels(chart.x_levels, inner);
  const height = Math.round(Math.min(300, Math.max(190, width * 0.42))) + turned.height;
  return Plot.plot({
    width, height,
    marginTop: top, marginRight: right, marginBottom: bottom + turned.height, marginLeft: left,
    style: { fontFamily: "inherit", fontSize: `${SIZE}px`, background: "none", overflow: "visible" },
    x: { ...xScale(chart, lines), ...turned.options, label: chart.x_label, labelArrow: "none", labelAnchor: "right" },
    y: { domain: [low, high], label: chart.y_label, labelArrow: "none", ticks: Math.round(height / 55) },
    marks: [
      ...markMarks(chart.marks, extent(lines.map((line) => line.x)), inner),
      Plot.gridY({ stroke: "var(--rule)", strokeOpacity: 1, ticks: Math.round(height / 55) }),
      low < 0 && high > 0 ? Plot.ruleY([0], { stroke: "var(--faint)" }) : null,
      ...lines.map((line) => bandMark(line)),
      ...lines.map((line) => strokeMark(line)),
    ],
  });
}

/** Kinds whose names do not fit side by side stand upright; `height` is what that takes, px. */
function turnedLevels(levels, width) {
  const widest = Math.max(0, ...levels.map(textWidth));
  if (widest <= width / levels.length - 6 || levels.length === 0) return { options: {}, height: 0 };
  const long = Math.min(LEVEL_MOST, widest);
  return {
    options: { tickRotate: -90, tickFormat: (i) => shortened(levels[i] ?? "", long), labelOffset: long + 28 },
    height: long,
  };
}

function xScale(chart, lines) {
  const arrays = lines.map((line) => line.x);
  if (chart.x_levels.length > 0) {
    const last = chart.x_levels.length - 1;
    return {
      domain: [-0.4, last + 0.4], ticks: chart.x_levels.map((_, i) => i),
      tickFormat: (i) => chart.x_levels[i] ?? "", tickSize: 0,
    };
  }
  const ends = [...arrays, chart.marks.flatMap(({ at, until }) => [at, until])];
  if (chart.x_log) return { type: "log", domain: extent(ends.map((all) => [...all].filter((v) => v > 0))) };
  const whole = arrays.every((all) => all.every((value) => Number.isInteger(value)));
  const [low, high] = extent(ends);
  return {
    domain: low === high ? [low - 1, high + 1] : [low, high],
    ...(whole && high - low <= 12 ? { ticks: high - low, tickFormat: "d" } : {}),
  };
}

/** A domain with a little room, so that no line runs along the edge. */
function padded([low, high]) {
  const room = high > low ? 0.04 * (high - low) : Math.abs(high) * 0.1 || 1;
  return [low === 0 ? 0 : low - room, high === 0 ? 0 : high + room];
}

function nameEnds(svg, lines, x) {
  const y = svg.scale("y");
  const [bottom, top] = y.range;
  const wanted = lines.map((line) => y.apply(lastValue(line)));
  const shown = wanted.map((at) => (Number.isFinite(at) ? Math.min(bottom, Math.max(top, at)) : bottom));
  endPlaces(shown, top, bottom).forEach((at, i) => {
    svg.append(shape("line", {
      x1: x + 6, x2: x + 6 + END_STROKE, y1: at, y2: at, class: "of-end", stroke: roleColour(lines[i].role),
    }));
    const text = shape("text", { class: "end", x: x + 12 + END_STROKE, y: at, dy: "0.32em" });
    text.textContent = lines[i].name;
    svg.append(text);
  });
}

/** Brings the label of x under the end of its axis. */
function moveLabel(svg, by) {
  const label = svg.querySelector('[aria-label="x-axis label"]');
  label?.setAttribute("transform", `translate(${-by},0) ${label.getAttribute("transform") ?? ""}`);
}
