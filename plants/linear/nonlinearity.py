"""Static nonlinearities before a linear plant: what makes it a Hammerstein system."""

from __future__ import annotations

import math
from bisect import bisect_right
from dataclasses import dataclass
from typing import Literal

import numpy as np

from fesloop.errors import InputError
from plants.checks import require_positive


@dataclass(frozen=True, slots=True, kw_only=True)
class InputNonlinearity:
    """v = f(u), the same for every input of the plant.

        none         v = u
        saturation   v = u, kept between lower and upper
        deadzone     v = 0 between lower and upper, u - upper above, u - lower below
        logistic     v = lower + (upper - lower) / (1 + exp(-(u - centre) / width))
        table        straight lines between (table_input, table_output), level beyond its ends

    Attributes
    ----------
    kind: which of them.
    lower, upper, centre, width: as above; lower below upper, width above 0.
    table_input: strictly increasing, two values or more; table_output: as many.
    """

    kind: Literal["none", "saturation", "deadzone", "logistic", "table"] = "none"
    lower: float = 0.0
    upper: float = 1.0
    centre: float = 0.5
    width: float = 0.1
    table_input: tuple[float, ...] = ()
    table_output: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        if not self.lower < self.upper:
            raise InputError("nonlinearity.lower", f"{self.lower}", f"below upper, {self.upper}")
        require_positive("nonlinearity", self, "width")
        if not math.isfinite(self.centre):
            raise InputError("nonlinearity.centre", f"{self.centre}", "a finite number")
        if self.kind == "table":
            self._check_table()

    def _check_table(self) -> None:
        """Raise InputError unless the table can be read."""
        points, values = np.asarray(self.table_input), np.asarray(self.table_output)
        if points.size < 2 or not np.isfinite(points).all() or not (np.diff(points) > 0.0).all():
            raise InputError("nonlinearity.table_input", f"{self.table_input}",
                             "two finite numbers or more, strictly increasing")
        if values.size != points.size or not np.isfinite(values).all():
            raise InputError("nonlinearity.table_output", f"{self.table_output}",
                             f"{points.size} finite numbers, one for each of table_input")

    def apply(self, value: float) -> float:
        """f of one input."""
        if self.kind == "saturation":
            return min(max(value, self.lower), self.upper)
        if self.kind == "deadzone":
            return value - min(max(value, self.lower), self.upper)
        if self.kind == "logistic":
            # The hyperbolic form does not overflow far below the centre.
            rise = 0.5 * (1.0 + math.tanh(0.5 * (value - self.centre) / self.width))
            return self.lower + (self.upper - self.lower) * rise
        if self.kind == "table":
            return self._interpolate(value)
        return value

    def _interpolate(self, value: float) -> float:
        """The table at `value`."""
        points, values = self.table_input, self.table_output
        above = bisect_right(points, value)
        if above == 0:
            return values[0]
        if above == len(points):
            return values[-1]
        share = (value - points[above - 1]) / (points[above] - points[above - 1])
        return values[above - 1] + share * (values[above] - values[above - 1])
