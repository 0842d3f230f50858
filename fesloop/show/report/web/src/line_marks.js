// Marks of Plot for a line: its stroke, and the band about it; `more` says where they stand.
import * as Plot from "@observablehq/plot";
import { roleColour } from "./colours.js";

const FEW = 30; // points, up to which each is marked
const MANY = 200; // points, from which on they are small

const curveOf = ({ style }) => (style === "steps" ? "step-after" : "linear");

/** The interval or the extremes about a line, of points a bar each; null where there is none. */
export function bandMark(line, more = {}) {
  const { x, low, high, role, style } = line;
  if (low === null || high === null) return null;
  if (style === "points") {
    return Plot.ruleX(x, { x, y1: low, y2: high, stroke: roleColour(role), strokeOpacity: 0.6, clip: true, ...more });
  }
  return Plot.areaY(x, {
    x, y1: low, y2: high, fill: roleColour(role), fillOpacity: 0.2, curve: curveOf(line), clip: true, ...more,
  });
}

/** What lies between a line and 0. */
export function fillMark(line, more = {}) {
  const { x, y, role } = line;
  return Plot.areaY(x, {
    x, y1: 0, y2: y, fill: roleColour(role), fillOpacity: 0.2, curve: curveOf(line), clip: true, ...more,
  });
}

/** The line itself. */
export function strokeMark(line, more = {}) {
  const { x, y, role, style } = line;
  const colour = roleColour(role);
  if (style === "points") return Plot.dot(x, { x, y, fill: colour, r: x.length > MANY ? 1.6 : 3, ...more });
  const drawn = Plot.line(x, {
    x, y, stroke: colour, strokeWidth: 1.75, strokeDasharray: style === "dashed" ? "5 4" : undefined,
    strokeLinejoin: "round", curve: curveOf(line), clip: true, ...more,
  });
  const few = x.length <= FEW && style === "line";
  return few ? [drawn, Plot.dot(x, { x, y, fill: colour, r: 2.5, ...more })] : drawn;
}
