// A report comes to life: its parts are drawn, the trial is chosen, the play head links the hand and charts.
import { createBar } from "./bar.js";
import { printLight } from "./colours.js";
import { createClock } from "./clock.js";
import { followContents } from "./contents.js";
import { createHand } from "./hand.js";
import { handFigure } from "./hand_figure.js";
import { keyRow } from "./key.js";
import { readPage } from "./numbers.js";
import { keepDrawn } from "./plots.js";
import { offerSaving } from "./saved.js";

document.documentElement.classList.add("scripted");
const page = readPage(document.getElementById("numbers").textContent);
const clock = createClock(page.shown);
const figures = [...document.querySelectorAll("[data-part]")].map((element) => ({
  element,
  part: page.parts.get(element.dataset.part),
}));
const hands = figures.filter(({ part }) => part.kind === "hand");
const drawings = figures.filter(({ part }) => part.kind !== "hand");

followContents(document.querySelector(".contents"));
createBar(document.getElementById("bar"), page.trials, clock, hands.length > 0);
for (const { element, part } of hands) {
  createHand(element.querySelector(".stage"), handFigure(part, page.array), clock);
}
for (const group of document.querySelectorAll(".multiples")) {
  const { part } = drawings.find(({ element }) => group.contains(element));
  if (part.kind === "chart" && part.lines.length > 1) group.prepend(keyRow(part.lines));
}
if (page.at !== null) clock.open(page.at);
offerSaving(drawings, document.querySelectorAll("figure.drawing"), page.array);
printLight();
keepDrawn(drawings, page.array, clock, hands.length > 0);

clock.listen((what, { trial }) => {
  if (what !== "trial") return;
  for (const element of document.querySelectorAll("[data-trial]")) {
    element.hidden = Number(element.dataset.trial) !== trial;
  }
});
