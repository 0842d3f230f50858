"""Linear activation dynamics: two lags in series under a piecewise constant drive, solved in closed form.

A critically damped second-order system is two equal lags of 1 / natural frequency; calcium release and
activation are two different ones.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.compiled import compiled
from fesloop.errors import InputError
from fesloop.forms.schema import require_not_negative, require_positive
from fesloop.hand.movements import MUSCLES, each_muscle
from fesloop.loop.clock import NS_PER_S

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


UNTIRED = np.ones(len(MUSCLES))
"""Capacity of muscles without fatigue."""
UNTIRED.flags.writeable = False


@compiled
def settle_lags(
    levels: Array, drive: Array, first_s: Array, second_s: Array, elapsed_s: float, after: Array
) -> None:
    """Fill `after` (2, n) with the levels of the lags `elapsed_s` after `levels` (2, n).

    c' = (drive - c) / first_s,  a' = (c - a) / second_s,  with constant `drive` (n,) and lags (n,).
    """
    first, second, passed = 1.0, 1.0, 0.0
    for i in range(drive.size):
        if i == 0 or first_s[i] != first_s[i - 1] or second_s[i] != second_s[i - 1]:
            first, second = math.exp(-elapsed_s / first_s[i]), math.exp(-elapsed_s / second_s[i])
            apart = elapsed_s * (first_s[i] - second_s[i]) / (first_s[i] * second_s[i])
            # The integral of both exponentials, written so that it stays exact as the lags become equal.
            if apart > 0.0:
                passed = -first * math.expm1(-apart) / apart
            elif apart < 0.0:
                passed = second * math.expm1(apart) / apart
            else:
                passed = first
            passed *= elapsed_s / second_s[i]
        short = levels[0, i] - drive[i]
        after[0, i] = drive[i] + short * first
        after[1, i] = drive[i] + (levels[1, i] - drive[i]) * second + short * passed


class LagState:
    """Levels (2, muscles) of both lags at `since_ns`, and the constant drive (muscles,) since then.

    `idle` until the first drive; all levels are then 0.
    """

    __slots__ = ("drive", "idle", "levels", "since_ns")

    def __init__(self) -> None:
        self.idle = True
        self.levels = np.zeros((2, len(MUSCLES)))
        self.drive = np.zeros(len(MUSCLES))
        self.since_ns = 0

    def copy(self) -> LagState:
        """An independent copy; its arrays are replaced, never written to."""
        ahead = LagState.__new__(LagState)
        ahead.levels, ahead.drive, ahead.since_ns = self.levels, self.drive, self.since_ns
        ahead.idle = self.idle
        return ahead


@dataclass(frozen=True, slots=True, eq=False)
class TwoLags:
    """Activation of all muscles by two lags (muscles,) in series, s.

    The state stays at the last change of the drive, so observations do not split it.
    """

    first_s: Array
    second_s: Array

    def start(self) -> LagState:
        """State at rest."""
        return LagState()

    def rested(self, state: LagState, rest_s: float) -> LagState:
        """State at rest: lags decay in a pause between trials."""
        return LagState()

    def advance(self, state: LagState, stop_ns: int) -> None:
        """Do nothing: the state changes with the drive alone."""

    def change(self, state: LagState, time_ns: int, pulses: Array, drive: Array) -> None:
        """Let `drive` (muscles,) act from `time_ns` on."""
        state.idle = state.idle and not drive.any()
        if not state.idle:
            state.levels = self._levels(state, time_ns)
        state.drive, state.since_ns = drive, time_ns

    def look(self, state: LagState, time_ns: int) -> tuple[Array, Array]:
        """Activation, and a capacity of ones, as the model has no fatigue."""
        return self._levels(state, time_ns)[1], UNTIRED

    def _levels(self, state: LagState, time_ns: int) -> Array:
        after = np.empty_like(state.levels)
        settle_lags(state.levels, state.drive, self.first_s, self.second_s,
                    (time_ns - state.since_ns) / NS_PER_S, after)
        return after


def lags_s(usual_rad_s: float, own_rad_s: Mapping[str, float], where: str) -> Array:
    """Lags (muscles,) of critically damped systems with these natural frequencies, the same for both, s."""
    for name, number in own_rad_s.items():
        if not (math.isfinite(number) and number > 0.0):
            raise InputError(f"{where}.{name}", f"{number}", "a finite number above 0")
    lags: Array = 1.0 / each_muscle(usual_rad_s, own_rad_s, where)
    return lags


@dataclass(frozen=True, slots=True, kw_only=True)
class Hammerstein:
    """Linear activation dynamics behind static recruitment, a'' + 2 w a' + w^2 a = w^2 drive.

    Attributes
    ----------
    activation_rad_s: w (16, the middle of stimulated muscles of elbow and forearm: docs/models/people.md; a
        muscle then rises from 10 to 90 % in 0.21 s).
    activations_rad_s: w of single muscles by name, in place of it.
    """

    activation_rad_s: float = 16.0
    activations_rad_s: dict[str, float] = field(default_factory=dict)
    _lags_s: Array = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        require_positive("hammerstein", self, "activation_rad_s")
        object.__setattr__(self, "_lags_s", lags_s(
            self.activation_rad_s, self.activations_rad_s, "hammerstein.activations_rad_s"))

    def contraction(self) -> TwoLags:
        """The dynamics."""
        return TwoLags(self._lags_s, self._lags_s)


@dataclass(frozen=True, slots=True, kw_only=True)
class Riener:
    """Calcium release, then activation: a lag each (Riener and Fuhr 1998, doi 10.1109/86.681177).

    Attributes
    ----------
    calcium_ms, activation_ms: the lags (40 and 70, models of the Riener-Fuhr type).
    """

    calcium_ms: float = 40.0
    activation_ms: float = 70.0

    def __post_init__(self) -> None:
        require_positive("riener", self, "calcium_ms", "activation_ms")

    def contraction(self) -> TwoLags:
        """The dynamics."""
        return TwoLags(*(np.full(len(MUSCLES), 1e-3 * lag) for lag in (self.calcium_ms, self.activation_ms)))


@compiled
def follow(
    levels: Array, drive: Array, first_s: Array, second_s: Array, drive_ns: int, fitness: Array,
    effort: Array, fatigue: FitnessRates, effort_ns: int, factors: Array, times_ns: NDArray[np.int64],
    activation: Array, fit: Array,
) -> None:
    """Fill `activation` and `fit` (n, muscles) at `times_ns` (n,).

    The lags have `levels` (2, muscles) at `drive_ns`, and `drive` (muscles,) since then; the muscles have
    `fitness` (muscles,) at `effort_ns`, and `effort` (muscles,) since then. `factors` (muscles,) multiply
    the levels.
    """
    settled = np.empty_like(levels)
    for k in range(times_ns.size):
        settle_lags(levels, drive, first_s, second_s, (times_ns[k] - drive_ns) / NS_PER_S, settled)
        tire(fitness, effort, fatigue, (times_ns[k] - effort_ns) / NS_PER_S, fit[k])
        for i in range(drive.size):
            activation[k, i] = min(factors[i] * settled[1, i], 1.0) * fit[k, i]


@compiled
def limit_pulses(
    recruitment: Array, frequency: Array, highest_hz: float, before: Array, pulses: Array
) -> bool:
    """Fill `pulses` (2, muscles) with recruitment in 0 to 1 and frequency in 0 to `highest_hz`.

    Returns whether they differ from `before` (2, muscles).
    """
    recruited, hertz = pulses
    changed = False
    for i in range(recruitment.size):
        recruited[i] = min(max(recruitment[i], 0.0), 1.0)
        hertz[i] = min(max(frequency[i], 0.0), highest_hz)
        changed = changed or recruited[i] != before[0, i] or hertz[i] != before[1, i]
    return changed


@compiled
def held_drives(
    pulses: Array, effort: Array, reflex: Array, fusion_hz: float, frequency_weight: float
) -> tuple[Array, Array, Array]:
    """Steady activation, effort in the sense of `MuscleFatigue.effort`, and natural drive, (muscles,) each.

    Activation is the recruited fraction times h(f) = r / (1 + r), r = (f / fusion_hz)^2. `effort` and
    `reflex` (muscles,) act on the fibres that stimulation does not recruit.
    """
    count = effort.size
    steady, wearing, natural = np.empty(count), np.empty(count), np.empty(count)
    for i in range(count):
        recruited, hertz = pulses[0, i], pulses[1, i]
        ratio = (hertz / fusion_hz) ** 2
        steady[i] = recruited * (ratio / (1.0 + ratio))
        share = min(hertz, FASTEST_HZ) / FASTEST_HZ
        wearing[i] = steady[i] * (1.0 - frequency_weight + frequency_weight * share**2)
        natural[i] = min(effort[i] + reflex[i], 1.0 - recruited if hertz > 0.0 else 1.0)
    return steady, wearing, natural
