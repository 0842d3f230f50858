// The hand in motion: as it was (solid) and as the tracker had it (translucent), played by a clock.
import { playButton, timeShown } from "./bar.js";
import { element } from "./element.js";
import { createDock } from "./dock.js";
import { framesOf } from "./hand_figure.js";
import { placesOf } from "./hand_places.js";
import { posesAt } from "./hand_pose.js";
import { createScene, drawsInDepth } from "./hand_scene.js";
import { keyRow } from "./key.js";

const SPEEDS = [0.1, 0.25, 0.5, 1, 2];
const NAMES = { truth: "true hand", estimate: "as the tracker had it" };

/**
 * Draws hands into `stage` and, where there is a clock, controls under it.
 *
 * @param figure {shapes, objects, view, motions}: see hand_figure.js
 * @param clock the play head; left out where frames are shown as they come
 * @returns showFrame(hands, objects), showHand(name, whether), reset(); null where nothing can be drawn
 */
export function createHand(stage, figure, clock) {
  if (!drawsInDepth()) {
    stage.replaceWith(element("p", { class: "notice" }, "This browser does not draw in three dimensions (WebGL 2 is off)."));
    return null;
  }
  stage.tabIndex = 0;
  stage.setAttribute("role", "application");
  stage.setAttribute("aria-roledescription", "hand that can be turned: arrows turn, plus and minus zoom, Home resets");
  const scene = createScene(stage, figure, placesOf(figure));
  const tools = element("div", { class: "tools" }, shownHands(figure, scene), element("button",
    { type: "button", class: "quiet", onclick: scene.reset }, "Reset view"));
  createDock(stage);
  stage.parentElement.before(tools);
  if (clock) {
    stage.parentElement.after(transport(clock));
    follow(stage, figure, clock, scene);
  }
  return scene;
}

/** Shows what the clock says. */
function follow(stage, { motions }, clock, scene) {
  const gone = element("p", { class: "gone", hidden: true }, "The hand's motion in this trial is not in this report.");
  stage.parentElement.after(gone);

  function show() {
    const motion = motions.get(clock.state.trial);
    if (!motion) return;
    const at = (clock.state.time - motion.start) / motion.step;
    const hands = Object.fromEntries(Object.entries(motion.hands).map(([name, poses]) => [name, posesAt(poses, at)]));
    scene.showFrame(hands, posesAt(motion.objects, at));
  }

  function choose() {
    const motion = motions.get(clock.state.trial);
    gone.hidden = motion !== undefined;
    if (!motion) {
      clock.pause();
      clock.setSpan(0, 0);
      scene.showFrame({}, []);
      return;
    }
    clock.setSpan(motion.start, motion.start + motion.step * Math.max(framesOf(motion) - 1, 0));
    clock.seek(clock.state.span[0]);
  }

  clock.listen((what) => {
    if (what === "time") show();
    if (what === "trial") choose();
  });
  stage.addEventListener("keydown", (event) => {
    if (event.key !== " ") return;
    clock.toggle();
    event.preventDefault();
  });
  choose();
}

/** Play, a slider over the trial, its time and the speed. */
export function transport(clock) {
  const slider = element("input", { type: "range", min: 0, max: 1000, value: 0, step: 1, "aria-label": "Time in the trial" });
  slider.addEventListener("input", () => {
    const [first, last] = clock.state.span;
    clock.seek(first + ((last - first) * slider.value) / 1000);
  });
  clock.listen((what, { time, span: [first, last] }) => {
    if (what !== "time" && what !== "span") return;
    slider.value = last > first ? Math.round((1000 * (time - first)) / (last - first)) : 0;
    slider.setAttribute("aria-valuetext", `${time.toFixed(2)} s of ${last.toFixed(2)} s`);
  });
  const speed = element("select", { "aria-label": "Speed" }, ...SPEEDS.map((times) =>
    element("option", { value: times, selected: times === clock.state.speed }, `${times} ×`)));
  speed.addEventListener("change", () => clock.setSpeed(Number(speed.value)));
  return element("div", { class: "transport" }, playButton(clock), slider, timeShown(clock), speed);
}

/** Which hand is which; each can be left out. */
function shownHands({ shapes }, scene) {
  const names = Object.keys(shapes);
  const row = keyRow(names.map((name) => ({ name: NAMES[name] ?? name, role: `hand-${name}`, style: "patch" })));
  [...row.children].forEach((entry, i) => {
    const box = element("input", { type: "checkbox", checked: true });
    box.addEventListener("change", () => scene.showHand(names[i], box.checked));
    entry.replaceChildren(element("label", {}, box, ...entry.childNodes));
  });
  return row;
}
