"""Panels of a study's figures, and levels of its axes to scale or as categories."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fesloop.picture.palette import INK
from fesloop.study.axis_levels import AxisLevel, is_numeric, level_text
from fesloop.study.results import StudyResults

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Drawing

Array = NDArray[np.float64]
_MOST_ABREAST = 4
_LEAST_APART = 0.055
"""Of labelled levels, as a share of the axis."""
_LONG_TEXT = 5


def places(levels: Sequence[AxisLevel]) -> Array:
    """Where levels stand on an axis: numbers to scale, text one apart."""
    return np.array(levels, dtype=np.float64) if is_numeric(levels) else np.arange(len(levels), dtype=np.float64)


def edges(levels: Sequence[AxisLevel], logarithmic: bool) -> Array:
    """Ends of the squares about levels, (levels + 1,): half way between neighbours."""
    at = np.log(places(levels)) if logarithmic else places(levels)
    if len(at) == 1:
        found = np.array([at[0] - 0.5, at[0] + 0.5])
    else:
        between = 0.5 * (at[1:] + at[:-1])
        found = np.concatenate([[2.0 * at[0] - between[0]], between, [2.0 * at[-1] - between[-1]]])
    return np.exp(found) if logarithmic else found


def is_logarithmic(results: StudyResults, axis: str) -> bool:
    """Whether a study spaces the levels of an axis so."""
    table = results.study.get("axes", {}).get(axis, {})
    levels = results.axes[axis]
    return bool(table.get("scale") == "log" and is_numeric(levels) and min(places(levels), default=0.0) > 0.0)


def set_scales(axes: Axes, results: StudyResults, x: str, y: str | None) -> None:
    """Linear or logarithmic."""
    if is_logarithmic(results, x):
        axes.set_xscale("log")
    if y is not None and is_logarithmic(results, y):
        axes.set_yscale("log")


def mark_levels(axes: Axes, along: str, levels: Sequence[AxisLevel]) -> None:
    """Label the levels of an axis, as many as there is room for; its limits must be set."""
    axis = axes.xaxis if along == "x" else axes.yaxis
    low, high = axis.get_transform().transform(np.array(axis.get_view_interval()))
    shares = (axis.get_transform().transform(places(levels)) - low) / (high - low)
    texts = [level_text(level) for level in levels]
    longest = max(map(len, texts))
    apart = _LEAST_APART * max(1.0, 0.35 * longest) if along == "x" else _LEAST_APART
    chosen: list[int] = []
    for i in range(len(levels)):
        if not chosen or shares[i] - shares[chosen[-1]] >= apart or not is_numeric(levels):
            chosen.append(i)
    axis.set_ticks(places(levels)[chosen], [texts[i] for i in chosen], minor=False)
    axis.set_ticks([], minor=True)
    if along == "x" and not is_numeric(levels) and longest > _LONG_TEXT and len(levels) * longest > 30:
        axes.tick_params(axis="x", labelrotation=30)
        for label in axes.get_xticklabels():
            label.set_horizontalalignment("right")


def panels(count: int, width: float, height: float, extra: float) -> tuple[Drawing, list[Axes]]:
    """A drawing of so many panels of a size, inches, and room of `extra` beside them."""
    from matplotlib.figure import Figure as Drawing

    columns = min(count, _MOST_ABREAST)
    rows = -(-count // columns)
    drawing = Drawing(figsize=(columns * width + extra, rows * height + 0.9), dpi=150, layout="constrained")
    every = drawing.subplots(rows, columns, squeeze=False, sharex=True, sharey=True).ravel().tolist()
    for spare in every[count:]:
        spare.set_visible(False)
    return drawing, every[:count]


def head(drawing: Drawing, title: str, caption: str) -> None:
    """Title above, and below what the numbers are."""
    import textwrap

    wide = int(13.0 * drawing.get_figwidth())
    drawing.suptitle(title, x=0.01, ha="left", fontsize=11, color=INK)
    drawing.supxlabel("\n".join(textwrap.wrap(caption, wide)), x=0.01, ha="left", fontsize=7.5, color="0.35")
