"""Errors of a tracker as measured: one record an angle, with the motion during which it erred."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ErrorRecord:
    """Error of one angle over time.

    Attributes
    ----------
    name, moved: as of `ErrorSeries`.
    times_s: (n,), instants of the reference, increasing.
    error: (n,), estimate minus truth, rad; NaN where one of the two is not known or not to be scored.
    angle: (n,), true, from the centre of its motion, rad; interpolated where it is not known.
    rate: (n,), its rate, rad/s.
    """

    name: str
    moved: bool
    times_s: Array
    error: Array
    angle: Array
    rate: Array

    @property
    def known(self) -> NDArray[np.bool_]:
        """Instants at which the error is known, (n,)."""
        return np.isfinite(self.error)

    @property
    def steps_s(self) -> Array:
        """From each instant to the next, (n,); 0 for the last."""
        return np.diff(self.times_s, append=self.times_s[-1:])

    @property
    def rms_deg(self) -> float:
        """RMS of the error where it is known; NaN where it never is."""
        error = self.error[self.known]
        return float(np.degrees(np.sqrt(np.mean(np.square(error))))) if error.size else float("nan")

    def part(self, after_s: float, until_s: float) -> ErrorRecord:
        """What lies in [after_s, until_s)."""
        rows = (self.times_s >= after_s) & (self.times_s < until_s)
        return replace(self, **{name: getattr(self, name)[rows]
                                for name in ("times_s", "error", "angle", "rate")})
