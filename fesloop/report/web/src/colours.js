// Colours are the page's CSS variables: what is drawn once is right on light, on dark and on paper.

/** A role's colour, for CSS and SVG. */
export function roleColour(role) {
  return `var(--${role})`;
}

/** A role's colour as the page shows it now, for what cannot take a variable. */
export function shownColour(role, element = document.documentElement) {
  return getComputedStyle(element).getPropertyValue(`--${role}`).trim();
}
