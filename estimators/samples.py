"""Samples that a tracker must not take at face value: lost, clipped, or seen before.

A sample is lost where a number in it is not finite, and where the acceleration (or field) is exactly zero,
which no sensor gives: it is what stands in a port before the first message and in place of a value that was
not finite. Trouble is reported when it starts, changes and ends, not at every tick of it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numba
import numpy as np
from numpy.typing import NDArray

from fesloop.loop.block import Tick
from fesloop.loop.signals import Sample

LOST, CLIPPED = 1, 2


@dataclass(slots=True, eq=False)
class SampleWatch:
    """What is wrong with the samples of `codes.size` sensors now.

    Attributes
    ----------
    codes: (n,), LOST and CLIPPED of each sensor at this tick.
    reported: codes and repetition as last reported.
    newest_ns: newest capture read so far, an entry a kind of sample (gyr, acc, ...).
    """

    codes: NDArray[np.uint8]
    reported: tuple[bytes, bool] = (b"", False)
    newest_ns: list[int] = field(default_factory=list)

    @classmethod
    def of(cls, sensors: int, kinds: int) -> SampleWatch:
        """For `kinds` kinds of samples of `sensors` sensors."""
        codes = np.zeros(sensors, dtype=np.uint8)
        return cls(codes, (codes.tobytes(), False), [-1] * kinds)

    def usable(self) -> NDArray[np.bool_]:
        """Sensors whose sample is not lost, (n,)."""
        return np.asarray(self.codes & LOST == 0)


@numba.njit(cache=True)
def inspect(vectors: Any, limit: float, zero_is_lost: bool, codes: Any) -> int:
    """Add to `codes` (n,) what is wrong with `vectors` (n, 3); give the sum of all codes."""
    total = 0
    for i in range(vectors.shape[0]):
        x, y, z = abs(vectors[i, 0]), abs(vectors[i, 1]), abs(vectors[i, 2])
        size = x + y + z
        if not size < math.inf or (zero_is_lost and size == 0.0):
            codes[i] |= LOST
        elif x >= limit or y >= limit or z >= limit:
            codes[i] |= CLIPPED
        total += codes[i]
    return total


def watch_samples(
    watch: SampleWatch, samples: Sequence[Sample], limits: Sequence[float], tick: Tick
) -> bool:
    """Whether no sensor's sample is lost at this tick; trouble is reported.

    Parameters
    ----------
    samples: one of each kind, gyr first; a gyroscope may well read zero, the others may not.
    limits: magnitude from which on each kind is clipped.
    """
    watch.codes[:] = 0
    total = 0
    repeated = False
    newest = watch.newest_ns
    for kind, (value, _, captured, _) in enumerate(samples):
        total = inspect(value, limits[kind], kind > 0, watch.codes)
        repeated = repeated or captured == newest[kind]
        newest[kind] = captured
    if total or repeated or watch.reported[1] or any(watch.reported[0]):
        _report(watch, repeated, tick)
        return bool(watch.usable().all())
    return True


def _report(watch: SampleWatch, repeated: bool, tick: Tick) -> None:
    now = (watch.codes.tobytes(), repeated)
    if now == watch.reported:
        return
    watch.reported = now
    for code, status in ((LOST, "lost_sample"), (CLIPPED, "clipped_sample")):
        sensors = np.flatnonzero(watch.codes & code)
        if sensors.size:
            tick.report(status, "sensor " + ", ".join(str(i) for i in sensors))
    if repeated and not (watch.codes & LOST).any():
        tick.report("repeated_sample", "no newer sample has arrived: the last one is held")
    if not repeated and not watch.codes.any():
        tick.report("samples_sound", "every sensor gives sound samples again")
