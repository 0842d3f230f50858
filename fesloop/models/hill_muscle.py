"""A Hill muscle in series with a tendon that yields: force from the course of length and drive.

Lengths of the fibres, l, are relative to the optimal one, forces to the largest isometric one, velocities to
the fastest shortening:

    tau c' = drive - c                                      calcium, 0 to 1
    s = half exp(-sensitivity (l - 1))
    a = (1 + half^3) c^3 / (c^3 + s^3)                      active state, 1 at c = 1 and l = 1
    T(L - l) = a F(l) V(l') + P(l) + damping l'             equilibrium of tendon and fibres
    T = (strain of the tendon / strain at the largest force)^2, 0 where it is slack

F, V, P are the curves of De Groote 2016 (doi 10.1007/s10439-016-1591-9): a sum of three bells, an inverse
hyperbolic sine and an exponential. T is the quadratic spring of van Soest and Bobbert 1993 (doi
10.1007/BF00198959). Damping makes l' unique at any activation (Millard 2013, doi 10.1115/1.4023390). Calcium
that acts by its cube is Hatze's; that fibres are more sensitive to it when longer, Kistemaker's (2005, J
Biomech 38:1816). Pennation is left out.

The fibre's length is integrated by an L-stable implicit Runge-Kutta method of second order, two stages
(Alexander 1977, doi 10.1137/0714068), calcium in closed form.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.compiled import compiled
from fesloop.errors import InputError

Array = NDArray[np.float64]
_GAMMA = 1.0 - 1.0 / math.sqrt(2.0)
_NARROW, _MOST = 1e-12, 100
"""Relative tolerance of a stage's velocity, and most iterations."""
SHORTEST, _LEAST = 0.3, 0.014289
"""Relative fibre length below which the curve of active force is a line, and the force there."""


class Coefficients(NamedTuple):
    """Parameters of a `HillMuscle` in the form that the kernels take; lengths in m, times in s."""

    force: float
    fibre: float
    slack: float
    yields: float
    fastest: float
    passive: float
    damping: float
    calcium: float
    half: float
    sensitivity: float


@compiled
def force_length(length: float) -> tuple[float, float]:
    """Active force at a relative fibre length, and its slope (De Groote 2016, eq. S3).

    Below `SHORTEST`, where a bell of theirs has no width, it falls in proportion to length (chosen).
    """
    if length < SHORTEST:
        return (_LEAST * length / SHORTEST, _LEAST / SHORTEST) if length > 0.0 else (0.0, 0.0)
    force, slope = 0.0, 0.0
    for height, centre, width, growth in ((0.815, 1.055, 0.162, 0.063), (0.433, 0.717, -0.030, 0.200),
                                          (0.100, 1.000, 0.354, 0.0)):
        spread = width + growth * length
        off = (length - centre) / spread
        bell = height * math.exp(-0.5 * off * off)
        force += bell
        slope -= bell * off * (1.0 - off * growth) / spread
    return force, slope


@compiled
def force_velocity(velocity: float) -> tuple[float, float]:
    """Force at a relative velocity, positive in stretch, and its slope (De Groote 2016, eq. S4)."""
    x = -8.149 * velocity - 0.374
    return 0.886 - 0.318 * math.asinh(x), 0.318 * 8.149 / math.sqrt(x * x + 1.0)


@compiled
def passive_force(length: float) -> tuple[float, float]:
    """Passive force, 1 at a relative length of 1.6, and its slope (De Groote 2016, eq. S5); 0 below 1."""
    if length <= 1.0:
        return 0.0, 0.0
    grown = math.exp(4.0 * (length - 1.0) / 0.6)
    full = math.exp(4.0) - 1.0
    return (grown - 1.0) / full, 4.0 / 0.6 * grown / full


@compiled
def tendon_force(whole: float, length: float, muscle: Coefficients) -> tuple[float, float]:
    """Relative force of the tendon at a muscle-tendon length, m, and minus its slope over fibre length."""
    stretch = (whole - muscle.fibre * length - muscle.slack) / muscle.yields
    if stretch <= 0.0:
        return 0.0, 0.0
    return stretch * stretch, 2.0 * stretch * muscle.fibre / muscle.yields


