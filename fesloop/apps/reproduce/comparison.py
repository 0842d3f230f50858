"""Comparison of published figures with virtual subjects: rows of a table, and whether they agree."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

LOW, HIGH = 5.0, 95.0
"""Percentiles of the band over virtual subjects."""
_DRAWS = 4000


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
    """

    table: str
    row: str
    theirs: float | str
    ours: Band | str
    holds: bool
    unit: str = ""

    def as_table(self) -> dict[str, object]:
        """Table for `fesloop reproduce --json`."""
        ours = self.ours if isinstance(self.ours, str) else {
            "median": self.ours.median, "low": self.ours.low, "high": self.ours.high}
        return {"table": self.table, "row": self.row, "theirs": self.theirs, "ours": ours,
                "holds": self.holds, "unit": self.unit}


def band(values: ArrayLike) -> Band:
    """Band of a figure, (subjects,); values of subjects who failed may be infinite."""
    array = np.asarray(values, dtype=np.float64)
    # No interpolation between a number and infinity.
    method: Literal["linear", "higher"] = "linear" if np.isfinite(array).all() else "higher"
    low, median, high = np.percentile(array, [LOW, 50.0, HIGH], method=method)
    return Band(float(median), float(low), float(high))


def band_of_means(values: ArrayLike, size: int, seed: int = 0) -> Band:
    """Band of the mean over `size` subjects, by sampling groups without replacement."""
    array = np.asarray(values, dtype=np.float64)
    rng = np.random.default_rng(seed)
    size = min(size, array.size)
    return band([array[rng.choice(array.size, size, replace=False)].mean() for _ in range(_DRAWS)])


def compared(table: str, row: str, theirs: float, ours: Band, unit: str) -> Row:
    """Make a row that holds if the published figure lies in the band."""
    return Row(table, row, theirs, ours, ours.holds(theirs), unit)


def share_that_holds(rows: Sequence[Row]) -> float:
    """Share of the rows that hold."""
    return sum(row.holds for row in rows) / len(rows) if rows else 0.0
