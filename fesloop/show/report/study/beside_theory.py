"""How far simulation lies from theory, where both tell the same number."""

from __future__ import annotations

import numpy as np

from fesloop.analysis.study.results.axis_levels import level_text
from fesloop.show.figures.content import Content


def beside_theory(content: Content) -> str:
    """A sentence on cells at which theory has a value; empty where there are none."""
    if content.figure.theory != "stationary_cost":
        return ""
    off: list[float] = []
    held: list[bool] = []
    panels = {level_text(panel): panel for panel in content.panels if panel is not None}
    lines = {level_text(line): line for line in content.lines if line is not None}
    for overlay in content.overlays:
        panel = None if overlay.panel is None else panels[level_text(overlay.panel)]
        line = None if overlay.line is None else lines[level_text(overlay.line)]
        exact = dict(zip(overlay.x, overlay.y, strict=False))
        for cell in content.on(panel, line):
            value = exact.get(float(cell.levels[content.figure.x]))
            if value and np.isfinite(cell.value):
                off.append(100.0 * (cell.value / value - 1.0))
                held += [cell.low <= value <= cell.high] if np.isfinite(cell.high - cell.low) else []
    if not off:
        return ""
    within = f"; theory lies within {sum(held)} of {len(held)} intervals" if held else ""
    return f"Simulation lies {min(off):+.1f} to {max(off):+.1f} % off theory at {len(off)} cells{within}."
