"""Fitness of muscles under stimulation of changing frequency: it falls with work and recovers with rest."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.compiled import compiled
from fesloop.errors import InputError
from plants.checks import require_not_negative, require_positive

Array = NDArray[np.float64]
FASTEST_HZ = 100.0
"""Frequency above which fatigue does not grow."""


class FitnessRates(NamedTuple):
    """Coefficients of the fitness equation: asymptotic fitness, and rates of fatigue and recovery, 1/s."""

    floor: float
    wear: float
    repair: float


NO_FATIGUE = FitnessRates(0.0, 0.0, 0.0)


@compiled
def tire(
    fitness: Array, effort: Array, rates: FitnessRates, elapsed_s: float, after: Array
) -> None:
    """Fill `after` (n,) with the fitness `elapsed_s` after `fitness`; `effort` (n,) is constant.

    mu' = wear effort (floor - mu) + repair (1 - effort) (1 - mu)
    """
    for i in range(fitness.size):
        falls, rises = rates.wear * effort[i], rates.repair * (1.0 - effort[i])
        rate = falls + rises
        after[i] = fitness[i]
        if rate > 0.0:
            settled = (rates.floor * falls + rises) / rate
            after[i] = settled + (fitness[i] - settled) * math.exp(-rate * elapsed_s)


@dataclass(frozen=True, slots=True, kw_only=True)
class MuscleFatigue:
    """mu' = (floor - mu) w / fatigue_s + (1 - mu) (1 - w) / recovery_s, with w = a (1 - b + b (f / 100)^2).

    Riener and Veltink's fitness equation. The activation a is replaced by the drive that it follows, which is
    constant between changes: the equation is then linear with constant coefficients, solved in closed form.

    Attributes
    ----------
    floor: fitness under endless work.
    fatigue_s, recovery_s: time constants, s (the literature: 18-30 and 40-50).
    frequency_weight: b, fraction of the effect due to the stimulation frequency; f counts up to 100 Hz.
    recovers: whether fitness recovers.
    """

    floor: float = 0.2
    fatigue_s: float = 24.0
    recovery_s: float = 45.0
    frequency_weight: float = 0.6
    recovers: bool = True

    def __post_init__(self) -> None:
        require_positive("fatigue", self, "fatigue_s", "recovery_s")
        for key in ("floor", "frequency_weight"):
            value = getattr(self, key)
            if not 0.0 <= value <= 1.0:
                raise InputError(f"fatigue.{key}", f"{value}", "from 0 to 1")

    def effort(self, drive: Array, frequency: Array) -> Array:
        """w of each muscle, (muscles,), from its drive in [0, 1] and its frequency, Hz."""
        weight = self.frequency_weight
        share = np.minimum(frequency, FASTEST_HZ) / FASTEST_HZ
        effort: Array = drive * (1.0 - weight + weight * share**2)
        return effort

    def after(self, fitness: Array, effort: Array, elapsed_s: float) -> Array:
        """Fitness (muscles,) after `elapsed_s` under constant efforts (muscles,)."""
        after = np.empty_like(fitness)
        tire(fitness, effort, self.rates, elapsed_s, after)
        return after

    @property
    def rates(self) -> FitnessRates:
        """Coefficients of the equation."""
        return FitnessRates(self.floor, 1.0 / self.fatigue_s, 1.0 / self.recovery_s if self.recovers else 0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Fatigue:
    """Riener and Veltink's fitness equation (`MuscleFatigue`) at one stimulation frequency.

    The recruited fraction replaces activation.

    Attributes
    ----------
    floor: fitness under endless work.
    fatigue_s, recovery_s: time constants, s (the literature: 18-30 and 40-50).
    frequency_weight: b, fraction of the effect due to the stimulation frequency.
    frequency_hz: stimulation frequency f, at most 100.
    rest_between_trials_s: rest of the muscles before the next trial, s (chosen).
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
        """Fitness (muscles,) after `duration_s` under constant recruited fractions (muscles,)."""
        frequency = np.full(recruited.shape, self.frequency_hz)
        effort = self._equation.effort(np.clip(recruited, 0.0, 1.0), frequency)
        return self._equation.after(fitness, effort, duration_s)


RECOVERY_S = 127.0
CONDITIONS: dict[str, MuscleFatigue] = {
    "able_bodied": MuscleFatigue(fatigue_s=13.6, recovery_s=RECOVERY_S),
    "sci_acute": MuscleFatigue(fatigue_s=7.8, recovery_s=RECOVERY_S),
    "sci_chronic": MuscleFatigue(fatigue_s=3.7, recovery_s=RECOVERY_S),
}
