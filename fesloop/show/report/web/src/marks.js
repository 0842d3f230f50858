// Moments and stretches that have a name, behind a chart's lines.
import * as Plot from "@observablehq/plot";
import { shortened, textWidth } from "./text.js";

const LEAST = 24; // px: a name that would be cut to less is left out; pointing at it still tells it

/** Marks of Plot for a chart's marks; `ends` of x fill `width` px. */
export function markMarks(marks, ends, width) {
  if (marks.length === 0) return [];
  const across = width / (ends[1] - ends[0] || 1);
  const stretches = marks.filter(({ at, until }) => until > at);
  const moments = marks.filter(({ at, until }) => until <= at);
  return [
    Plot.rectX(stretches, {
      x1: "at", x2: "until", fill: (_, i) => (i % 2 ? "var(--stretch-other)" : "var(--stretch)"),
      title: "text",
    }),
    Plot.ruleX(moments, { x: "at", stroke: "var(--faint)", strokeDasharray: "2 3", title: "text" }),
    Plot.text(named(stretches, moments, across), {
      x: "at", text: "shown", frameAnchor: "top", textAnchor: "start", dx: 1, dy: -4, fill: "var(--quiet)",
      fontSize: 11, lineAnchor: "bottom",
    }),
  ];
}

/** Names with the room that each has before the next begins. */
function named(stretches, moments, across) {
  const all = [...stretches, ...moments].sort((a, b) => a.at - b.at);
  const found = [];
  let free = -Infinity;
  all.forEach((mark, i) => {
    const next = all.slice(i + 1).find(({ at }) => at > mark.at)?.at ?? Math.max(mark.until, mark.at + 1e9);
    const room = (Math.min(next, mark.until > mark.at ? mark.until : next) - mark.at) * across - 8;
    if (mark.at * across < free || room < LEAST) return;
    const shown = shortened(mark.text, room);
    free = mark.at * across + textWidth(shown) + 8;
    found.push({ at: mark.at, shown });
  });
  return found;
}
