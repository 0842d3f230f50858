"""The error process step by step: what follows from the motion, and what is random.

The same kernels move a simulated tracker's error in a loop and make the ensembles by which a fit is judged.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.compiled import compiled
from fesloop.models.error_process import ErrorSeries

Array = NDArray[np.float64]
DRAWS = 4
"""Standard normal numbers that a series takes at each tick: for its slow part and the derivative of that, for
its fast and its quick part."""
PARTS = 4
"""Numbers that a series remembers: its slow part and the derivative of that, its fast and its quick part."""


BIAS, SLOPE, CURVE, LEAD, SLOW_SD, SLOW_TIME, FAST_SD, FAST_TIME, QUICK_SD, QUICK_TIME, SPEED, \
    LEAST, GREATEST, RATE, SMOOTH = range(15)
"""Indices of the numbers in a series' row (`ErrorSeries.row`), rad and s."""


def rows_of(series: Sequence[ErrorSeries]) -> Array:
    """Their rows, (series, columns)."""
    return np.array([each.row() for each in series])


@compiled
def held_within(value: Any, least: Any, greatest: Any) -> Any:
    """The value, or the bound that it is beyond."""
    return min(max(value, least), greatest)


@compiled
def following(row: Any, angle: float, rate: float) -> Any:
    """Error that follows from the motion, rad: `angle` from its centre, rad, and `rate`, rad/s."""
    a = held_within(angle, row[LEAST], row[GREATEST])
    turning = held_within(rate, -row[RATE], row[RATE])
    return row[BIAS] + row[SLOPE] * a + row[CURVE] * a * a + row[LEAD] * turning


@compiled
def along(row: Any, angles: Any, rates: Any) -> Any:
    """Error that follows from a motion, (n,), rad; angles and rates (n,)."""
    errors = np.empty(angles.size)
    for k in range(angles.size):
        errors[k] = following(row, angles[k], rates[k])
    return errors


@compiled
def relaxed(value: float, sd: float, time_s: float, elapsed_s: float, draw: float) -> Any:
    """An Ornstein-Uhlenbeck process `elapsed_s` later, exactly."""
    kept = math.exp(-elapsed_s / time_s) if time_s > 0.0 else 0.0
    return kept * value + sd * math.sqrt(1.0 - kept * kept) * draw


@compiled
def smooth_steps(time_s: float, elapsed_s: float) -> Any:
    """Transition (2, 2) of a smooth process of variance 1, and root (2, 2) of the covariance of its noise.

    The state is value and derivative, of variance 1 / time_s^2; the root is lower triangular.
    """
    pace = 1.0 / time_s
    x = pace * elapsed_s
    kept = math.exp(-x)
    steps = np.empty((2, 2))
    steps[0, 0], steps[0, 1] = kept * (1.0 + x), kept * elapsed_s
    steps[1, 0], steps[1, 1] = -kept * pace * x, kept * (1.0 - x)
    root = np.zeros((2, 2))
    if x <= 0.0:
        return steps, root
    # Of a short step the difference would leave but its last bits.
    spread = 4.0 / 3.0 * x**3 * (1.0 - 1.5 * x + 1.2 * x * x) if x < 0.01 else \
        1.0 - kept * kept * (1.0 + 2.0 * x + 2.0 * x * x)
    root[0, 0] = math.sqrt(spread)
    root[1, 0] = 2.0 * pace * (kept * x) ** 2 / root[0, 0]
    rest = pace * pace * (1.0 - kept * kept * (1.0 - 2.0 * x + 2.0 * x * x)) - root[1, 0] ** 2
    root[1, 1] = math.sqrt(max(rest, 0.0))
    return steps, root


