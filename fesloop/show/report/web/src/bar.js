// The bar that stays in sight: which trial, whether it plays, light or dark.
import { setTheme } from "./colours.js";
import { element, sign } from "./element.js";

const PLAY = "M8 5v14l11-7z";
const PAUSE = "M7 5h4v14H7zM13 5h4v14h-4z";
const BACK = "M15.5 5.5 9 12l6.5 6.5";
const ON = "M8.5 5.5 15 12l-6.5 6.5";

/** Fills the page's bar; `played`: whether there is something that plays. */
export function createBar(place, trials, clock, played) {
  if (trials.length > 1) place.append(trialChooser(trials, clock), trialPrinted(clock));
  if (played) place.append(playButton(clock), timeShown(clock));
  place.append(themeChooser());
}

/** A button that plays and pauses. */
export function playButton(clock) {
  const button = element("button", { type: "button", class: "play", onclick: clock.toggle });
  function show() {
    button.replaceChildren(sign(clock.state.playing ? PAUSE : PLAY));
    button.setAttribute("aria-label", clock.state.playing ? "Pause" : "Play");
  }
  clock.listen((what) => what === "playing" && show());
  show();
  return button;
}

/** The time at the play head, s; not read aloud each time it changes. */
export function timeShown(clock) {
  const shown = element("output", { class: "time", "aria-live": "off" });
  function show() {
    const { time, span } = clock.state;
    shown.textContent = `${time.toFixed(2)} of ${span[1].toFixed(2)} s`;
  }
  clock.listen((what) => (what === "time" || what === "span") && show());
  show();
  return shown;
}

function trialChooser(trials, clock) {
  const select = element("select", { id: "trial" }, ...trials.map((trial) =>
    element("option", { value: trial, selected: trial === clock.state.trial }, String(trial))));
  const step = (by) => {
    const next = trials[trials.indexOf(clock.state.trial) + by];
    if (next !== undefined) clock.choose(next);
  };
  const back = stepButton("Trial before", BACK, () => step(-1));
  const on = stepButton("Next trial", ON, () => step(1));
  function show() {
    select.value = String(clock.state.trial);
    back.disabled = clock.state.trial === trials[0];
    on.disabled = clock.state.trial === trials.at(-1);
  }
  select.addEventListener("change", () => clock.choose(Number(select.value)));
  clock.listen((what) => what === "trial" && show());
  show();
  return element("div", { class: "chooser" }, element("label", { for: "trial" }, "Trial"), back, select, on);
}

/** On paper nothing can be chosen: it is said which trial is shown. */
function trialPrinted(clock) {
  const printed = element("p", { class: "printed" });
  const show = () => { printed.textContent = `Shown: trial ${clock.state.trial}.`; };
  clock.listen((what) => what === "trial" && show());
  show();
  return printed;
}

function stepButton(label, path, onclick) {
  return element("button", { type: "button", class: "step", "aria-label": label, onclick }, sign(path));
}

function themeChooser() {
  const select = element("select", { id: "theme", "aria-label": "Colours" },
    ...["as the system", "light", "dark"].map((name) => element("option", { value: name }, name)));
  select.addEventListener("change", () => {
    setTheme(select.value === "as the system" ? undefined : select.value);
  });
  return element("div", { class: "theme" }, select);
}
