"""Confidence intervals of what repeated runs give, and tests of paired differences.

An interval that so few values do not give at the confidence asked for is (NaN, NaN).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Interval = tuple[float, float]
NO_INTERVAL: Interval = (math.nan, math.nan)


def mean_interval(values: ArrayLike, confidence: float) -> Interval:
    """Of the mean of a normal distribution, by Student's t, of independent values (n,), n of 2 or more."""
    from scipy.special import stdtrit

    x = np.asarray(values, dtype=np.float64)
    if len(x) < 2 or not np.isfinite(x).all():
        return NO_INTERVAL
    half = float(stdtrit(len(x) - 1, 0.5 + 0.5 * confidence)) * float(x.std(ddof=1)) / math.sqrt(len(x))
    middle = float(x.mean())
    return middle - half, middle + half


def median_interval(values: ArrayLike, confidence: float) -> Interval:
    """Of the median of any continuous distribution: two order statistics of independent values (n,).

    How many values lie below the median is binomial (n, 1/2), so that the interval holds the median at
    least at the rate asked for. For 95 % it takes 6 values. David and Nagaraja, Order Statistics, 3rd ed.,
    2003, section 7.1.
    """
    from scipy.special import bdtr

    x = np.sort(np.asarray(values, dtype=np.float64))
    n, left_out = len(x), 0.5 * (1.0 - confidence)
    cut = int(np.searchsorted(bdtr(np.arange(n), n, 0.5), left_out, side="right"))
    if cut == 0 or not np.isfinite(x).all():
        return NO_INTERVAL
    return float(x[cut - 1]), float(x[n - cut])


def share_interval(values: ArrayLike, confidence: float) -> Interval:
    """Of a share, by Wilson's score (1927, doi 10.1080/01621459.1927.10502953), of values (n,) in [0, 1].

    Values are 0 or 1; or shares themselves, whose variance is at most that of 0 and 1 of the same mean,
    so that the interval is wide rather than narrow.
    """
    from scipy.special import ndtri

    x = np.asarray(values, dtype=np.float64)
    if not len(x):
        return NO_INTERVAL
    n, share = len(x), float(x.mean())
    z = float(ndtri(0.5 + 0.5 * confidence))
    middle = (share + z * z / (2.0 * n)) / (1.0 + z * z / n)
    half = z / (1.0 + z * z / n) * math.sqrt(share * (1.0 - share) / n + z * z / (4.0 * n * n))
    # The ends are 0 and 1 exactly where all values are; rounding must not put them beside that.
    return (0.0 if share == 0.0 else middle - half), (1.0 if share == 1.0 else middle + half)


def share_difference_interval(first: ArrayLike, second: ArrayLike, confidence: float) -> Interval:
    """Of the difference of two shares, first less second, of paired values (n,) in [0, 1].

    Distances of both shares to the ends of their Wilson intervals are added as correlated vectors: method 10
    of Newcombe 1998 (doi 10.1002/(SICI)1097-0258(19981130)17:22<2635::AID-SIM954>3.0.CO;2-C).
    """
    one, other = np.asarray(first, dtype=np.float64), np.asarray(second, dtype=np.float64)
    if not len(one):
        return NO_INTERVAL
    p, q = float(one.mean()), float(other.mean())
    (low_p, high_p), (low_q, high_q) = (share_interval(each, confidence) for each in (one, other))
    correlation = _shared(one, other)
    below = _added(p - low_p, high_q - q, correlation)
    above = _added(high_p - p, q - low_q, correlation)
    return p - q - below, p - q + above


def _shared(one: Array, other: Array) -> float:
    """Correlation of pairs, less a correction for continuity where it is positive."""
    spread = float(one.std() * other.std())
    if spread == 0.0:
        return 0.0
    covariance = float(np.mean(one * other) - one.mean() * other.mean())
    if covariance > 0.0:
        covariance = max(covariance - 0.5 / len(one), 0.0)
    return covariance / spread


def _added(a: float, b: float, correlation: float) -> float:
    return math.sqrt(max(a * a - 2.0 * correlation * a * b + b * b, 0.0))


def sign_test(differences: ArrayLike) -> float:
    """Chance of signs at least as unequal where either is as likely; two-sided, exact, zeros left out.

    For values of 0 and 1 it is McNemar's exact test.
    """
    from scipy.special import bdtr

    signs = np.sign(np.asarray(differences, dtype=np.float64))
    fewer, n = int(min(np.sum(signs > 0), np.sum(signs < 0))), int(np.count_nonzero(signs))
    return min(1.0, 2.0 * float(bdtr(fewer, n, 0.5))) if n else 1.0


def signed_rank_test(differences: ArrayLike) -> float:
    """Wilcoxon's signed-rank test, two-sided, zeros left out; exact for 50 or fewer without ties."""
    from scipy.stats import wilcoxon

    x = np.asarray(differences, dtype=np.float64)
    x = x[x != 0.0]
    if not len(x):
        return 1.0
    exact = len(x) <= 50 and len(np.unique(np.abs(x))) == len(x)
    return float(wilcoxon(x, method="exact" if exact else "approx").pvalue)
