"""Linear activation: two lags in series behind a held drive, solved in closed form.

A critically damped second order is two equal lags of 1 / natural frequency; calcium release and activation
are two different ones.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fesloop.compiled import compiled
from fesloop.hand.movements import MUSCLES
from fesloop.loop.clock import NS_PER_S
from plants.checks import require_positive
from plants.muscles.fitness import FASTEST_HZ, tire

Array = NDArray[np.float64]


UNTIRED = np.ones(len(MUSCLES))
"""What is left of muscles that have no fatigue of their own."""
UNTIRED.flags.writeable = False


@compiled
def settle_lags(
    levels: Array, drive: Array, first_s: float, second_s: float, elapsed_s: float, after: Array
) -> None:
    """Fill `after` (2, n) with the lags' levels, `elapsed_s` after they were `levels` (2, n).

    c' = (drive - c) / first_s,  a' = (c - a) / second_s,  with `drive` (n,) held.
    """
    first, second = math.exp(-elapsed_s / first_s), math.exp(-elapsed_s / second_s)
    apart = elapsed_s * (first_s - second_s) / (first_s * second_s)
    # The integral of both exponentials, written so that it stays exact as the lags become equal.
    if apart > 0.0:
        passed = -first * math.expm1(-apart) / apart
    elif apart < 0.0:
        passed = second * math.expm1(apart) / apart
    else:
        passed = first
    passed *= elapsed_s / second_s
    for i in range(drive.size):
        short = levels[0, i] - drive[i]
        after[0, i] = drive[i] + short * first
        after[1, i] = drive[i] + (levels[1, i] - drive[i]) * second + short * passed


class LagState:
    """Levels (2, muscles) of both lags at `since_ns`, and the drive (muscles,) held since then.

    `idle` as long as there has been no drive: all levels are 0.
    """

    __slots__ = ("drive", "idle", "levels", "since_ns")

    def __init__(self) -> None:
        self.idle = True
        self.levels = np.zeros((2, len(MUSCLES)))
        self.drive = np.zeros(len(MUSCLES))
        self.since_ns = 0

    def copy(self) -> LagState:
        """A state that can go ahead on its own; arrays here are replaced, never written to."""
        ahead = LagState.__new__(LagState)
        ahead.levels, ahead.drive, ahead.since_ns = self.levels, self.drive, self.since_ns
        ahead.idle = self.idle
        return ahead


@dataclass(frozen=True, slots=True)
class TwoLags:
    """All muscles' activation by two lags in series.

    Its state stays at the last change of the drive, so looking at it splits nothing.
    """

    first_s: float
    second_s: float

    def start(self) -> LagState:
        """At rest."""
        return LagState()

    def rested(self, state: LagState, rest_s: float) -> LagState:
        """At rest: lags remember nothing over a pause between trials."""
        return LagState()

    def advance(self, state: LagState, stop_ns: int) -> None:
        """Nothing happens between changes of the drive."""

    def change(self, state: LagState, time_ns: int, pulses: Array, drive: Array) -> None:
        """`drive` (muscles,) acts from `time_ns` on."""
        state.idle = state.idle and not drive.any()
        if not state.idle:
            state.levels = self._levels(state, time_ns)
        state.drive, state.since_ns = drive, time_ns

    def look(self, state: LagState, time_ns: int) -> tuple[Array, Array]:
        """Activation, and ones for what is left of the muscles: these have no fatigue of their own."""
        return self._levels(state, time_ns)[1], UNTIRED

    def _levels(self, state: LagState, time_ns: int) -> Array:
        after = np.empty_like(state.levels)
        settle_lags(state.levels, state.drive, self.first_s, self.second_s,
                    (time_ns - state.since_ns) / NS_PER_S, after)
        return after


@dataclass(frozen=True, slots=True, kw_only=True)
class Hammerstein:
    """a'' + 2 w a' + w^2 a = w^2 drive: linear activation dynamics behind static recruitment.

    Attributes
    ----------
    activation_rad_s: w (20-25 in grip-force data; a muscle then rises from 10 to 90 % in 0.134 s).
    """

    activation_rad_s: float = 25.0

    def __post_init__(self) -> None:
        require_positive("hammerstein", self, "activation_rad_s")

    def contraction(self) -> TwoLags:
        """The dynamics."""
        return TwoLags(1.0 / self.activation_rad_s, 1.0 / self.activation_rad_s)


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
        return TwoLags(1e-3 * self.calcium_ms, 1e-3 * self.activation_ms)


@compiled
def follow(
    levels: Array, drive: Array, lags_s: tuple[float, float], changed_ns: int, fitness: Array, effort: Array,
    fatigue: tuple[float, float, float], worn_ns: int, times_ns: NDArray[np.int64], activation: Array,
    fit: Array,
) -> None:
    """Fill `activation` and `fit` (n, muscles) at `times_ns` (n,).

    Two lags, of `lags_s`, have had `levels` (2, muscles) at `changed_ns`, and `drive` (muscles,) since; the
    muscles have had `fitness` (muscles,) at `worn_ns`, and `effort` (muscles,) since, under a `fatigue`
    (floor, wear, repair) as `tire` takes it.
    """
    settled = np.empty_like(levels)
    for k in range(times_ns.size):
        settle_lags(levels, drive, lags_s[0], lags_s[1], (times_ns[k] - changed_ns) / NS_PER_S, settled)
        tire(fitness, effort, fatigue[0], fatigue[1], fatigue[2], (times_ns[k] - worn_ns) / NS_PER_S, fit[k])
        for i in range(drive.size):
            activation[k, i] = min(settled[1, i], 1.0) * fit[k, i]


@compiled
def limit_pulses(
    recruitment: Array, frequency: Array, highest_hz: float, before: Array, pulses: Array
) -> bool:
    """Fill `pulses` (2, muscles) with both, put within 0 and 1, and 0 and `highest_hz`; whether they changed.

    `before` (2, muscles): what they were.
    """
    changed = False
    for i in range(recruitment.size):
        pulses[0, i] = min(max(recruitment[i], 0.0), 1.0)
        pulses[1, i] = min(max(frequency[i], 0.0), highest_hz)
        changed = changed or pulses[0, i] != before[0, i] or pulses[1, i] != before[1, i]
    return changed


@compiled
def held_drives(
    pulses: Array, effort: Array, reflex: Array, fusion_hz: float, frequency_weight: float
) -> tuple[Array, Array, Array]:
    """Steady activation, the effort that wears the muscles, and their natural drive, (muscles,) each.

    Activation is the recruited fraction times h(f) = r / (1 + r), r = (f / fusion_hz)^2; what wears is
    `MuscleFatigue.effort`; `effort` and `reflex` (muscles,) have the fibres that stimulation does not hold.
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
