// The play head in a chart over time: it stands where the hand is, and a click moves both.

/** Adds a play head to a drawn chart; `x` is its scale, `heights` [from, to], px. */
export function createPlayHead(svg, x, clock, heights) {
  const head = document.createElementNS(svg.namespaceURI, "line");
  head.setAttribute("class", "play-head");
  head.setAttribute("y1", heights[0]);
  head.setAttribute("y2", heights[1]);
  svg.append(head);
  svg.classList.add("timed");
  const seek = ({ clientX }) => clock.seek(x.invert(clientX - svg.getBoundingClientRect().left));
  svg.addEventListener("click", seek);
  return {
    showTime(time) {
      const [first, last] = x.domain;
      head.style.visibility = time < first || time > last ? "hidden" : "visible";
      head.setAttribute("transform", `translate(${x.apply(time)},0)`);
    },
  };
}
