// What a figure shows, saved: its numbers as CSV, and itself as SVG.
import { element, shape } from "./element.js";
import { roleColour } from "./colours.js";
import { linesWith } from "./lines.js";
import { SIZE, textWidth } from "./text.js";

const DIGITS = 7; // a page keeps numbers to some 1e-5 of their range
const EDGE = 16; // px, about a saved figure
const ROW = 20; // px, of the title and of each row of names
const STYLES = [
  "fill", "fill-opacity", "stroke", "stroke-width", "stroke-opacity", "stroke-dasharray", "stroke-linejoin", "opacity",
  "font-family", "font-size", "font-weight", "text-anchor", "dominant-baseline", "paint-order", "visibility",
];

/** Gives each figure buttons that save it; drawings, which have no numbers, only as SVG. */
export function offerSaving(figures, drawings, array) {
  for (const { element: figure, part } of figures) {
    figure.append(buttons(figure, [
      ["CSV", "the numbers", () => save(figure, "csv", "text/csv", csvOf(part, array))],
      ["SVG", "the figure", () => saveSvg(figure, namesOf(part))],
    ]));
  }
  for (const figure of drawings) {
    figure.append(buttons(figure, [["SVG", "the figure", () => saveSvg(figure, [])]]));
  }
}

function buttons(figure, kinds) {
  const title = figure.querySelector("figcaption").textContent;
  return element("div", { class: "save" }, ...kinds.map(([kind, what, onclick]) => element("button", {
    type: "button", class: "quiet", onclick, title: `Save ${what} as ${kind}`,
    "aria-label": `Save ${what} of "${title}" as ${kind}`,
  }, kind)));
}

/** Table of a figure's numbers, as text; one row a point, bar or cell. */
function csvOf(part, array) {
  const rows = { chart: rowsOfLines, strips: rowsOfLines, bars: rowsOfBars, heat_map: rowsOfCells }[part.kind](part, array);
  return rows.map((row) => row.map(quoted).join(",")).join("\r\n") + "\r\n";
}

function rowsOfLines({ lines, x_label, y_label, x_levels = [] }, array) {
  const all = linesWith(lines, array);
  const banded = all.some(({ low }) => low !== null);
  const head = ["series", x_label, y_label, ...(banded ? ["lowest", "highest"] : [])];
  return [head, ...all.flatMap(({ name, x, y, low, high }) => Array.from(x, (at, i) => [
    name, x_levels[at] ?? digits(at), digits(y[i]), ...(banded ? [digits(low?.[i]), digits(high?.[i])] : []),
  ]))];
}

function rowsOfBars({ names, series, x_label }, array) {
  const rows = series.flatMap(({ name, values }) => names.map((bar, i) => [bar, name, digits(array(values)[i])]));
  return [["name", "series", x_label], ...rows];
}

function rowsOfCells({ x_label, y_label, value_label, x_levels, y_levels, values }, array) {
  const cells = Array.from(array(values), (value, i) => [
    x_levels[i % x_levels.length], y_levels[Math.floor(i / x_levels.length)], digits(value),
  ]);
  return [[x_label, y_label, value_label], ...cells];
}

/** A number as text, empty where there is none. */
function digits(value) {
  return Number.isFinite(value) ? String(Number(value.toPrecision(DIGITS))) : "";
}

function quoted(text) {
  return /[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
}

/** Names and roles of what has a colour; none where there is only one. */
function namesOf({ kind, lines, series, contours }) {
  if (kind === "strips") return [];
  const entries = lines ?? series ?? contours ?? [];
  return entries.length > 1 || kind === "heat_map" ? entries : [];
}

/** Saves the figure as it is drawn, on white paper, with its title and the names of its colours. */
function saveSvg(figure, names) {
  const drawn = figure.querySelector(".plot > svg, .picture > svg");
  const { dataset } = document.documentElement;
  const theme = dataset.theme;
  dataset.theme = "light";
  try {
    const { width, height } = drawn.getBoundingClientRect();
    save(figure, "svg", "image/svg+xml", new XMLSerializer().serializeToString(sheet(figure, drawn, width, height, names)));
  } finally {
    if (theme === undefined) delete dataset.theme;
    else dataset.theme = theme;
  }
}

function sheet(figure, drawn, width, height, names) {
  const whole = [width + 2 * EDGE, height + 2 * EDGE + ROW];
  const page = shape("svg", { xmlns: "http://www.w3.org/2000/svg", "font-family": "system-ui, sans-serif", "font-size": SIZE });
  const title = shape("text", { x: EDGE, y: EDGE + 8, "font-size": SIZE + 3, "font-weight": 600 });
  title.textContent = figure.querySelector("figcaption").textContent;
  page.append(shape("rect", { width: "100%", height: "100%", fill: "white" }), title);
  const key = names.length > 0 && !drawn.querySelector(".end") ? keyOf(figure, names, width) : null;
  if (key) {
    page.append(key.group);
    whole[1] += key.height;
  }
  const copy = resolved(drawn);
  for (const [name, value] of Object.entries({ x: EDGE, y: EDGE + ROW + (key?.height ?? 0), width, height })) {
    copy.setAttribute(name, value);
  }
  page.append(copy);
  page.setAttribute("width", whole[0]);
  page.setAttribute("height", whole[1]);
  page.setAttribute("viewBox", `0 0 ${whole[0]} ${whole[1]}`);
  return page;
}

function keyOf(figure, names, width) {
  const group = shape("g");
  let [x, y] = [EDGE, EDGE + ROW + 6];
  for (const { name, role } of names) {
    const wide = 22 + textWidth(name);
    if (x > EDGE && x + wide > EDGE + width) [x, y] = [EDGE, y + ROW];
    const text = shape("text", { x: x + 15, y: y + 4 });
    text.textContent = name;
    group.append(shape("rect", { x, y: y - 5, width: 10, height: 10, fill: shown(figure, role) }), text);
    x += wide + 10;
  }
  return { group, height: y - EDGE - ROW + 12 };
}

function shown(figure, role) {
  return getComputedStyle(figure).getPropertyValue(roleColour(role).slice(4, -1)).trim();
}

/** A copy that needs no style sheet, without the play head. */
function resolved(drawn) {
  const copy = drawn.cloneNode(true);
  const copies = [copy, ...copy.querySelectorAll("*")];
  [drawn, ...drawn.querySelectorAll("*")].forEach((each, i) => {
    const style = getComputedStyle(each);
    for (const { name, value } of [...copies[i].attributes]) {
      if (value.includes("var(--")) copies[i].removeAttribute(name); // said in `style` from here on
    }
    for (const name of STYLES) copies[i].style.setProperty(name, style.getPropertyValue(name));
  });
  copy.querySelectorAll(".play-head, style").forEach((each) => each.remove());
  return copy;
}

function save(figure, suffix, type, text) {
  const page = decodeURIComponent(location.pathname.split("/").at(-1)).replace(/\.html?$/i, "") || "report";
  const address = URL.createObjectURL(new Blob([text], { type: `${type};charset=utf-8` }));
  element("a", { href: address, download: `${page}_${figure.id.replace("part-", "")}.${suffix}` }).click();
  setTimeout(() => URL.revokeObjectURL(address), 10_000);
}
