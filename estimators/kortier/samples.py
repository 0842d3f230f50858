"""Samples of a Kortier tracker and the variances of their errors.

`estimators.arrivals` finds samples that are new, lost or clipped. The rates of a sensor without a sound
gyroscope sample are those of `estimators.gaps`, with their uncertainty; after a while its joints are unseen.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from estimators.arrivals import CLIPPED
from estimators.gaps import Gaps, bridge
from fesloop.compiled import compiled

Array = NDArray[np.float64]
_SMOOTHING_S = 0.2
"""Time constant of `Moment.steady`, s (chosen: 20 samples at 100 Hz)."""

_LONGEST = 1e4
"""Greatest `Moment.steady`, m/s^2 (chosen: 1000 g). Each rotation step lengthens it, without limit at rates
that no hand reaches."""


class Trust(NamedTuple):
    """Assumed errors of samples.

    Attributes
    ----------
    gyr_sd, acc_sd, mag_sd: sds of sound samples, rad/s, m/s^2, T.
    lost_sd: rms rate of a segment while samples are missing, rad/s.
    clipped_sd: sd of a clipped rate, rad/s.
    lever_m: lever arm by which rotation causes acceleration that neighbours do not share.
    error_time_s: correlation time of errors other than sensor noise.
    """

    gyr_sd: float
    acc_sd: float
    mag_sd: float
    lost_sd: float
    clipped_sd: float
    lever_m: float
    error_time_s: float


class Moment(NamedTuple):
    """Samples of n sensors in the form that the filters use.

    Attributes
    ----------
    rates: (n, 3), mean over the step; gyr_variance: (n,), its variance.
    steady: (n, 3), accelerations smoothed in a frame that does not rotate; 0 before the first sample, and
        after a gyroscope has been missing for longer than the smoothing time.
    acc, mag: (n, 3); acc_variance, mag_variance: (n,), infinite where the sample must not be used.
    gaps: rotation through gaps in the rates.
    """

    rates: Array
    gyr_variance: Array
    steady: Array
    acc: Array
    acc_variance: Array
    mag: Array
    mag_variance: Array
    gaps: Gaps


def no_moment(sensors: int) -> Moment:
    """Create the moment before the first sample."""
    return Moment(
        rates=np.zeros((sensors, 3)), gyr_variance=np.full(sensors, np.inf),
        steady=np.zeros((sensors, 3)), acc=np.zeros((sensors, 3)), acc_variance=np.full(sensors, np.inf),
        mag=np.zeros((sensors, 3)), mag_variance=np.full(sensors, np.inf),
        gaps=Gaps.none(sensors))


@compiled
def repeats(error_time_s: float, elapsed_s: float) -> float:
    """Number of measurements within twice the correlation time of an error: factor on its variance."""
    return max(1.0, 2.0 * error_time_s / elapsed_s)


@compiled
def take(
    samples: Any, codes: Any, elapsed: Any, period: float, trust: Trust, moment: Moment
) -> None:
    """Update a moment with the samples of a tick.

    A rate is the mean of a sample and the one before it, or what a gap leaves of both. An accelerometer's
    variance grows by the acceleration that rate and change of rate cause at `lever_m`. The paper uses the
    rate alone (eq. 28), which vanishes where a finger reverses.

    Parameters
    ----------
    samples: (3, n, 3), rad/s, m/s^2, T, and codes: (3, n), as in Arrivals.
    elapsed: as Arrivals.note returns it.
    period: of the gyroscopes, s; a longer step is a gap.
    """
    dt, gaps = elapsed[0], moment.gaps
    acc, mag = samples[1], samples[2]
    if dt > 0.0:
        bridge(samples[0], codes[0], dt, dt, period, trust.lost_sd, gaps)
    for s in range(acc.shape[0]):
        speed, change = 0.0, 0.0
        if dt > 0.0:
            for i in range(3):
                moment.rates[s, i] = gaps.means[s, i]
                change += (2.0 * (gaps.last[s, i] - gaps.means[s, i]) / dt) ** 2
            clipped = trust.clipped_sd if codes[0, s] & CLIPPED else 0.0
            moment.gyr_variance[s] = trust.gyr_sd ** 2 + clipped ** 2 + gaps.spread[s] / dt
            x, y, z = moment.steady[s, 0], moment.steady[s, 1], moment.steady[s, 2]
            a, b, c = dt * moment.rates[s, 0], dt * moment.rates[s, 1], dt * moment.rates[s, 2]
            moment.steady[s, 0] = x - (b * z - c * y)
            moment.steady[s, 1] = y - (c * x - a * z)
            moment.steady[s, 2] = z - (a * y - b * x)
            length = abs(moment.steady[s, 0]) + abs(moment.steady[s, 1]) + abs(moment.steady[s, 2])
            if gaps.silent[s, 0] > _SMOOTHING_S or not length < _LONGEST:
                moment.steady[s] = 0.0  # its rotation is unknown: restart with the next sample
        for i in range(3):
            speed += gaps.last[s, i] ** 2
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
