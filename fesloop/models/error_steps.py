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
DRAWS = 5
"""Standard normal numbers that a series takes at each tick: for its slow part and the derivative of that, for
its fast part, for its quick part and the quadrature of that."""
PARTS = 5
"""Numbers that a series remembers: its slow part and the derivative of that, its fast part, its quick part
and the quadrature of that."""


BIAS, SLOPE, CURVE, LEAD, SLOW_SD, SLOW_TIME, FAST_SD, FAST_TIME, QUICK_SD, QUICK_TIME, SPEED, \
    LEAST, GREATEST, RATE, RISE, QUICK_RATE = range(16)
"""Indices of the numbers in a series' row (`ErrorSeries.row`), rad and s."""


SDS = [SLOW_SD, FAST_SD, QUICK_SD]
"""Indices of the sds of the random parts."""


def sizes(size_sd: Array, draws: Array) -> Array:
    """Factors on the random parts in another recording, log-normal with a mean square of 1."""
    return np.asarray(np.exp(size_sd * draws - np.square(size_sd)))


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
def smooth_steps(time_s: float, rise_s: float, elapsed_s: float) -> Any:
    """Transition (2, 2) of a smooth process of variance 1, and root (2, 2) of the covariance of its noise.

    The state is value and derivative, of variance 1 / (time_s rise_s); the root is lower triangular.
    """
    p, q = 1.0 / min(time_s, rise_s), 1.0 / max(time_s, rise_s)
    mean, apart, stiffness = 0.5 * (p + q), p - q, p * q
    # The response of the value to a unit derivative; mean and difference of both time constants' decays.
    decay, quicker = math.exp(-q * elapsed_s), math.exp(-p * elapsed_s)
    response = elapsed_s * decay
    if apart * elapsed_s > 1e-9:
        response = -decay * math.expm1(-apart * elapsed_s) / apart
    steps = np.empty((2, 2))
    steps[0, 0], steps[0, 1] = 0.5 * (decay + quicker) + mean * response, response
    steps[1, 0], steps[1, 1] = -stiffness * response, 0.5 * (decay + quicker) - mean * response
    root = np.zeros((2, 2))
    x = mean * elapsed_s
    if x <= 0.0:
        return steps, root
    # Of a short step the difference would leave but its last bits.
    series = 1.0 - 1.5 * x + 0.6 * (2.0 * x * x + (0.5 * apart * elapsed_s) ** 2 / 3.0)
    spread = 4.0 / 3.0 * mean * stiffness * elapsed_s**3 * series if x < 0.01 else \
        1.0 - steps[0, 0] ** 2 - stiffness * response**2
    root[0, 0] = math.sqrt(spread)
    root[1, 0] = 2.0 * mean * stiffness * response**2 / root[0, 0]
    rest = stiffness * (1.0 - steps[1, 1] ** 2) - steps[1, 0] ** 2 - root[1, 0] ** 2
    root[1, 1] = math.sqrt(max(rest, 0.0))
    return steps, root


@compiled
def move_on(row: Any, parts: Any, rate: float, elapsed_s: float, first: bool, draws: Any) -> None:
    """Move the random parts (PARTS,), rad, on by `elapsed_s`, or begin with their stationary distribution.

    These are slow part and derivative, fast part, quick part and quadrature. `first`: whether to begin.
    `draws`: (DRAWS,), standard normal.
    """
    speed = row[SPEED] * held_within(rate, -row[RATE], row[RATE])
    drive = math.sqrt(1.0 + speed * speed)
    shaken = row[FAST_SD] * drive
    swung = row[QUICK_SD] * drive if row[QUICK_RATE] > 0.0 else row[QUICK_SD]
    if first:
        parts[0], parts[2], parts[3] = row[SLOW_SD] * draws[0], shaken * draws[2], swung * draws[3]
        parts[4] = swung * draws[4] if row[QUICK_RATE] > 0.0 else 0.0
        parts[1] = 0.0
        if row[RISE] > 0.0:
            parts[1] = row[SLOW_SD] / math.sqrt(row[SLOW_TIME] * row[RISE]) * draws[1]
        return
    parts[2] = relaxed(parts[2], shaken, row[FAST_TIME], elapsed_s, draws[2])
    quick = parts[3]
    if row[QUICK_RATE] > 0.0:
        cosine, sine = math.cos(row[QUICK_RATE] * elapsed_s), math.sin(row[QUICK_RATE] * elapsed_s)
        quadrature = cosine * parts[4] - sine * quick
        quick = cosine * quick + sine * parts[4]
        parts[4] = relaxed(quadrature, swung, row[QUICK_TIME], elapsed_s, draws[4])
    parts[3] = relaxed(quick, swung, row[QUICK_TIME], elapsed_s, draws[3])
    if row[RISE] == 0.0:
        parts[0] = relaxed(parts[0], row[SLOW_SD], row[SLOW_TIME], elapsed_s, draws[0])
        return
    steps, root = smooth_steps(row[SLOW_TIME], row[RISE], elapsed_s)
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
    fast, quick = 0.0, 0.0
    for k in range(rates.size):
        speed = row[SPEED] * held_within(rates[k], -row[RATE], row[RATE])
        drive = 1.0 + speed * speed
        elapsed_s = steps_s[k - 1] if k else math.inf
        fast = settled(fast, row[FAST_SD] ** 2 * drive, row[FAST_TIME], elapsed_s)
        swung = row[QUICK_SD] ** 2 * (drive if row[QUICK_RATE] > 0.0 else 1.0)
        quick = settled(quick, swung, row[QUICK_TIME], elapsed_s)
        variance[k] = row[SLOW_SD] ** 2 + fast + quick
    return variance


@compiled
def settled(variance: float, final: float, time_s: float, elapsed_s: float) -> Any:
    """Variance of an Ornstein-Uhlenbeck process `elapsed_s` later, on its way to its final variance."""
    kept = math.exp(-2.0 * elapsed_s / time_s) if time_s > 0.0 else 0.0
    return kept * variance + (1.0 - kept) * final
