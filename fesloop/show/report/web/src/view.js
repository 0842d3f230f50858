// The page of `fesloop view`: a hand whose frames come from a running viewer.
import { createBar } from "./bar.js";
import { createFeed } from "./feed.js";
import { createHand, transport } from "./hand.js";
import { handFigure } from "./hand_figure.js";
import { readPage } from "./numbers.js";

document.documentElement.classList.add("scripted");
const page = readPage(document.getElementById("numbers").textContent);
const spans = JSON.parse(document.getElementById("spans").textContent);
const note = document.getElementById("note");
const stage = document.querySelector(".stage");
const recorded = page.trials.length > 0;

const scene = createHand(stage, handFigure(page.parts.get("hand"), page.array));
const feed = createFeed(spans, ({ trial, time_s, hands, objects }) => {
  scene?.showFrame(hands, objects);
  Object.assign(stage.dataset, { trial, time: time_s });
}, (text, urgent) => {
  if (note.textContent === text) return;
  note.setAttribute("aria-live", urgent ? "polite" : "off"); // how far behind it is changes all the time
  note.textContent = text;
});
createBar(document.getElementById("bar"), page.trials, feed, recorded);
if (recorded) document.querySelector(".hand").append(transport(feed));
feed.open();
