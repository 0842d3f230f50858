"""The arithmetic of one PID tick, from joint errors to muscle drives."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from controllers.limits.allocation import allocate
from fesloop.compiled import compiled

Array = NDArray[np.float64]
INTEGRAL, DERIVATIVE, PREVIOUS = 0, 1, 2
"""Rows of the memory: integral part, filtered derivative part, measurement of the tick before."""
RUNNING, SATURATED, NON_FINITE = 0, 1, 2
"""What a tick comes to."""


@compiled
def pid_tick(
    gains: Array, mixing: Array, channels: Array, table: Array, memory: Array, primed: bool,
    reference: Array, measured: Array,
) -> tuple[int, Array]:
    """One tick: (RUNNING, SATURATED or NON_FINITE, pulses (muscles, 2) in A and s).

    Parameters
    ----------
    gains: (joints, 4): kp, ki h, alpha, beta as `Pid` defines them.
    mixing: (muscles, joints).
    channels: (muscles, 3): bias, least and greatest drive.
    table: of `Allocation.table`.
    memory: (3, joints), updated in place; left alone on non-finite input, not on overflow inside.
    primed: whether `memory` holds a previous measurement.
    """
    muscles, joints = mixing.shape
    pulses = np.zeros((muscles, 2))
    for j in range(joints):
        if not (math.isfinite(reference[j]) and math.isfinite(measured[j])):
            return NON_FINITE, pulses
    drive = channels[:, 0].copy()
    for j in range(joints):
        moved = measured[j] - memory[PREVIOUS, j] if primed else 0.0
        memory[DERIVATIVE, j] = gains[j, 2] * memory[DERIVATIVE, j] - gains[j, 3] * moved
        memory[PREVIOUS, j] = measured[j]
        command = gains[j, 0] * (reference[j] - measured[j]) + memory[INTEGRAL, j] + memory[DERIVATIVE, j]
        for i in range(muscles):
            drive[i] += mixing[i, j] * command
    for i in range(muscles):
        if not math.isfinite(drive[i]):
            return NON_FINITE, pulses
    for j in range(joints):
        growth = gains[j, 1] * (reference[j] - measured[j])
        if can_follow(mixing[:, j], channels, drive, growth):
            memory[INTEGRAL, j] += growth
    for i in range(muscles):
        drive[i] = min(max(drive[i], channels[i, 1]), channels[i, 2])
    saturated = allocate(table, drive, pulses)
    return (SATURATED if saturated else RUNNING), pulses


@compiled
def can_follow(weights: Array, channels: Array, drive: Array, growth: float) -> bool:
    """Whether the integral of a joint may grow: a muscle follows it, or it leads most out of saturation."""
    deeper, back = 0.0, 0.0
    for i in range(weights.size):
        change = weights[i] * growth
        low, high = drive[i] <= channels[i, 1], drive[i] >= channels[i, 2]
        if not low and not high and change != 0.0:
            return True
        if (low and change < 0.0) or (high and change > 0.0):
            deeper += abs(weights[i])
        elif change != 0.0:
            back += abs(weights[i])
    return back >= deeper
