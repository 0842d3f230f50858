// The page of `fesloop view`: a hand whose frames come from a running viewer.
import { createBar } from "./bar.js";
import { createFeed } from "./feed.js";
import { createHand, transport } from "./hand.js";
import { handFigure } from "./hand_figure.js";
import { readPage } from "./numbers.js";
import { createReadout } from "./readout.js";

document.documentElement.classList.add("scripted");
const page = readPage(document.getElementById("numbers").textContent);
const spans = JSON.parse(document.getElementById("spans").textContent);
const note = document.getElementById("note");
const stage = document.querySelector(".stage");
const recorded = page.trials.length > 0;

const scene = createHand(stage, handFigure(page.parts.get("hand"), page.array));
const showNumbers = createReadout(document.getElementById("readout"),
  JSON.parse(document.getElementById("read").textContent));
const feed = createFeed(spans, page.shown, (frame) => {
  const { trial, time_s, hands, objects } = frame;
  scene?.showFrame(hands, objects);
  showNumbers(frame);
  Object.assign(stage.dataset, { trial, time: time_s });
}, (text, urgent) => {
  if (note.textContent === text) return;
  note.setAttribute("aria-live", urgent ? "polite" : "off"); // how far behind it is changes all the time
  note.textContent = text;
});
createBar(document.getElementById("bar"), page.trials, feed, recorded);
if (recorded) document.querySelector(".hand").append(transport(feed));
feed.open();
