// The hand stays in sight: once scrolled past it stands small at the page's side, if there is room (the style knows).
import { element } from "./element.js";

/** Lets `stage` stand at the side while its place in the page is above what is in view. */
export function createDock(stage) {
  const place = element("div", { class: "stage-place" });
  stage.before(place);
  place.append(stage);
  new IntersectionObserver((entries) => {
    const { isIntersecting, boundingClientRect } = entries.at(-1);
    stage.classList.toggle("docked", !isIntersecting && boundingClientRect.bottom < innerHeight / 2);
  }).observe(place);
}
