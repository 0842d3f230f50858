"""Which samples are new at a tick, kind by kind: those of a sensor may come at different rates.

A kind is new when the newest capture behind it is later than before. What is wrong with samples is told as
`estimators.samples` does it, once, when it changes.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numba
import numpy as np
from numpy.typing import NDArray

from estimators.samples import CLIPPED, LOST, inspect
from fesloop.loop.block import Tick
from fesloop.loop.signals import Sample

KINDS = ("gyr", "acc", "mag")


@numba.njit(cache=True)
def inspect_kinds(gyr: Any, acc: Any, mag: Any, kinds: int, limits: Any, codes: Any) -> int:
    """Fill `codes` (3, n) with what is wrong with samples (n, 3) of the first so many kinds; sum of all."""
    codes[:] = 0
    total = inspect(gyr, limits[0], False, codes[0]) + inspect(acc, limits[1], True, codes[1])
    if kinds > 2:
        total += inspect(mag, limits[2], True, codes[2])
    for s in range(codes.shape[1]):
        # Zeros of both are what stands in a port before the first message.
        if codes[1, s] & LOST and gyr[s, 0] == 0.0 and gyr[s, 1] == 0.0 and gyr[s, 2] == 0.0:
            codes[0, s] |= LOST
            total += LOST
    return total


class Arrivals:
    """Memory of what has arrived: newest capture of each kind, -1 before the first, and the last report.

    Parameters
    ----------
    sensors: how many.
    limits: magnitude from which on gyr, acc and mag are clipped, rad/s, m/s^2, T.
    """

    __slots__ = ("codes", "limits", "newest_ns", "reported")

    def __init__(self, sensors: int, limits: Sequence[float]) -> None:
        self.codes: NDArray[np.uint8] = np.zeros((3, sensors), dtype=np.uint8)
        self.limits, self.newest_ns = np.array(limits), [-1, -1, -1]
        self.reported: tuple[bytes, bool] = (self.codes.tobytes(), False)

    def note(self, samples: Sequence[Sample], tick: Tick) -> tuple[bool, bool, bool]:
        """Which of gyr, acc and mag are new; `codes` (3, n) are brought up to them, trouble is reported."""
        fresh = [False, False, False]
        for kind, sample in enumerate(samples):
            if sample.newest_ns > self.newest_ns[kind]:
                self.newest_ns[kind], fresh[kind] = sample.newest_ns, True
        gyr, acc, mag = samples[0].value, samples[1].value, samples[-1].value
        total = inspect_kinds(gyr, acc, mag, len(samples), self.limits, self.codes)
        if total or not fresh[0] or self.reported[1] or any(self.reported[0]):
            self._report(not fresh[0], tick)
        return fresh[0], fresh[1], fresh[2]

    def _report(self, repeated: bool, tick: Tick) -> None:
        now = (self.codes.tobytes(), repeated)
        if now == self.reported:
            return
        self.reported = now
        for code, status in ((LOST, "lost_sample"), (CLIPPED, "clipped_sample")):
            found = [f"{name} of sensor " + ", ".join(str(s) for s in np.flatnonzero(row & code))
                     for name, row in zip(KINDS, self.codes, strict=True) if (row & code).any()]
            if found:
                tick.report(status, "; ".join(found))
        if repeated:
            tick.report("repeated_sample", "no newer sample of the gyroscopes: the last one is held")
        elif not self.codes.any():
            tick.report("samples_sound", "every sensor gives sound samples again")
