"""Detection of new samples at a tick by kind, and of lost, clipped and frozen ones.

Gyroscope, accelerometer and magnetometer may have rates of their own. A sample is new when its newest capture
is later than before. Samples that passed a block together with the gyroscopes', or were recorded with them,
have their stamps even where they were held: such a sample is old when it equals the one before to the last
bit, while the gyroscopes' does not. A sample that has been held for too long counts as lost.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.compiled import compiled
from fesloop.loop.block import Tick
from fesloop.loop.clock import NS_PER_S
from fesloop.loop.signals import Sample

LOST, CLIPPED = 1, 2
_NO_RATE = 1e-6
"""Rate below which it is zero but for rounding, rad/s (far below the resolution of any sensor)."""
_TURNING = 0.3
"""Sum of a rate's components above which a sensor turns, rad/s (a MEMS gyroscope's bias: 5 deg/s an axis)."""
_ABSURD = 100.0
"""Multiple of the sensor range beyond which samples are rejected (chosen: a garbled stream has numbers of any
size, and filters overflow)."""
GYR, ACC, MAG = 1, 2, 4
"""Bits of sets of kinds of samples."""


@compiled
def inspect(vectors: Any, limit: float, zero_is_lost: bool, codes: Any) -> int:
    """Add the fault codes of `vectors` (n, 3) to `codes` (n,); return the sum of all codes."""
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
    samples: Any, kinds: int, silent: int, limits: Any, read: Any, stuck: Any, stuck_limit: int, codes: Any
) -> bool:
    """Fill `codes` (3, n) with the fault codes of `samples` (3, n, 3); return whether there is a fault.

    Parameters
    ----------
    silent: kinds whose samples are too old to count.
    limits: (3,), magnitude above which each kind is clipped.
    read: (n,), mask of the magnetometers in use; others have no codes.
    stuck: (n,), as in `compare`; from `stuck_limit` on a sensor is frozen.
    """
    codes[:] = 0
    for kind in range(kinds):
        inspect(samples[kind], limits[kind], kind > 0, codes[kind])
    wrong = False
    for s in range(codes.shape[1]):
        frozen = stuck[s] >= stuck_limit
        rate = abs(samples[0, s, 0]) + abs(samples[0, s, 1]) + abs(samples[0, s, 2])
        # Zeros of both are the value of a port before the first message.
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
    """Bits of the kinds that differ from `before` (3, n, 3), which is updated to these samples (n, 3).

    Parameters
    ----------
    newer: whether the rates are new by their stamps.
    stuck: (n,), number of successive new samples that repeat the one before; updated.
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


KINDS = ("gyr", "acc", "mag")
Elapsed = tuple[float, float, float]
_HELD_PERIODS = 5.0
"""Periods for which a rate may be held (chosen: a wireless link's usual jitter)."""
_HELD_S = 0.5
"""Time for which an acceleration or a field may be held, s (chosen: no sensor of a hand is slower)."""
_FROZEN_SAMPLES, _FROZEN_S = 10, 0.1
"""Repetitions, and their duration, above which a sensor is frozen (chosen: noise changes a last bit)."""


def listed(mask: NDArray[Any], names: Sequence[str]) -> str:
    """Names of the sensors of a mask (n,), or their numbers where there are no names."""
    return ", ".join(names[s] if names else str(s) for s in np.flatnonzero(mask).tolist())


