"""Comparison of published figures with virtual subjects: rows of a table, and whether they agree."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from fesloop.apps.reproduce.published import Half

LOW, HIGH = 5.0, 95.0
"""Percentiles of the band over virtual subjects."""


@dataclass(frozen=True, slots=True)
class Band:
    """Median and 5-95 % band of a figure over virtual subjects."""

    median: float
    low: float
    high: float

    def __str__(self) -> str:
        """Median and band as text; "-" where there is no value."""
        if not math.isfinite(self.median):
            return "-"
        known = math.isfinite(self.high - self.low)
        return f"{self.median:.2f}" + (f" ({self.low:.2f}-{self.high:.2f})" if known else "")

    def holds(self, value: float) -> bool:
        """Whether a value lies in the band."""
        return bool(self.low <= value <= self.high)


@dataclass(frozen=True, slots=True, kw_only=True)
class FigureScores:
    """Scores of a published figure under our predictive distribution.

    Attributes
    ----------
    half: whether the model was fitted to it.
    pit: probability integral transform: probability that we give to smaller values.
    log_score, baseline_log_score: of our model and of the baseline (`scores.log_score`); NaN if undefined.
    baseline_holds: whether it lies in the baseline's band.
    band_over_sd: width of our band over the published standard deviation; NaN where none is published.
    """

    half: Half
    pit: float
    log_score: float
    baseline_log_score: float
    baseline_holds: bool
    band_over_sd: float


@dataclass(frozen=True, slots=True, kw_only=True)
class PatternScores:
    """Shares of replicates in which a published pattern occurs: of our model, and of the baseline.

    `baseline_holds` says whether the baseline's is large enough for the pattern to hold.
    """

    share: float
    baseline_share: float
    baseline_holds: bool


@dataclass(frozen=True, slots=True)
class Row:
    """One line of a comparison.

    Attributes
    ----------
    table, row: of the paper.
    theirs: the published figure, or statement.
    ours: the band of virtual subjects, or the corresponding statement.
    holds: whether the published figure lies in the band, or the statement is confirmed.
    unit: of both.
    scores: of a published figure or pattern, where replicates of the whole paper are simulated.
    """

    table: str
    row: str
    theirs: float | str
    ours: Band | str
    holds: bool
    unit: str = ""
    scores: FigureScores | PatternScores | None = None

    def as_table(self) -> dict[str, object]:
        """Table for `fesloop reproduce --json`."""
        ours = self.ours if isinstance(self.ours, str) else {
            "median": self.ours.median, "low": self.ours.low, "high": self.ours.high}
        table: dict[str, object] = {
            "table": self.table, "row": self.row, "theirs": self.theirs, "ours": ours,
            "holds": self.holds, "unit": self.unit}
        return table if self.scores is None else table | {"scores": asdict(self.scores)}


def band(values: ArrayLike) -> Band:
    """Band of a figure, (subjects,); values of subjects who failed may be infinite."""
    array = np.asarray(values, dtype=np.float64)
    # No interpolation between a number and infinity.
    method: Literal["linear", "higher"] = "linear" if np.isfinite(array).all() else "higher"
    low, median, high = np.percentile(array, [LOW, 50.0, HIGH], method=method)
    return Band(float(median), float(low), float(high))


def compared(table: str, row: str, theirs: float, ours: Band, unit: str) -> Row:
    """Make a row that holds if the published figure lies in the band."""
    return Row(table, row, theirs, ours, ours.holds(theirs), unit)


def share_that_holds(rows: Sequence[Row]) -> float:
    """Share of the rows that hold."""
    return sum(row.holds for row in rows) / len(rows) if rows else 0.0
