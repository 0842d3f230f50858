"""Confidence intervals and paired tests of independent values.

SciPy computes them except for shares: it has no Wilson interval of values between 0 and 1 (means of runs that
hold or not), and no interval of the difference of paired shares; nor has statsmodels the latter.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Interval = tuple[float, float]
NO_INTERVAL: Interval = (math.nan, math.nan)
_ROUNDING = 1e-9
"""Relative difference below which values differ by rounding only (chosen)."""


def do_not_differ(value: float, sd: float) -> bool:
    """Whether repeated values of this mean and standard deviation differ by rounding at most."""
    return sd <= _ROUNDING * abs(value)


def mean_interval(values: ArrayLike, confidence: float) -> Interval:
    """Student's t interval of the mean of values (n,); none of fewer than two, or of equal ones."""
    from scipy import stats

    x = np.asarray(values, dtype=np.float64)
    if len(x) < 2 or not np.isfinite(x).all() \
            or do_not_differ(float(x.mean()), float(x.std(ddof=1))):
        return NO_INTERVAL
    low, high = stats.t.interval(confidence, len(x) - 1, loc=x.mean(), scale=stats.sem(x))
    return float(low), float(high)


def median_interval(values: ArrayLike, confidence: float) -> Interval:
    """Interval of the median of values (n,), between two of them; none of fewer than six at 95 %.

    The number of values below the median is binomial (n, 1/2), so that the interval covers the median at
    least at the given rate. David and Nagaraja, Order Statistics, 3rd ed., 2003, section 7.1.
    """
    from scipy import stats

    x = np.asarray(values, dtype=np.float64)
    if not len(x) or not np.isfinite(x).all():
        return NO_INTERVAL
    found: Any = stats.quantile_test(x, p=0.5).confidence_interval(confidence)
    low, high = float(found.low), float(found.high)
    return (low, high) if high - low > _ROUNDING * abs(low) else NO_INTERVAL


def share_interval(values: ArrayLike, confidence: float) -> Interval:
    """Wilson's score interval of a share (1927, doi 10.1080/01621459.1927.10502953) of values (n,) in [0, 1].

    Values are 0 or 1; or shares themselves, whose variance is at most that of 0 and 1 of the same mean, so
    that the interval is wide rather than narrow.
    """
    from scipy.special import ndtri

    x = np.asarray(values, dtype=np.float64)
    if not len(x):
        return NO_INTERVAL
    n, share = len(x), float(x.mean())
    z = float(ndtri(0.5 + 0.5 * confidence))
    centre = (share + z * z / (2.0 * n)) / (1.0 + z * z / n)
    half = z / (1.0 + z * z / n) * math.sqrt(share * (1.0 - share) / n + z * z / (4.0 * n * n))
    # The ends are exactly 0 and 1 where all values are, without rounding.
    return (0.0 if share == 0.0 else centre - half), (1.0 if share == 1.0 else centre + half)


def share_difference_interval(first: ArrayLike, second: ArrayLike, confidence: float) -> Interval:
    """Interval of the difference of two shares, first less second, of paired values (n,) in [0, 1].

    Distances of both shares to the ends of their Wilson intervals are added as correlated vectors: method 10
    of Newcombe 1998 (doi 10.1002/(SICI)1097-0258(19981130)17:22<2635::AID-SIM954>3.0.CO;2-C).
    """
    one, other = np.asarray(first, dtype=np.float64), np.asarray(second, dtype=np.float64)
    if not len(one):
        return NO_INTERVAL
    p, q = float(one.mean()), float(other.mean())
    (low_p, high_p), (low_q, high_q) = (share_interval(each, confidence) for each in (one, other))
    correlation = _corrected_correlation(one, other)

    def added(a: float, b: float) -> float:
        return math.sqrt(max(a * a - 2.0 * correlation * a * b + b * b, 0.0))

    return p - q - added(p - low_p, high_q - q), p - q + added(high_p - p, q - low_q)


def _corrected_correlation(one: Array, other: Array) -> float:
    """Correlation of pairs, with a continuity correction where it is positive."""
    spread = float(one.std() * other.std())
    if spread == 0.0:
        return 0.0
    covariance = float(np.mean(one * other) - one.mean() * other.mean())
    if covariance > 0.0:
        covariance = max(covariance - 0.5 / len(one), 0.0)
    return covariance / spread


def sign_test(differences: ArrayLike) -> float:
    """P value of the exact two-sided sign test, zeros left out; for values of 0 and 1, McNemar's."""
    from scipy import stats

    x = np.asarray(differences, dtype=np.float64)
    positive, count = int(np.sum(x > 0)), int(np.count_nonzero(x))
    return float(stats.binomtest(positive, count).pvalue) if count else 1.0


def signed_rank_test(differences: ArrayLike) -> float:
    """P value of Wilcoxon's two-sided signed-rank test, zeros left out; exact for at most 50 without ties."""
    from scipy import stats

    x = np.asarray(differences, dtype=np.float64)
    x = x[x != 0.0]
    if not len(x):
        return 1.0
    exact = len(x) <= 50 and len(np.unique(np.abs(x))) == len(x)
    return float(stats.wilcoxon(x, method="exact" if exact else "approx").pvalue)
