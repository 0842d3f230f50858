"""Likelihood of an error process with gaps, by the Kalman filter.

The random part is the sum of a slow and a fast process (`fesloop.models.error_process`) and of white noise.
Instants without a reference are predicted across (Harvey 1989, Forecasting, Structural Time Series Models and
the Kalman Filter, section 3.4.7).
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.compiled import compiled
from fesloop.models.error_steps import smooth_steps

Array = NDArray[np.float64]


class Likelihood(NamedTuple):
    """How likely an error is, at the scale at which it is likeliest.

    Attributes
    ----------
    log: natural logarithm.
    scale: variance of the fast part at rest.
    innovations: (n,), what could not be foreseen, in units of its own sd; NaN where it is unknown.
    """

    log: float
    scale: float
    innovations: Array


def likelihood(
    error: Array, times_s: Array, speeds: Array, every: int = 1, *, slow: float, slow_s: float, smooth: bool,
    fast_s: float, white: float, speed_s: float
) -> Likelihood:
    """Of an error (n,), NaN where it is unknown, under a process that is given but for its scale.

    Parameters
    ----------
    times_s: (n,). speeds: (n,), rad/s.
    every: samples are compared with those of so many before: the mean over all that can be the first.
    slow, white: variance of the slow and the white part over that of the fast part at rest.
    slow_s, fast_s: time constants. smooth, speed_s: as of `ErrorSeries`.
    """
    innovations = np.empty_like(error)
    phases = [slice(first, None, every) for first in range(every)]
    spread = sum(whiten(error[rows], times_s[rows], speeds[rows], slow, slow_s, smooth, fast_s, white,
                        speed_s, innovations[rows]) for rows in phases)
    squares = np.square(innovations)
    count = int(np.isfinite(squares).sum())
    scale = max(float(np.nansum(squares)) / count, np.finfo(float).tiny)
    log = -0.5 * (count * (math.log(2.0 * math.pi * scale) + 1.0) + spread) / every
    return Likelihood(log, scale, innovations / math.sqrt(scale))


@compiled
def slow_steps(slow: float, slow_s: float, smooth: bool, elapsed_s: float) -> Any:
    """How the slow part, of variance `slow`, and its derivative go on.

    Transition (2, 2), and covariance (2, 2) of what drives them; zero of the derivative where there is none.
    """
    driven = np.zeros((2, 2))
    if not smooth:
        steps = np.zeros((2, 2))
        steps[0, 0] = math.exp(-elapsed_s / slow_s)
        driven[0, 0] = slow * (1.0 - steps[0, 0] ** 2)
        return steps, driven
    steps, root = smooth_steps(slow_s, elapsed_s)
    for i in range(2):
        for j in range(2):
            driven[i, j] = slow * (root[i, 0] * root[j, 0] + root[i, 1] * root[j, 1])
    return steps, driven


@compiled
def whiten(
    errors: Any, times_s: Any, speeds: Any, slow: float, slow_s: float, smooth: bool,
    fast_s: float, white: float, speed_s: float, innovations: Any
) -> Any:
    """Fill `innovations` (n,), in units of their sd at scale 1; the sum of the logarithms of their variances.

    Parameters are those of `likelihood`.
    """
    # The state is (slow part, its derivative, fast part); p02 is the covariance of the first and the third.
    s0, s1, s2 = 0.0, 0.0, 0.0
    p00, p01, p02, p12 = slow, 0.0, 0.0, 0.0
    p11, p22 = slow / (slow_s * slow_s) if smooth else 0.0, 1.0 + (speed_s * speeds[0]) ** 2
    a, q = slow_steps(slow, slow_s, smooth, 0.0)
    total, elapsed, b = 0.0, 0.0, 1.0
    for k in range(errors.size):
        if k:
            # Even spacing but for the last bits needs no new exponentials.
            step = times_s[k] - times_s[k - 1]
            if abs(step - elapsed) > 1e-6 * elapsed:
                elapsed = step
                a, q = slow_steps(slow, slow_s, smooth, elapsed)
                b = math.exp(-elapsed / fast_s)
            p00, p01, p11 = (
                a[0, 0] ** 2 * p00 + 2.0 * a[0, 0] * a[0, 1] * p01 + a[0, 1] ** 2 * p11 + q[0, 0],
                a[0, 0] * a[1, 0] * p00 + (a[0, 0] * a[1, 1] + a[0, 1] * a[1, 0]) * p01
                + a[0, 1] * a[1, 1] * p11 + q[0, 1],
                a[1, 0] ** 2 * p00 + 2.0 * a[1, 0] * a[1, 1] * p01 + a[1, 1] ** 2 * p11 + q[1, 1])
            p02, p12 = b * (a[0, 0] * p02 + a[0, 1] * p12), b * (a[1, 0] * p02 + a[1, 1] * p12)
            p22 = b * b * p22 + (1.0 - b * b) * (1.0 + (speed_s * speeds[k]) ** 2)
            s0, s1, s2 = a[0, 0] * s0 + a[0, 1] * s1, a[1, 0] * s0 + a[1, 1] * s1, b * s2
        if not math.isfinite(errors[k]):
            innovations[k] = np.nan
            continue
        r0, r1, r2 = p00 + p02, p01 + p12, p02 + p22
        spread = r0 + r2 + white
        innovation = errors[k] - s0 - s2
        innovations[k] = innovation / math.sqrt(spread)
        s0, s1, s2 = (s0 + r0 / spread * innovation, s1 + r1 / spread * innovation,
                      s2 + r2 / spread * innovation)
        p00, p01, p11 = p00 - r0 * r0 / spread, p01 - r0 * r1 / spread, p11 - r1 * r1 / spread
        p02, p12, p22 = p02 - r0 * r2 / spread, p12 - r1 * r2 / spread, p22 - r2 * r2 / spread
        total += math.log(spread)
    return total
