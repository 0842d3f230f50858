"""Curves of a study with their intervals, a chart a panel; and points that were drawn."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from fesloop.analysis.study.results.axis_levels import AxisLevel, level_text
from fesloop.analysis.study.results.estimates import Estimate
from fesloop.show.figures.content import Content
from fesloop.show.figures.ends import curve_ends
from fesloop.show.report.parts import Chart, Line
from fesloop.show.report.study.headings import by

_ROLES = 8
_BESIDE = 0.12
"""How far points of different lines stand beside each other over text, of the distance of two levels."""


def curves(content: Content) -> Iterator[Chart]:
    """A chart of each panel: a line with a band for each level of `by`, theory dashed."""
    figure = content.figure
    limits = curve_ends(content)
    for number, panel in enumerate(content.panels):
        lines = [line for place, level in enumerate(content.lines)
                 if (line := _line(content, content.on(panel, level), place, level)) is not None]
        heading = content.level_label(figure.panels, panel)
        yield Chart(
            key=f"figure-{figure.name}-{number}", title=heading or content.metric_label,
            x_label=content.axis_label(figure.x), y_label=content.metric_label,
            lines=[*lines, *_theory(content, panel, limits)], limits=limits,
            x_levels=[] if content.x.numeric and not _even(content) else
            [level_text(level) for level in content.x.levels],
            x_log=content.x.kind == "log", text=_text(content, heading, lines))


def _even(content: Content) -> bool:
    """Whether levels stand one apart."""
    return content.x.kind == "even"


def _line(content: Content, cells: Sequence[Estimate], place: int, level: AxisLevel | None) -> Line | None:
    """Values of one line; points with bars where what is between them cannot be told."""
    if not cells:
        return None
    x = content.x.places_of([cell.levels[content.figure.x] for cell in cells])
    joined = content.x.numeric and not content.drawn
    if not content.x.numeric:
        x = x + _BESIDE * (place - 0.5 * (len(content.lines) - 1))
    value, low, high = (content.factor * np.array([getattr(cell, name) for cell in cells])
                        for name in ("value", "low", "high"))
    known = bool(np.isfinite(high - low).any())
    name = content.level_label(content.figure.by, level) or content.metric_label
    return Line(name=name, role=f"series-{place % _ROLES}", x=x, y=value, low=low if known else None,
                high=high if known else None, style="line" if joined else "points")


def _theory(content: Content, panel: AxisLevel | None, limits: tuple[float, float]) -> Iterator[Line]:
    """Overlays, each in the colour of its line; one without y stands upright."""
    lines = [level_text(line) for line in content.lines if line is not None]
    for overlay in content.overlays_on(panel):
        at = content.x.along(overlay.x)
        role, name = "theory", overlay.label
        if overlay.line is not None:
            role = f"series-{lines.index(level_text(overlay.line)) % _ROLES}"
            name = f"{content.level_label(content.figure.by, overlay.line)}: {overlay.label}"
        y = np.array(overlay.y, dtype=np.float64)
        if not len(overlay.y):
            at, y = np.repeat(at, 3), np.tile([*limits, np.nan], len(overlay.x))
        else:
            # What lies above the chart would be drawn over its title.
            y = np.where(y > limits[1], np.nan, y)
        yield Line(name=name, role=role, x=at, y=y, style="dashed")


def _text(content: Content, heading: str, lines: Sequence[Line]) -> str:
    shown = by(content.metric_label, [content.axis_label(content.figure.x)])
    where = f"{shown}, {heading}" if heading else shown
    told = [f"{line.name} {np.nanmin(line.y):.3g} to {np.nanmax(line.y):.3g}" for line in lines
            if np.isfinite(line.y).any()]
    return f"{where}: {'; '.join(told) or 'no value'}."
