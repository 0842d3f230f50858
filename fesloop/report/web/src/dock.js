// The hand stays in sight: out of view it stands small at the page's side, if there is room (the style knows).
import { element } from "./element.js";

/** Lets `stage` stand at the side while its place in the page is out of view. */
export function createDock(stage) {
  const place = element("div", { class: "stage-place" });
  stage.before(place);
  place.append(stage);
  new IntersectionObserver(([{ isIntersecting }]) => {
    stage.classList.toggle("docked", !isIntersecting);
  }).observe(place);
}
