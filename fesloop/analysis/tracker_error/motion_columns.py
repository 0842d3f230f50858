"""What of an error follows from the motion: angle, its square, and its rate, as far as a record can tell.

Weights are ordinary least squares, so that the mean square of what follows from the motion and that of what
is left add up to the measured one. Which columns there are is chosen by how well each quarter of the record
is foretold by the other three (blocked cross-validation, doi 10.1016/j.ins.2011.12.028): what does not hold
from one quarter to the next will not hold on another hand. For each column the record must hold ten
independent angles (the rule of ten, doi 10.1016/0895-4356(96)00236-3): of one or two movements anything could
follow.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from fesloop.analysis.tracker_error.autocorrelation import independent_values
from fesloop.analysis.tracker_error.error_record import ErrorRecord

Array = NDArray[np.float64]
Columns = tuple[int, ...]
_MOST = 3
_A_COLUMN = 10.0
"""Independent angles for each column."""
_STILL = math.radians(1.0)
"""RMS of an angle below which an error cannot be said to follow from it (chosen: the error itself)."""
_BLOCKS = 4


class MotionColumns:
    """Columns of a record's motion.

    Attributes
    ----------
    values: (n, 4), a constant, the angle, its square, its rate; rad and s.
    """

    def __init__(self, record: ErrorRecord) -> None:
        self._error, self._known = record.error, record.known
        angle = record.angle
        self.values = np.stack([np.ones_like(angle), angle, angle * angle, record.rate], axis=1)

    def choices(self) -> Sequence[Columns]:
        """Sets of columns that the record is long enough for; the constant is in each."""
        angle = self.values[:, 1]
        moving = float(np.std(angle[self._known])) > _STILL
        most = min(_MOST, int(independent_values(angle, self._known) / _A_COLUMN)) if moving else 0
        return [(0, *some) for size in range(most + 1) for some in combinations((1, 2, 3), size)]

    def best(self) -> Columns:
        """The set of columns that foretells best."""
        return min(self.choices(), key=self.foretelling)

    def foretelling(self, columns: Columns) -> float:
        """Mean square of the errors of each quarter of the record, by weights of the other three."""
        rows, total = np.flatnonzero(self._known), 0.0
        for quarter in np.array_split(rows, _BLOCKS):
            _, left = self.least_squares(columns, np.setdiff1d(rows, quarter))
            total += float(np.sum(np.square(left[quarter])))
        return total / rows.size

    def least_squares(self, columns: Columns, rows: NDArray[np.int64]) -> tuple[Array, Array]:
        """Weights (4,) by some of the rows, zero for other columns; what they leave of the error (n,)."""
        chosen = list(columns)
        weights = np.zeros(4)
        weights[chosen], *_ = np.linalg.lstsq(self.values[rows][:, chosen], self._error[rows], rcond=None)
        return weights, self._error - self.values @ weights
