"""Positions of the levels of an axis in a figure: numbers to scale, text one apart."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fesloop.analysis.study.results.axis_levels import AxisLevel, is_numeric, level_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]
_MOST_LABELLED = 20
"""Most numeric levels that are labelled; of more, round numbers are labelled."""
_LETTER_PT, _GAP_PT, _LINE_PT = 4.9, 3.0, 11.0
"""Width of a digit of a label, gap between two labels, and height of a line, points."""
_MARGIN = 0.04
_BESIDE_IN = 0.75
"""Part of a panel that its labels and title take, inches."""
_LONG_ROW = 34
"""Most letters of labels that fit side by side."""


@dataclass(frozen=True, slots=True)
class AxisScale:
    """An axis of a figure.

    Attributes
    ----------
    levels: numbers in ascending order, or text. kind: numbers to scale, linear or log; or all one apart.
    downwards: whether the first level is at the top.
    """

    levels: tuple[AxisLevel, ...]
    kind: Literal["linear", "log", "even"]
    downwards: bool = False

    @property
    def numeric(self) -> bool:
        """True if levels are numbers."""
        return is_numeric(self.levels)

    @property
    def places(self) -> Array:
        """Positions (levels,) of the levels."""
        if self.kind == "even":
            return np.arange(len(self.levels), dtype=np.float64)
        return np.array(self.levels, dtype=np.float64)

    def places_of(self, levels: Sequence[AxisLevel]) -> Array:
        """Positions of some of the levels."""
        return np.asarray(self.places[[self.levels.index(level) for level in levels]])

    def along(self, numbers: ArrayLike) -> Array:
        """Positions of any numbers, such as those of theory; NaN beyond the ends of evenly spaced levels."""
        x = np.asarray(numbers, dtype=np.float64)
        if self.kind != "even":
            return x
        return np.asarray(np.interp(x, np.array(self.levels, dtype=np.float64), self.places, np.nan, np.nan))

    @property
    def edges(self) -> Array:
        """Ends of the squares about levels, (levels + 1,): half way between neighbours."""
        at = np.log(self.places) if self.kind == "log" else self.places
        if len(at) == 1:
            found = np.array([at[0] - 0.5, at[0] + 0.5])
        else:
            between = 0.5 * (at[1:] + at[:-1])
            found = np.concatenate([[2.0 * at[0] - between[0]], between, [2.0 * at[-1] - between[-1]]])
        return np.asarray(np.exp(found) if self.kind == "log" else found)

    def span(self, level: AxisLevel) -> tuple[float, float]:
        """Ends of the square about a level."""
        i = self.levels.index(level)
        low, high = self.edges[i:i + 2]
        return float(low), float(high)

    @property
    def close_ends(self) -> Array:
        """Limits that leave a little room beside the first and the last level, (2,)."""
        if self.kind == "even" or len(self.levels) == 1:
            return self.edges[[0, -1]]
        first, last = (np.log(self.places) if self.kind == "log" else self.places)[[0, -1]]
        room = _MARGIN * (last - first)
        found = np.array([first - room, last + room])
        return np.asarray(np.exp(found) if self.kind == "log" else found)

    def apply(self, axes: Axes, which: Literal["x", "y"], *, squares: bool) -> None:
        """Set the scale, and the limits: those of the squares about all levels, or close ones."""
        limits = self.edges if squares else self.close_ends
        ends = limits[::-1] if self.downwards else limits
        if which == "x":
            axes.set_xscale("log" if self.kind == "log" else "linear")
            axes.set_xlim(ends[0], ends[-1])
        else:
            axes.set_yscale("log" if self.kind == "log" else "linear")
            axes.set_ylim(ends[0], ends[-1])

    @property
    def longest(self) -> int:
        """Number of letters of the longest level."""
        return max(len(level_text(level)) for level in self.levels)

    @property
    def slanted(self) -> bool:
        """True if labels of text are too long to fit side by side."""
        return not self.numeric and len(self.levels) * self.longest > _LONG_ROW

    def label(self, axes: Axes, which: Literal["x", "y"], panel_in: float) -> None:
        """Label the levels, as many as there is room for, within limits that are set.

        `panel_in` is the size of the panel that way, with its labels, inches.
        """
        if self.numeric and len(self.levels) > _MOST_LABELLED and self.kind != "even":
            return
        axis = axes.xaxis if which == "x" else axes.yaxis
        low, high = axis.get_transform().transform(np.array(axis.get_view_interval()))
        shares = np.abs((axis.get_transform().transform(self.places) - low) / (high - low))
        texts = [level_text(level) for level in self.levels]
        length_pt = 72.0 * (panel_in - _BESIDE_IN)
        apart = (_LETTER_PT * self.longest + _GAP_PT if which == "x" else _LINE_PT) / length_pt
        chosen: list[int] = []
        for i in np.argsort(shares).tolist():
            if not chosen or shares[i] - shares[chosen[-1]] >= apart or not self.numeric:
                chosen.append(i)
        axis.set_ticks(self.places[chosen], [texts[i] for i in chosen], minor=False)
        axis.set_ticks([], minor=True)
        if which == "x" and self.slanted:
            axes.tick_params(axis="x", labelrotation=30)
            for label in axes.get_xticklabels():
                label.set_horizontalalignment("right")