class Arrivals:
    """Monitor of the samples of n sensors, which reports changes of their faults.

    Attributes
    ----------
    codes: (3, n), LOST and CLIPPED of each kind at the newest tick.
    samples: (3, n, 3), newest samples of each kind; without magnetometers the last are the second.
    sound: whether no sample is lost.
    faultless: whether none is lost, clipped or frozen.
    period_s: period of the gyroscopes.
    newest_ns: capture of the newest sample of each kind; -1 before the first.

    Parameters
    ----------
    sensors: n.
    limits: magnitudes above which gyr, acc and mag are clipped, rad/s, m/s^2, T.
    period_s: period of the gyroscopes.
    read: (n,), mask of the magnetometers in use; None: all.
    names: of the sensors, for messages; empty: their numbers.
    """

    __slots__ = ("_limits", "_names", "_new_at_ns", "_reached_ns", "_read", "_reported", "_stuck",
                 "_stuck_limit", "_troubled", "codes", "faultless", "newest_ns", "period_s", "samples",
                 "sound")

    def __init__(
        self, sensors: int, limits: Sequence[float], period_s: float, read: NDArray[np.bool_] | None = None,
        names: Sequence[str] = ()
    ) -> None:
        self._names = names
        self.codes = np.zeros((3, sensors), dtype=np.uint8)
        self.samples = np.zeros((3, sensors, 3))
        self.sound = self.faultless = True
        self.period_s, self.newest_ns = period_s, [-1, -1, -1]
        self._limits = np.array(limits)
        self._read = np.ones(sensors, dtype=np.bool_) if read is None else read.copy()
        self._stuck = np.zeros(sensors, dtype=np.int64)
        self._stuck_limit = max(_FROZEN_SAMPLES, math.ceil(_FROZEN_S / period_s))
        self._new_at_ns = [0, 0, 0]
        self._reached_ns = 0
        self._troubled = False
        self._reported = (self.codes.tobytes(), b"", False)

    def usable(self) -> NDArray[np.bool_]:
        """Mask of the sensors without a lost sample, (n,)."""
        return np.asarray(np.bitwise_or.reduce(self.codes) & LOST == 0)

    def note(self, samples: Sequence[Sample], tick: Tick) -> Elapsed:
        """Time since the sample before the new one, for each kind, s; 0 without a new one.

        Rates that have been held for too long count as new and lost, at each tick.
        """
        gyr, acc, mag = samples[0].value, samples[1].value, samples[-1].value
        later = samples[0].newest_ns > self.newest_ns[0]
        changed = compare(gyr, acc, mag, later, self.samples, self._stuck)
        turned = later and changed & GYR
        elapsed, silent = [0.0, 0.0, 0.0], 0
        for kind, sample in enumerate(samples):
            captured, before = sample.newest_ns, self.newest_ns[kind]
            held = turned and not changed & (1 << kind) and captured == self.newest_ns[0]
            if captured > before and not (kind and held):
                elapsed[kind] = self._since(before, captured, kind)
                self.newest_ns[kind] = captured
                self._new_at_ns[kind] = tick.time_ns
            elif self._too_old(kind, tick):
                silent |= 1 << kind
        repeated = elapsed[0] == 0.0
        if not repeated:
            self._reached_ns = 0
        elif silent & GYR and self.newest_ns[0] >= 0:
            reached = self._reached_ns or self._new_at_ns[0]
            elapsed[0] = (tick.time_ns - reached) / NS_PER_S
            self._reached_ns = tick.time_ns
        wrong = inspect_kinds(self.samples, len(samples), silent, self._limits, self._read, self._stuck,
                              self._stuck_limit, self.codes)
        self.faultless = not wrong
        self.sound = not (wrong and (self.codes & LOST).any())
        if wrong or repeated or self._troubled:
            self._report(repeated, tick)
        return elapsed[0], elapsed[1], elapsed[2]

    def _since(self, before: int, captured: int, kind: int) -> float:
        """Time to a new sample, s, less the time that has been counted since the last one."""
        if before < 0:
            return self.period_s
        since = (captured - before) / NS_PER_S
        if kind or not self._reached_ns:
            return since
        return max(self.period_s, since - (self._reached_ns - self._new_at_ns[0]) / NS_PER_S)

    def _too_old(self, kind: int, tick: Tick) -> bool:
        """Whether the newest sample of a kind is too old."""
        held_s = _HELD_S if kind else _HELD_PERIODS * self.period_s
        return self.newest_ns[kind] < 0 or tick.time_ns - self._new_at_ns[kind] > held_s * NS_PER_S

    def _report(self, repeated: bool, tick: Tick) -> None:
        frozen = self._stuck >= self._stuck_limit
        now = (self.codes.tobytes(), frozen.tobytes(), repeated)
        if now == self._reported:
            return
        self._reported = now
        self._troubled = bool(self.codes.any() or frozen.any() or repeated)
        for status, flags in (("lost_sample", (self.codes & LOST) * ~frozen),
                              ("clipped_sample", self.codes & CLIPPED)):
            found = [f"{name} of sensor " + listed(row, self._names)
                     for name, row in zip(KINDS, flags, strict=True) if row.any()]
            if found:
                tick.report(status, "; ".join(found))
        if frozen.any():
            tick.report("frozen_sample",
                        f"sensor {listed(frozen, self._names)}: the same numbers over and over")
        if repeated:
            tick.report("repeated_sample", "no newer sample of the gyroscopes: the last one is held")
        if not self._troubled:
            tick.report("samples_valid", "every sensor gives sound samples again")


_MISSED_SD = math.radians(12.0)
"""Sd of what clipped rates have missed of a rotation, rad, above which it is reported (chosen: more than that
of an angle from sensors that are turned on their segments)."""


class Overrun:
    """Rotation that gyroscopes have missed because it was faster than they can measure.

    Attributes
    ----------
    under_way: whether rates were clipped when last noted; while they are not, faultless samples need no note.

    Parameters
    ----------
    sensors: their number.
    rate_sd: sd of a rate in excess of a clipped one, rad/s.
    names: of the sensors, for messages; empty: their numbers.
    """

    __slots__ = ("_missed", "_names", "_rate_sd", "_reported", "under_way")

    def __init__(self, sensors: int, rate_sd: float, names: Sequence[str] = ()) -> None:
        self._names = names
        self._missed, self._rate_sd = np.zeros(sensors), rate_sd
        self._reported = np.zeros(sensors, dtype=np.bool_)
        self.under_way = False

    def note(self, codes: NDArray[np.uint8], elapsed_s: float, tick: Tick) -> None:
        """Add a tick with the `codes` (3, n) of `Arrivals`; report what was missed at the movement's end."""
        clipped = (codes[0] & CLIPPED) != 0
        if clipped.any():
            # The excess is constant: its sd grows with time, not with its square root.
            self._missed[clipped] += self._rate_sd * elapsed_s
            self.under_way = True
        elif self.under_way:
            self.under_way = False
            new = (self._missed > _MISSED_SD) & ~self._reported
            self._reported |= new
            if new.any():
                tick.report("rates_beyond_range", (
                    f"movement was faster than gyr of sensor {listed(new, self._names)} can measure, and "
                    "angles may be off by "
                    f"{math.degrees(self._missed[new].max()):.0f} deg (sd): let a hand go more slowly, or "
                    "use sensors of a larger range"))