@compiled
def active_state(calcium: float, length: float, muscle: Coefficients) -> tuple[float, float]:
    """Active state, and its slope over fibre length."""
    bound = calcium**3
    threshold = (muscle.half * math.exp(-muscle.sensitivity * (length - 1.0))) ** 3
    state = (1.0 + muscle.half**3) * bound / (bound + threshold)
    return state, 3.0 * muscle.sensitivity * state * threshold / (bound + threshold)


@compiled
def excess(
    rate: float, start: float, reach: float, whole: float, calcium: float, muscle: Coefficients
) -> tuple[float, float]:
    """Tendon force minus fibre force at the length `start` + `reach` `rate`, and its slope over `rate`."""
    length, velocity = start + reach * rate, rate / muscle.fastest
    pull, stiff = tendon_force(whole, length, muscle)
    state, state_slope = active_state(calcium, length, muscle)
    bell, bell_slope = force_length(length)
    gain, gain_slope = force_velocity(velocity)
    held, held_slope = passive_force(length)
    value = pull - state * bell * gain - muscle.passive * held - muscle.damping * velocity
    slope = -(reach * (stiff + (state_slope * bell + state * bell_slope) * gain + muscle.passive * held_slope)
              + (state * bell * gain_slope + muscle.damping) / muscle.fastest)
    return value, slope


@compiled
def stage_rate(
    guess: float, start: float, reach: float, whole: float, calcium: float, muscle: Coefficients
) -> float:
    """Rate of fibre length, 1/s, at which tendon and fibres are in equilibrium at the end of a stage.

    Newton's method, which halves its bracket instead wherever it would leave it or converge slowly.
    """
    low, high, rate, moved = -1e5, 1e5, guess, 2e5
    for _ in range(_MOST):
        value, slope = excess(rate, start, reach, whole, calcium, muscle)
        if value > 0.0:
            low = rate
        else:
            high = rate
        following = 0.5 * (low + high)
        if slope < 0.0 and low < rate - value / slope < high and 2.0 * abs(value) < abs(moved * slope):
            following = rate - value / slope
        moved, rate = abs(following - rate), following
        if moved <= _NARROW * (1.0 + abs(rate)):
            break
    return rate


@compiled
def advance(
    length: float, calcium: float, rate: float, before: float, after: float, drive: float, step: float,
    muscle: Coefficients,
) -> tuple[float, float, float]:
    """Relative fibre length, calcium, and rate of the fibre's length `step` s later.

    The muscle-tendon length goes from `before` to `after`, m, at constant speed; `drive` is constant.
    """
    part = _GAMMA * step
    short = calcium - drive
    first = stage_rate(rate, length, part, before + _GAMMA * (after - before),
                       drive + short * math.exp(-part / muscle.calcium), muscle)
    calcium = drive + short * math.exp(-step / muscle.calcium)
    start = length + (step - part) * first
    second = stage_rate(first, start, part, after, calcium, muscle)
    return start + part * second, calcium, second


@compiled
def resting_length(whole: float, muscle: Coefficients) -> float:
    """Relative fibre length of the muscle without drive at a constant muscle-tendon length, m.

    Where nothing pulls, the tendon is just slack.
    """
    high = (whole - muscle.slack) / muscle.fibre
    low = min(high, 1.0)
    for _ in range(_MOST):
        middle = 0.5 * (low + high)
        if excess(0.0, middle, 0.0, whole, 0.0, muscle)[0] > 0.0:
            low = middle
        else:
            high = middle
    return high


@compiled
def follow(lengths: Array, drive: Array, step: float, parts: int, muscle: Coefficients, force: Array) -> None:
    """Fill `force` (n,), N, at muscle-tendon `lengths` (n,), m, from rest; `drive` (n,) holds for a step."""
    length, calcium, rate = resting_length(lengths[0], muscle), 0.0, 0.0
    force[0] = muscle.force * tendon_force(lengths[0], length, muscle)[0]
    for i in range(lengths.size - 1):
        rise = (lengths[i + 1] - lengths[i]) / parts
        for k in range(parts):
            length, calcium, rate = advance(length, calcium, rate, lengths[i] + k * rise,
                                            lengths[i] + (k + 1) * rise, drive[i], step / parts, muscle)
        force[i + 1] = muscle.force * tendon_force(lengths[i + 1], length, muscle)[0]


