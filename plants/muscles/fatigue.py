"""Fitness of a muscle under stimulation: it falls while the muscle works and comes back while it rests."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from plants.checks import require_not_negative
from plants.muscles.fitness import MuscleFatigue

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Fatigue:
    """Riener and Veltink's fitness equation (`MuscleFatigue`) at one stimulation frequency.

    The recruited fraction stands for activation.

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
    _equation: MuscleFatigue = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        require_not_negative("fatigue", self, "rest_between_trials_s")
        if not 0.0 <= self.frequency_hz <= 100.0:
            raise InputError("fatigue.frequency_hz", f"{self.frequency_hz}", "from 0 to 100")
        object.__setattr__(self, "_equation", MuscleFatigue(
            floor=self.floor, fatigue_s=self.fatigue_s, recovery_s=self.recovery_s,
            frequency_weight=self.frequency_weight))

    def after(self, fitness: Array, recruited: Array, duration_s: float) -> Array:
        """Fitness (muscles,) after `duration_s` under the held recruited fractions (muscles,)."""
        frequency = np.full(recruited.shape, self.frequency_hz)
        effort = self._equation.effort(np.clip(recruited, 0.0, 1.0), frequency)
        return self._equation.after(fitness, effort, duration_s)
