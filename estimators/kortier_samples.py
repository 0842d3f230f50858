"""What a Kortier tracker makes of its samples: which are new, which are to be believed, and how far.

Gyroscope, accelerometer and magnetometer may have rates of their own: a sample is taken once, when its
capture is newer than the last. A sensor without a sound gyroscope sample keeps its last rate with an
uncertainty that says so; after a while what hangs on it is not seen any more.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray

from estimators.samples import CLIPPED, LOST, inspect
from fesloop.loop.block import Tick
from fesloop.loop.clock import NS_PER_S
from fesloop.loop.signals import Sample

Array = NDArray[np.float64]
Elapsed = tuple[float, float, float]
KINDS = ("gyr", "acc", "mag")
_SMOOTHING_S = 0.2
"""Time constant of `Moment.steady`, s (chosen: 20 samples of 100 Hz)."""


class Trust(NamedTuple):
    """How far samples are believed.

    Attributes
    ----------
    gyr_sd, acc_sd, mag_sd: of sound samples, rad/s, m/s^2, T.
    lost_sd, clipped_sd: of a rate whose sample is missing or clipped, rad/s.
    lever_m: distance that turns rotation into acceleration which neighbours do not share.
    error_time_s: how long an error lasts that is none of a sensor's noise.
    """

    gyr_sd: float
    acc_sd: float
    mag_sd: float
    lost_sd: float
    clipped_sd: float
    lever_m: float
    error_time_s: float


class Moment(NamedTuple):
    """Samples of n sensors as the filters take them.

    Attributes
    ----------
    rates: (n, 3), mean over the step; gyr_variance: (n,). newest: (n, 3), last sound sample.
    steady: (n, 3), accelerations smoothed in a frame that does not turn.
    acc, mag: (n, 3); acc_variance, mag_variance: (n,), infinite where the sample is not to be used.
    missing: (n,), s since the last sound sample of the gyroscope; infinite before the first.
    codes: (2, 3, n), LOST and CLIPPED of each kind, now and at the tick before.
    """

    rates: Array
    gyr_variance: Array
    newest: Array
    steady: Array
    acc: Array
    acc_variance: Array
    mag: Array
    mag_variance: Array
    missing: Array
    codes: NDArray[np.uint8]


def no_moment(sensors: int) -> Moment:
    """Before the first sample."""
    return Moment(
        rates=np.zeros((sensors, 3)), gyr_variance=np.full(sensors, np.inf), newest=np.zeros((sensors, 3)),
        steady=np.zeros((sensors, 3)), acc=np.zeros((sensors, 3)), acc_variance=np.full(sensors, np.inf),
        mag=np.zeros((sensors, 3)), mag_variance=np.full(sensors, np.inf),
        missing=np.full(sensors, np.inf), codes=np.zeros((2, 3, sensors), dtype=np.uint8))


class Arrivals:
    """Which samples are new at a tick.

    A sample is new when its capture is later. What has passed a block with the gyroscopes, or was recorded
    beside them, has their stamps even where it was held: it is old when it equals the one before to the
    last bit, while the gyroscopes' does not.

    Attributes
    ----------
    period_s: of the gyroscopes.
    newest_ns: capture of the newest sample of each kind; -1 before the first.
    numbers: of these samples, as bytes.
    repeated: whether the gyroscopes' sample was no new one at the last tick.
    """

    __slots__ = ("newest_ns", "numbers", "period_s", "repeated")

    def __init__(self, period_s: float) -> None:
        self.period_s = period_s
        self.newest_ns = [-1, -1, -1]
        self.numbers = [b"", b"", b""]
        self.repeated = False

    def note(self, samples: Sequence[Sample]) -> Elapsed:
        """Time from the sample before to the one that is new now, of each kind, s; 0 where none is."""
        elapsed = [0.0, 0.0, 0.0]
        turned = False
        for kind, (value, _, captured, _) in enumerate(samples):
            before = self.newest_ns[kind]
            if captured <= before:
                continue
            numbers = np.asarray(value).tobytes()
            changed = numbers != self.numbers[kind]
            if kind == 0:
                turned = changed
            elif turned and not changed and captured == self.newest_ns[0]:
                continue
            elapsed[kind] = self.period_s if before < 0 else (captured - before) / NS_PER_S
            self.newest_ns[kind], self.numbers[kind] = captured, numbers
        return elapsed[0], elapsed[1], elapsed[2]


def report_samples(codes: NDArray[np.uint8], repeated: bool, tick: Tick) -> None:
    """Say what is wrong with the samples, `codes` (3, n), or that nothing is any more."""
    for code, status in ((LOST, "lost_sample"), (CLIPPED, "clipped_sample")):
        found = [f"{name} of sensor " + ", ".join(str(i) for i in np.flatnonzero(row & code))
                 for name, row in zip(KINDS, codes, strict=True) if (row & code).any()]
        if found:
            tick.report(status, "; ".join(found))
    if repeated:
        tick.report("repeated_sample", "no newer sample of the gyroscopes has arrived")
    elif not codes.any():
        tick.report("samples_sound", "every sensor gives sound samples again")


@numba.njit(cache=True)
def inspect_samples(
    gyr: Any, acc: Any, mag: Any, present: Any, limits: Any, magnetometers: Any, codes: Any
) -> bool:
    """Write what is wrong with the samples, (n, 3) each, into `codes` (2, 3, n); whether that has changed.

    Parameters
    ----------
    present: (3,), whether a message of each kind has ever arrived.
    limits: (2,), from which magnitude on rates and accelerations are clipped.
    magnetometers: (n,), those that are read; of others nothing is told.
    """
    codes[1] = codes[0]
    codes[0] = 0
    if present[0]:
        inspect(gyr, limits[0], False, codes[0, 0])
    if present[1]:
        inspect(acc, limits[1], True, codes[0, 1])
    if present[2]:
        inspect(mag, math.inf, True, codes[0, 2])
    changed = False
    for s in range(magnetometers.size):
        if not magnetometers[s]:
            codes[0, 2, s] = 0
        for kind in range(3):
            changed |= codes[0, kind, s] != codes[1, kind, s]
    return changed


@numba.njit(cache=True)
def repeats(error_time_s: float, elapsed_s: float) -> float:
    """How often an error that lasts 2 tau is measured: by this its variance grows, as if measured once."""
    return max(1.0, 2.0 * error_time_s / elapsed_s)


@numba.njit(cache=True)
def take(gyr: Any, acc: Any, mag: Any, elapsed: Any, period: float, trust: Trust, moment: Moment) -> None:
    """Bring a moment up to the samples (n, 3) of this tick.

    Rates are the mean of a sample and the one before it. An accelerometer's variance grows by the
    acceleration that rotation gives at `lever_m`, by rate and by change of rate: the paper judges it by the
    rate alone (eq. 28), which vanishes where a finger turns back.

    Parameters
    ----------
    elapsed: as Arrivals.note gives it.
    period: s, of the gyroscopes; what a step lasts longer is a gap, whose rate is unknown.
    """
    codes, dt = moment.codes[0], elapsed[0]
    for s in range(gyr.shape[0]):
        nothing = gyr[s, 0] == 0.0 and gyr[s, 1] == 0.0 and gyr[s, 2] == 0.0 and codes[1, s] & LOST
        lost = codes[0, s] & LOST or nothing
        speed, change = 0.0, 0.0
        if dt > 0.0:
            for i in range(3):
                if lost:
                    moment.rates[s, i] = moment.newest[s, i]
                    continue
                before = moment.newest[s, i] if moment.missing[s] < math.inf else gyr[s, i]
                moment.rates[s, i] = 0.5 * (before + gyr[s, i])
                change += (gyr[s, i] - before) ** 2 / (dt * dt)
                moment.newest[s, i] = gyr[s, i]
            gap = max(0.0, dt - 1.5 * period) / dt
            clipped = trust.clipped_sd if codes[0, s] & CLIPPED else 0.0
            unsure = trust.lost_sd if lost else gap * trust.lost_sd
            moment.gyr_variance[s] = trust.gyr_sd ** 2 + clipped ** 2 + unsure ** 2
            moment.missing[s] = moment.missing[s] + dt if lost else 0.0
            x, y, z = moment.steady[s, 0], moment.steady[s, 1], moment.steady[s, 2]
            a, b, c = dt * moment.rates[s, 0], dt * moment.rates[s, 1], dt * moment.rates[s, 2]
            moment.steady[s, 0] = x - (b * z - c * y)
            moment.steady[s, 1] = y - (c * x - a * z)
            moment.steady[s, 2] = z - (a * y - b * x)
        for i in range(3):
            speed += moment.newest[s, i] ** 2
        moment.acc_variance[s] = math.inf
        if elapsed[1] > 0.0 and codes[1, s] == 0:
            begun = moment.acc[s, 0] != 0.0 or moment.acc[s, 1] != 0.0 or moment.acc[s, 2] != 0.0
            share = min(1.0, elapsed[1] / _SMOOTHING_S) if begun else 1.0
            for i in range(3):
                moment.acc[s, i] = acc[s, i]
                moment.steady[s, i] += share * (acc[s, i] - moment.steady[s, i])
            unshared = trust.lever_m ** 2 * (speed * speed + change)
            moment.acc_variance[s] = trust.acc_sd ** 2 + repeats(trust.error_time_s, elapsed[1]) * unshared
        moment.mag_variance[s] = math.inf
        if elapsed[2] > 0.0 and codes[2, s] == 0:
            moment.mag[s] = mag[s]
            moment.mag_variance[s] = trust.mag_sd ** 2
