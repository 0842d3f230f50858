"""Fitness of a muscle under stimulation: it falls while the muscle works and comes back while it rests."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from plants.checks import require_not_negative, require_positive

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Fatigue:
    """mu' = (floor - mu) w / fatigue_s + (1 - mu) (1 - w) / recovery_s, with w = v (1 - b + b (f / 100)^2).

    Riener and Veltink's fitness equation with the recruited fraction v in place of activation: over a
    held v it is linear in mu and solved in closed form.

    Attributes
    ----------
    floor: fitness that a muscle worked for ever falls to.
    fatigue_s, recovery_s: time constants, s (the literature: 18-30 and 40-50).
    frequency_weight: b, how much of the effect is the stimulation frequency's.
    frequency_hz: stimulation frequency f, at most 100.
    rest_between_trials_s: how long the muscles rest before the next trial, s (chosen).
    """

    floor: float = 0.2
    fatigue_s: float = 24.0
    recovery_s: float = 45.0
    frequency_weight: float = 0.6
    frequency_hz: float = 40.0
    rest_between_trials_s: float = 10.0

    def __post_init__(self) -> None:
        require_positive("fatigue", self, "fatigue_s", "recovery_s")
        require_not_negative("fatigue", self, "rest_between_trials_s")
        for key, highest in (("floor", 1.0), ("frequency_weight", 1.0), ("frequency_hz", 100.0)):
            value = getattr(self, key)
            if not 0.0 <= value <= highest:
                raise InputError(f"fatigue.{key}", f"{value}", f"from 0 to {highest:g}")

    def after(self, fitness: Array, recruited: Array, duration_s: float) -> Array:
        """Fitness (muscles,) after `duration_s` under the held recruited fractions (muscles,)."""
        weight = self.frequency_weight
        effort = np.clip(recruited, 0.0, 1.0) * (1.0 - weight + weight * (self.frequency_hz / 100.0) ** 2)
        wear, repair = effort / self.fatigue_s, (1.0 - effort) / self.recovery_s
        settled = (self.floor * wear + repair) / (wear + repair)
        change: Array = (fitness - settled) * np.exp(-(wear + repair) * duration_s)
        return settled + change
