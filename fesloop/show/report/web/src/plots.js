// Keeps each figure that can be seen drawn at its width, and the play head in those whose x is time.
import { drawBars } from "./bars.js";
import { drawChart } from "./chart.js";
import { drawHeatMap } from "./heat_map.js";
import { drawStrips } from "./strips.js";

const DRAW = { chart: drawChart, bars: drawBars, heat_map: drawHeatMap, strips: drawStrips };
const MARGIN = "300px"; // drawn a little before it comes into view

/**
 * @param figures [{element, part}], of charts, strips, bars and heat maps
 * @param array the page's arrays by place
 * @param clock the play head
 * @param played whether something plays, so that charts over time show the play head
 */
export function keepDrawn(figures, array, clock, played) {
  const byElement = new Map();
  for (const { element, part } of figures) {
    const place = element.querySelector(".plot");
    byElement.set(place, { place, part, width: 0, plot: null });
  }

  function draw(figure) {
    const width = Math.floor(figure.place.clientWidth);
    if (width === 0 || width === figure.width) return;
    figure.width = width;
    figure.plot = DRAW[figure.part.kind](figure.place, figure.part, array, width, played ? clock : null);
    figure.plot.showTime?.(clock.state.time);
  }

  const near = new Set();
  const resized = new ResizeObserver((entries) => entries.forEach(({ target }) => {
    if (near.has(target)) draw(byElement.get(target));
  }));
  const seen = new IntersectionObserver((entries) => entries.forEach(({ target, isIntersecting }) => {
    if (isIntersecting) near.add(target);
    else near.delete(target);
    if (isIntersecting) draw(byElement.get(target));
    if (isIntersecting) byElement.get(target).plot?.showTime?.(clock.state.time);
  }), { rootMargin: MARGIN });
  for (const place of byElement.keys()) {
    resized.observe(place);
    seen.observe(place);
  }

  clock.listen((what, { time }) => {
    if (what === "time") near.forEach((place) => byElement.get(place).plot?.showTime?.(time));
  });
  addEventListener("beforeprint", () => byElement.forEach(draw));
}