@compiled
def move_on(row: Any, parts: Any, rate: float, elapsed_s: float, first: bool, draws: Any) -> None:
    """Move slow part, its derivative, fast and quick part, `parts` (PARTS,), rad, on by `elapsed_s`.

    `first`: begin instead, each with its stationary distribution. `draws`: (DRAWS,), standard normal.
    """
    speed = row[SPEED] * held_within(rate, -row[RATE], row[RATE])
    shaken = row[FAST_SD] * math.sqrt(1.0 + speed * speed)
    if first:
        parts[0], parts[2], parts[3] = row[SLOW_SD] * draws[0], shaken * draws[2], row[QUICK_SD] * draws[3]
        parts[1] = row[SLOW_SD] / row[SLOW_TIME] * draws[1] if row[SMOOTH] > 0.0 else 0.0
        return
    parts[2] = relaxed(parts[2], shaken, row[FAST_TIME], elapsed_s, draws[2])
    parts[3] = relaxed(parts[3], row[QUICK_SD], row[QUICK_TIME], elapsed_s, draws[3])
    if row[SMOOTH] == 0.0:
        parts[0] = relaxed(parts[0], row[SLOW_SD], row[SLOW_TIME], elapsed_s, draws[0])
        return
    steps, root = smooth_steps(row[SLOW_TIME], elapsed_s)
    value, derivative = parts[0], parts[1]
    parts[0] = steps[0, 0] * value + steps[0, 1] * derivative + row[SLOW_SD] * root[0, 0] * draws[0]
    parts[1] = (steps[1, 0] * value + steps[1, 1] * derivative
                + row[SLOW_SD] * (root[1, 0] * draws[0] + root[1, 1] * draws[1]))


@compiled
def errors_now(
    rows: Any, parts: Any, angles: Any, rates: Any, elapsed_s: float, first: bool, draws: Any
) -> Any:
    """Error of each series at the next tick, (n,), rad.

    Parameters
    ----------
    rows: (n, columns). parts: (n, PARTS), as of `move_on`, moved on.
    angles, rates: (n,), from the centre, rad, and rad/s.
    elapsed_s: since the tick before. first: whether there was none.
    draws: (DRAWS, n), standard normal.
    """
    errors = np.empty(rows.shape[0])
    for i in range(rows.shape[0]):
        row = rows[i]
        move_on(row, parts[i], rates[i], elapsed_s, first, draws[:, i])
        random = parts[i, 0] + parts[i, 2] + parts[i, 3]
        errors[i] = following(row, angles[i], rates[i]) + random
    return errors


@compiled
def ensemble(row: Any, angles: Any, rates: Any, steps_s: Any, draws: Any) -> Any:
    """Errors of one series along a given motion, many times over: (runs, n), rad.

    Parameters
    ----------
    row: (columns,). angles, rates: (n,). steps_s: (n,), from each instant to the next; the last is not used.
    draws: (runs, DRAWS, n), standard normal.
    """
    runs, samples = draws.shape[0], angles.size
    errors = np.empty((runs, samples))
    parts = np.zeros(PARTS)
    for r in range(runs):
        for k in range(samples):
            elapsed_s = steps_s[k - 1] if k else 0.0
            move_on(row, parts, rates[k], elapsed_s, k == 0, draws[r, :, k])
            random = parts[0] + parts[2] + parts[3]
            errors[r, k] = following(row, angles[k], rates[k]) + random
    return errors


@compiled
def random_variance(row: Any, rates: Any, steps_s: Any) -> Any:
    """Variance of the random part along a motion, (n,), rad^2: exactly, without any draw."""
    variance = np.empty(rates.size)
    fast = 0.0
    for k in range(rates.size):
        speed = row[SPEED] * held_within(rates[k], -row[RATE], row[RATE])
        shaken = row[FAST_SD] ** 2 * (1.0 + speed * speed)
        kept = math.exp(-2.0 * steps_s[k - 1] / row[FAST_TIME]) if k and row[FAST_TIME] > 0.0 else 0.0
        fast = kept * fast + (1.0 - kept) * shaken
        variance[k] = row[SLOW_SD] ** 2 + fast + row[QUICK_SD] ** 2
    return variance
