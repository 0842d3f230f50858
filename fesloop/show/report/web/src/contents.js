// The contents tell where in the page the reader is.

/** Marks the entry of the section that is in view. */
export function followContents(nav) {
  const entries = new Map([...nav.querySelectorAll("a")].map((entry) => [entry.hash.slice(1), entry]));
  const inView = new Set();
  const seen = new IntersectionObserver((changes) => {
    for (const { target, isIntersecting } of changes) {
      if (isIntersecting) inView.add(target.id);
      else inView.delete(target.id);
    }
    const first = [...entries.keys()].find((key) => inView.has(key));
    for (const [key, entry] of entries) {
      if (key === first) entry.setAttribute("aria-current", "location");
      else entry.removeAttribute("aria-current");
    }
  }, { rootMargin: "-72px 0px -55% 0px" }); // under the bar, and above the lower half
  for (const key of entries.keys()) seen.observe(document.getElementById(decodeURIComponent(key)));
}
