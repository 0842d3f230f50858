// Lines below each other, each in a strip of its own over the same x: in one frame they would hide each other.
import * as Plot from "@observablehq/plot";
import { bandMark, fillMark, strokeMark } from "./line_marks.js";
import { extent, linesWith, toldAt } from "./lines.js";
import { createPlayHead } from "./play_head.js";
import { SIZE, widestTick } from "./text.js";
import { tellOf } from "./told.js";

const STRIP = { least: 36, most: 80, all: 200 }; // px high, and of all together where they are few
const NAME_HIGH = 18; // px, over each strip
const MARGIN = { top: 22 + NAME_HIGH, right: 14, bottom: 36, left: 46 }; // px

/** Draws strips at a width, px; where `clock` is given and x is time, a click moves the play head there. */
export function drawStrips(place, strips, array, width, clock) {
  const lines = linesWith(strips.lines, array);
  const stripHigh = Math.round(Math.min(STRIP.most, Math.max(STRIP.least, STRIP.all / lines.length)));
  const height = MARGIN.top + lines.length * (stripHigh + NAME_HIGH) - NAME_HIGH + MARGIN.bottom;
  let svg = plotted(strips, lines, { width, height, stripHigh, left: MARGIN.left });
  place.replaceChildren(svg);
  const left = 16 + widestTick(svg);
  if (left > MARGIN.left) {
    svg = plotted(strips, lines, { width, height, stripHigh, left });
    place.replaceChildren(svg);
  }
  const x = svg.scale("x");
  tellOf(place, svg, (at) => toldAt(strips, lines, x, at));
  if (!strips.timed || !clock) return {};
  return createPlayHead(svg, x, clock, [height - MARGIN.bottom, MARGIN.top]);
}

function plotted(strips, lines, { width, height, stripHigh, left }) {
  const domain = strips.limits ?? extent(lines.flatMap((line) => [line.y, line.low, line.high]));
  const [low, high] = domain[0] === domain[1] ? [domain[0], domain[0] + 1] : domain;
  const ticks = roundEnds(low, high);
  const ends = extent(lines.map((line) => line.x));
  const from0 = low <= 0 && high > 0;
  return Plot.plot({
    width, height,
    marginTop: MARGIN.top, marginRight: MARGIN.right, marginBottom: MARGIN.bottom, marginLeft: left,
    style: { fontFamily: "inherit", fontSize: `${SIZE}px`, background: "none", overflow: "visible" },
    x: {
      domain: ends[0] === ends[1] ? [ends[0] - 1, ends[1] + 1] : ends, label: strips.x_label, labelArrow: "none",
      labelAnchor: "right",
    },
    y: { domain: [low, high], label: null, ticks },
    fy: {
      domain: lines.map((_, i) => i), axis: null, paddingOuter: 0,
      paddingInner: NAME_HIGH / (stripHigh + NAME_HIGH),
    },
    marks: [
      Plot.gridY({ stroke: "var(--rule)", strokeOpacity: 1, ticks }),
      Plot.text([strips.y_label], {
        frameAnchor: "top-left", lineAnchor: "bottom", textAnchor: "start", dx: 4 - left, dy: -NAME_HIGH - 4,
        fy: () => 0,
      }),
      Plot.text(lines, {
        text: "name", fy: (_, i) => i, frameAnchor: "top-left", lineAnchor: "bottom", textAnchor: "start", dy: -3,
        fontWeight: 600,
      }),
      ...lines.flatMap((line, i) => {
        const strip = { fy: () => i };
        return [from0 ? fillMark(line, strip) : null, bandMark(line, strip), strokeMark(line, strip)];
      }),
    ],
  });
}

/** The lowest and the highest multiple of a power of ten between two numbers: a strip has room for no more. */
function roundEnds(low, high) {
  const step = 10 ** Math.floor(Math.log10(high - low));
  if (!Number.isFinite(step)) return [low, high];
  return [Math.ceil(low / step) * step, Math.floor(high / step) * step];
}
