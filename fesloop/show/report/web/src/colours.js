// Colours are the page's CSS variables: what is drawn once is right on light, on dark and on paper.

/** A role's colour, for CSS and SVG. */
export function roleColour(role) {
  return `var(--${role})`;
}

/** A role's colour as the page shows it now, for what cannot take a variable. */
export function shownColour(role) {
  const probe = document.createElement("span");
  probe.style.color = roleColour(role);
  document.body.append(probe);
  const { color } = getComputedStyle(probe);
  probe.remove();
  return color;
}

/** Calls `paint` whenever the page's colours have changed. */
export function onRepaint(paint) {
  document.documentElement.addEventListener("theme", paint);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", paint);
}

/** Sets the page's colours: "light", "dark", or as the system has it (undefined). */
export function setTheme(theme) {
  const root = document.documentElement;
  if (theme === undefined) delete root.dataset.theme;
  else root.dataset.theme = theme;
  root.dispatchEvent(new Event("theme"));
}

/** Paper is light: what is drawn in pixels is drawn anew for it. */
export function printLight() {
  let shown;
  addEventListener("beforeprint", () => {
    shown = document.documentElement.dataset.theme;
    setTheme("light");
  });
  addEventListener("afterprint", () => setTheme(shown));
}