@dataclass(frozen=True, slots=True, kw_only=True)
class HillMuscle:
    """A muscle with a tendon that yields; equations and sources are in the module's docstring.

    The default is a medial gastrocnemius of a rat, rounded from fits to two of them.

    Attributes
    ----------
    force_n: largest isometric force, at the optimal fibre length under full drive, N.
    fibre_mm: optimal fibre length, mm.
    slack_mm: length of the tendon (aponeurosis included) below which it is slack, mm.
    strain: of the tendon under `force_n`, relative to `slack_mm`.
    fastest: velocity of unloaded shortening, optimal lengths per second.
    passive: force of the parallel spring at 1.6 optimal lengths over `force_n`.
    calcium_ms: time constant of calcium, ms.
    half: calcium of half activation at the optimal length.
    sensitivity: growth of the logarithm of sensitivity to calcium over an optimal length of stretch.
    damping: force of damping at the fastest shortening, over `force_n` (.1: Millard 2013).
    """

    force_n: float = 15.0
    fibre_mm: float = 14.0
    slack_mm: float = 29.0
    strain: float = 0.1
    fastest: float = 12.0
    passive: float = 0.2
    calcium_ms: float = 28.0
    half: float = 0.45
    sensitivity: float = 1.7
    damping: float = 0.1

    def __post_init__(self) -> None:
        for name in ("force_n", "fibre_mm", "slack_mm", "strain", "fastest", "calcium_ms", "half", "damping"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0.0):
                raise InputError(f"muscle.{name}", f"{value}", "a finite number above 0")
        for name in ("passive", "sensitivity"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value >= 0.0):
                raise InputError(f"muscle.{name}", f"{value}", "a finite number, 0 or more")

    @property
    def coefficients(self) -> Coefficients:
        """Parameters in the form that the kernels take."""
        slack = 1e-3 * self.slack_mm
        return Coefficients(self.force_n, 1e-3 * self.fibre_mm, slack, slack * self.strain, self.fastest,
                            self.passive, self.damping, 1e-3 * self.calcium_ms, self.half, self.sensitivity)

    def force(self, lengths_m: Array, drive: Array, step_s: float, *, parts: int = 1) -> Array:
        """Force (n,), N, that begins at rest.

        At a step of 1 ms it differs from the exact solution by at most 1 % of `force_n`, .1 % in the root
        mean square (medians .007 and .002 %), where the length changes no faster than unloaded fibres
        shorten, the tendon yields by at least a tenth of the optimal fibre length under `force_n`, and
        `passive` is at most 1 (tests/models/test_hill_muscle.py); it falls with the square of the step.

        Parameters
        ----------
        lengths_m: (n,), of muscle and tendon, m, linear between samples.
        drive: (n,), fraction of fibres that pulses act on, from 0 to 1, constant until the next sample.
        step_s: time between samples, s.
        parts: steps of integration between two samples.

        Raises InputError for arrays of other shapes, with numbers that are not finite, or for a drive beyond
        0 to 1.
        """
        lengths, driven = np.asarray(lengths_m, np.float64), np.asarray(drive, np.float64)
        if lengths.ndim != 1 or lengths.size == 0 or lengths.shape != driven.shape:
            raise InputError("lengths and drive", f"have the shapes {lengths.shape} and {driven.shape}",
                             "two series of the same number of samples")
        if not np.isfinite(lengths).all():
            raise InputError("lengths", "are not all finite", "metres")
        if not ((driven >= 0.0) & (driven <= 1.0)).all():
            raise InputError("drive", "lies beyond 0 to 1, or is not finite", "0 to 1")
        if not (math.isfinite(step_s) and step_s > 0.0) or parts < 1:
            raise InputError("step and parts", f"{step_s}, {parts}", "a step above 0, 1 part or more")
        force = np.empty_like(lengths)
        follow(np.ascontiguousarray(lengths), np.ascontiguousarray(driven), step_s, parts, self.coefficients,
               force)
        return force
