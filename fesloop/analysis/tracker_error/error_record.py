"""Measured error of one angle of a tracker, with the motion during which it was measured."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.compiled import compiled

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ErrorRecord:
    """Error of one angle over time.

    Attributes
    ----------
    name, moved: as in `ErrorSeries`.
    times_s: (n,), instants of the reference, increasing.
    error: (n,), estimate minus truth, rad; NaN where one of the two is unknown or not scored.
    angle: (n,), true angle from the centre of its motion, rad; interpolated where it is unknown.
    rate: (n,), rate of the angle, rad/s.
    """

    name: str
    moved: bool
    times_s: Array
    error: Array
    angle: Array
    rate: Array

    @property
    def known(self) -> NDArray[np.bool_]:
        """Whether the error is known at each instant, (n,)."""
        return np.isfinite(self.error)

    @property
    def steps_s(self) -> Array:
        """Time from each instant to the next, (n,); 0 for the last."""
        return np.diff(self.times_s, append=self.times_s[-1:])

    @property
    def rms_deg(self) -> float:
        """RMS of the known errors; NaN where there are none."""
        error = self.error[self.known]
        return float(np.degrees(np.sqrt(np.mean(np.square(error))))) if error.size else float("nan")

    def part(self, after_s: float, until_s: float) -> ErrorRecord:
        """The part of the record within [after_s, until_s)."""
        rows = (self.times_s >= after_s) & (self.times_s < until_s)
        return replace(self, **{name: getattr(self, name)[rows]
                                for name in ("times_s", "error", "angle", "rate")})


@compiled
def autocorrelation(errors: Any, known: Any, lags: Any) -> Any:
    """Autocorrelation of each row less its mean, (runs, lags); errors (runs, n), known (n,).

    Each lag uses the pairs of instants that are both known; 0 where there is no pair.
    """
    runs, samples = errors.shape
    found = np.zeros((runs, lags.size))
    for r in range(runs):
        total, count = 0.0, 0
        for k in range(samples):
            if known[k]:
                total += errors[r, k]
                count += 1
        mean, power = total / count, 0.0
        for k in range(samples):
            if known[k]:
                power += (errors[r, k] - mean) ** 2
        power /= count
        for i in range(lags.size):
            product, pairs = 0.0, 0
            for k in range(samples - lags[i]):
                if known[k] and known[k + lags[i]]:
                    product += (errors[r, k] - mean) * (errors[r, k + lags[i]] - mean)
                    pairs += 1
            if pairs and power > 0.0:
                found[r, i] = product / pairs / power
    return found


def independent_values(values: Array, known: NDArray[np.bool_]) -> float:
    """Effective number of independent values among the `known` ones of values (n,).

    The number of known values over one plus twice the sum of the autocorrelation up to its first zero
    (Priestley 1981, Spectral Analysis and Time Series, section 5.3.2).
    """
    lags = np.arange(1, values.size // 2)
    found = autocorrelation(values[np.newaxis], known, lags)[0]
    negative = np.flatnonzero(found <= 0.0)
    total = float(found[:negative[0] if negative.size else found.size].sum())
    return float(known.sum()) / (1.0 + 2.0 * total)
