"""Ends of the scales of a figure: of the ordinate of curves, of the colours of a heat map."""

from __future__ import annotations

import numpy as np

from fesloop.show.figures.content import Content

_ROOM = 0.06
"""Above what is drawn, as a share of what values span."""


def curve_ends(content: Content) -> tuple[float, float]:
    """Of the metric as it is shown, in all panels: from 0 where no value is below, shares to 100 %.

    Intervals and theory may reach far out, as those of two replicates do, or theory where a loop is about to
    become unstable: what lies further beyond the values than these span is cut.
    """
    values = content.factor * np.array([cell.value for cell in content.cells if np.isfinite(cell.value)])
    least, most = float(values.min(initial=0.0)), float(values.max(initial=0.0))
    span = most - least if most > least else 1.0
    beyond = [content.factor * cell.high for cell in content.cells]
    beyond += [float(y) for overlay in content.overlays for y in overlay.y]
    above = max((each for each in beyond if np.isfinite(each)), default=most)
    below = min((content.factor * cell.low for cell in content.cells if np.isfinite(cell.low)), default=least)
    high = 102.0 if content.share else float(np.clip(above, most, most + span)) + _ROOM * span
    low = 0.0 if least >= 0.0 else float(np.clip(below, least - span, least)) - _ROOM * span
    figure = content.figure
    low = low if figure.low is None else content.factor * figure.low
    high = high if figure.high is None else content.factor * figure.high
    return low, high


def colour_ends(content: Content) -> tuple[float, float]:
    """Of the metric as it is shown, in all panels: the figure's own, else its values'; shares to 100 %."""
    known = [cell.value for cell in content.cells if np.isfinite(cell.value)]
    ends = (0.0, 1.0) if content.share or not known else (min(known), max(known))
    low, high = (own if own is not None else found
                 for own, found in zip((content.figure.low, content.figure.high), ends, strict=True))
    return content.factor * low, content.factor * (high if high > low else low + 1.0)
