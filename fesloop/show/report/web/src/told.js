// What is pointed at in a figure, told beside the pointer.
import { element } from "./element.js";
import { roleColour } from "./colours.js";

/**
 * Tells of what is pointed at in `place`.
 *
 * @param svg the figure drawn there
 * @param find from x and y in it, px, to {head, rows: [{name, value, role}], x} or null
 */
export function tellOf(place, svg, find) {
  const box = element("div", { class: "told", hidden: true });
  place.append(box);

  function show(event) {
    const bounds = svg.getBoundingClientRect();
    const x = event.clientX - bounds.left;
    const found = find(x, event.clientY - bounds.top);
    box.hidden = found === null;
    if (found === null) return;
    box.replaceChildren(element("b", {}, found.head), ...found.rows.map(row));
    const at = found.x ?? x;
    const left = at + 12 + box.offsetWidth > bounds.width ? at - 12 - box.offsetWidth : at + 12;
    box.style.left = `${Math.max(0, left)}px`;
    box.style.top = `${Math.max(0, event.clientY - bounds.top - box.offsetHeight - 12)}px`;
  }

  svg.addEventListener("pointermove", show);
  svg.addEventListener("pointerdown", show);
  svg.addEventListener("pointerleave", () => { box.hidden = true; });
}

function row({ name, value, role }) {
  const shown = element("span", { class: "row" }, element("i", { class: "dot" }), name, element("span", { class: "value" }, value));
  if (role) shown.firstChild.style.background = roleColour(role);
  else shown.firstChild.remove();
  return shown;
}
