"""How strong stimulated muscle is in one trial and in the next, as a random process."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.forms.schema import require_positive
from fesloop.hand.movements import MUSCLES
from fesloop.loop.block import Context

Array = NDArray[np.float64]
_ALL = 1 + len(MUSCLES)
"""Numbers of a trial: one for all muscles together, then one for each."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Variation:
    """Factor on what stimulation activates, constant within a trial, lognormal with mean 1.

        ln factor = trial e + muscle_trial e_m + drift x + muscle_drift x_m - (sum of squares) / 2

    e, e_m are standard normal, new in each trial; x, x_m are stationary with the correlation
    exp(-t / drift_s) over the time t between the beginnings of two trials, rest included. All depend on the
    experiment's seed and the trial's number.

    Attributes
    ----------
    trial, muscle_trial: standard deviations of the part that is new in each trial, of all muscles together,
        and in addition of each muscle.
    drift, muscle_drift: likewise of the part that changes slowly.
    drift_s: its correlation time, s.
    scale: factor on all four; 0: no variation.
    """

    trial: float = 0.0
    muscle_trial: float = 0.0
    drift: float = 0.0
    muscle_drift: float = 0.0
    drift_s: float = 600.0
    scale: float = 1.0

    def __post_init__(self) -> None:
        for key, most in (("trial", 1.0), ("muscle_trial", 1.0), ("drift", 1.0), ("muscle_drift", 1.0),
                          ("scale", 4.0)):
            value = getattr(self, key)
            if not 0.0 <= value <= most:
                raise InputError(f"variation.{key}", f"{value}", f"from 0 to {most:g}")
        require_positive("variation", self, "drift_s")

    @property
    def spread(self) -> float:
        """Standard deviation of the factor's logarithm."""
        return self.scale * math.hypot(self.trial, self.muscle_trial, self.drift, self.muscle_drift)

    def start(self, context: Context) -> Array:
        """Slow part of a first trial, (1 + muscles,), standard normal; zeros without variation."""
        return context.noise(_ALL, purpose="drift of strength").row(0) if self.spread else np.zeros(_ALL)

    def later(self, slow: Array, elapsed_s: float, context: Context) -> Array:
        """Slow part of a trial that begins `elapsed_s` after the one with `slow`."""
        kept = math.exp(-elapsed_s / self.drift_s)
        later: Array = kept * slow + math.sqrt(1.0 - kept**2) * self.start(context)
        return later

    def factors(self, slow: Array, context: Context) -> Array:
        """Factor of each muscle in a trial, (muscles,); ones without variation."""
        if not self.spread:
            return np.ones(len(MUSCLES))
        new = context.noise(_ALL, purpose="strength").row(0)
        logs = (self.trial * new[0] + self.muscle_trial * new[1:]
                + self.drift * slow[0] + self.muscle_drift * slow[1:])
        return np.asarray(np.exp(self.scale * logs - 0.5 * self.spread**2))
