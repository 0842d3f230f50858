"""Weights of the samples of a Kortier tracker.

Which are new, and what is wrong with them, `estimators.samples.arrivals` tells. A sensor without a sound
gyroscope sample keeps its last rate with an uncertainty that says so; after a while what hangs on it is not
seen any more.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from estimators.samples.arrivals import CLIPPED, LOST
from fesloop.compiled import compiled

Array = NDArray[np.float64]
_SMOOTHING_S = 0.2
"""Time constant of `Moment.steady`, s (chosen: 20 samples of 100 Hz)."""

_LONGEST = 1e4
"""Greatest `Moment.steady`, m/s^2 (chosen: 1000 g). Each step of a turn lengthens it, and rates that no hand
has without end."""


class Trust(NamedTuple):
    """Weights of samples.

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
    steady: (n, 3), accelerations smoothed in a frame that does not turn; 0 before the first, and after a
        gyroscope has been missing for longer than the smoothing lasts.
    acc, mag: (n, 3); acc_variance, mag_variance: (n,), infinite where the sample is not to be used.
    missing: (n,), s since the last sound sample of the gyroscope; infinite before the first.
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


def no_moment(sensors: int) -> Moment:
    """Before the first sample."""
    return Moment(
        rates=np.zeros((sensors, 3)), gyr_variance=np.full(sensors, np.inf), newest=np.zeros((sensors, 3)),
        steady=np.zeros((sensors, 3)), acc=np.zeros((sensors, 3)), acc_variance=np.full(sensors, np.inf),
        mag=np.zeros((sensors, 3)), mag_variance=np.full(sensors, np.inf),
        missing=np.full(sensors, np.inf))


@compiled
def repeats(error_time_s: float, elapsed_s: float) -> float:
    """Number of measurements within the duration 2 tau of an error: factor on its variance."""
    return max(1.0, 2.0 * error_time_s / elapsed_s)


@compiled
def take(
    gyr: Any, acc: Any, mag: Any, codes: Any, elapsed: Any, period: float, trust: Trust, moment: Moment
) -> None:
    """Bring a moment up to the samples (n, 3) of this tick.

    Rates are the mean of a sample and the one before it. An accelerometer's variance grows by the
    acceleration that rotation gives at `lever_m`, by rate and by change of rate: the paper judges it by the
    rate alone (eq. 28), which vanishes where a finger turns back.

    Parameters
    ----------
    codes: (3, n), elapsed: as Arrivals has and gives them.
    period: s, of the gyroscopes; what a step lasts longer is a gap, whose rate is unknown.
    """
    dt = elapsed[0]
    for s in range(gyr.shape[0]):
        lost = codes[0, s] & LOST
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
            length = abs(moment.steady[s, 0]) + abs(moment.steady[s, 1]) + abs(moment.steady[s, 2])
            if moment.missing[s] > _SMOOTHING_S or not length < _LONGEST:
                moment.steady[s] = 0.0  # nobody knows how far it has turned: it begins with the next sample
        for i in range(3):
            speed += moment.newest[s, i] ** 2
        moment.acc_variance[s] = math.inf
        if elapsed[1] > 0.0 and codes[1, s] == 0:
            begun = moment.steady[s, 0] != 0.0 or moment.steady[s, 1] != 0.0 or moment.steady[s, 2] != 0.0
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
