"""What is wrong with a sample: lost, clipped or frozen.

A sample is lost where a number in it is not finite, or a hundred times what its sensor can read, and where
the acceleration (or field) is exactly zero, which no sensor gives: it is what stands in a port before the
first message and in place of a value that was not finite. Frozen is a sensor that repeats its rate and its
acceleration to the last bit for a while, which noise forbids. While it says that it turns, its samples are
lost; what it says at rest is believed, as a simulated sensor without noise reads the same: it is told of,
unless its rate is zero.
"""

from __future__ import annotations

import math
from typing import Any

from fesloop.compiled import compiled

LOST, CLIPPED = 1, 2
_NO_RATE = 1e-6
"""Below it a rate is zero but for rounding, rad/s (far below what any sensor of a hand resolves)."""
_TURNING = 0.3
"""Sum of a rate's components above which a sensor turns, rad/s (a MEMS gyroscope's bias: 5 deg/s an axis)."""
_ABSURD = 100.0
"""A number that is so many times its sensor's range is not the sensor's (chosen: a garbled stream has numbers
of any size, and filters overflow)."""
GYR, ACC, MAG = 1, 2, 4
"""Bits of sets of kinds of samples."""


@compiled
def inspect(vectors: Any, limit: float, zero_is_lost: bool, codes: Any) -> int:
    """Add to `codes` (n,) what is wrong with `vectors` (n, 3); give the sum of all codes."""
    total, absurd = 0, _ABSURD * limit
    for i in range(vectors.shape[0]):
        x, y, z = abs(vectors[i, 0]), abs(vectors[i, 1]), abs(vectors[i, 2])
        size = x + y + z
        if not size < math.inf or max(x, y, z) > absurd or (zero_is_lost and size == 0.0):
            codes[i] |= LOST
        elif x >= limit or y >= limit or z >= limit:
            codes[i] |= CLIPPED
        total += codes[i]
    return total


@compiled
def inspect_kinds(
    gyr: Any, acc: Any, mag: Any, kinds: int, silent: int, limits: Any, read: Any, stuck: Any,
    stuck_limit: int, codes: Any
) -> bool:
    """Fill `codes` (3, n) with what is wrong with samples (n, 3) of the first so many kinds.

    Whether anything is, or a sensor frozen.

    Parameters
    ----------
    silent: kinds whose samples are too old to count.
    limits: (3,), magnitude from which on each kind is clipped.
    read: (n,), magnetometers that are read; of others nothing is told.
    stuck: (n,), as of `compare`; from `stuck_limit` on a sensor is frozen.
    """
    codes[:] = 0
    inspect(gyr, limits[0], False, codes[0])
    inspect(acc, limits[1], True, codes[1])
    if kinds > 2:
        inspect(mag, limits[2], True, codes[2])
    wrong = False
    for s in range(codes.shape[1]):
        frozen = stuck[s] >= stuck_limit
        rate = abs(gyr[s, 0]) + abs(gyr[s, 1]) + abs(gyr[s, 2])
        # Zeros of both are what stands in a port before the first message.
        if codes[1, s] & LOST and rate == 0.0:
            codes[0, s] |= LOST
        for kind in range(kinds):
            if silent & (1 << kind) or (frozen and rate > _TURNING):
                codes[kind, s] = LOST
        if not read[s]:
            codes[2, s] = 0
        wrong |= frozen or codes[0, s] + codes[1, s] + codes[2, s] > 0
    return wrong


@compiled
def compare(gyr: Any, acc: Any, mag: Any, newer: bool, before: Any, stuck: Any) -> int:
    """Kinds of which any number is another than `before` (3, n, 3), which becomes these samples (n, 3).

    Parameters
    ----------
    newer: whether the rates are said to be new.
    stuck: (n,), for how many new samples in a row a sensor has repeated them; brought up to date.
    """
    changed = 0
    for s in range(stuck.size):
        rate, moved = 0.0, 0
        for i in range(3):
            rate += abs(gyr[s, i])
            moved |= GYR if gyr[s, i] != before[0, s, i] else 0
            moved |= ACC if acc[s, i] != before[1, s, i] else 0
            moved |= MAG if mag[s, i] != before[2, s, i] else 0
            before[0, s, i], before[1, s, i], before[2, s, i] = gyr[s, i], acc[s, i], mag[s, i]
        if newer:
            stuck[s] = 0 if moved & (GYR | ACC) or rate < _NO_RATE else stuck[s] + 1
        changed |= moved
    return changed
