"""Recruitment curves from what a hand does while one channel's pulse width climbs, in stairs or as a ramp.

While one channel alone is stimulated, what is measured (an angle in motion, a force if isometric) is

    y(t) = y0 + g h * v(width(t)),    v = Phi(ln(effective current / threshold) / spread),

h a critically damped second-order lag of gain 1 that stands for everything that is slow between recruitment
and y (muscle, joint, delay). Threshold, spread and time constant are fitted by a trust-region method, with y0
and g eliminated at every step, as they enter linearly (variable projection: Golub and Pereyra 1973, doi
10.1137/0710036). Lag and curve are fitted together, as a ramp shows both at once (after Durfee and MacLean
1989, doi 10.1109/10.32097). Where a record shows the foot of a curve alone, how much of the muscle that is
cannot be known: half of it is then said to be recruited by the strongest pulse, and g is relative to that.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.signal import lfilter
from scipy.special import ndtr

from fesloop.errors import InputError

Array = NDArray[np.float64]
USUAL_SPREAD, USUAL_LAG_S = 0.35, 0.1
"""Where the fit starts, and where it stays if the record says nothing (chosen: spread as of a finger's
muscles; two such lags rise in about .3 s)."""
_PRIOR_WEIGHT = 0.01
"""Weight of a departure by a factor of e from the usual, against all of the motion (chosen: a record that
shows a whole curve is followed, one that shows its foot only is not led astray)."""
_NEAR = 0.01
"""Relative distance to a bound at which a fit counts as being there (chosen): it never quite gets to one."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RecruitmentFit:
    """The curve of one channel.

    Attributes
    ----------
    threshold_ma, spread: as of `fesloop.models.recruitment.Recruitment`.
    lag_s: time constant of each of the two lags.
    rest, gain: (m,), y0 and g, in the units of y.
    fit_percent: 100 (1 - |error| / |y - mean|).
    moved: (m,), peak to peak of y.
    at_bound: of threshold_ma and spread those at an end of what is tried, and which: "or less", "or more".
    """

    threshold_ma: float
    spread: float
    lag_s: float
    rest: Array
    gain: Array
    fit_percent: float
    moved: Array
    at_bound: Mapping[str, str]


def effective_ma(width_s: Array, current_ma: float, chronaxie_us: float) -> Array:
    """Effective current, mA, (n,): 0 where there is no pulse."""
    width_us = 1e6 * width_s
    return np.asarray(current_ma * width_us / (width_us + chronaxie_us))


def fit_recruitment(width_s: Array, current_ma: float, measured: Array, period_s: float, *,
                    chronaxie_us: float = 200.0, least_moved: float = 0.0) -> RecruitmentFit:
    """The curve behind a record of one channel.

    Parameters
    ----------
    width_s: (n,), pulse width at each tick, s, held until the next.
    current_ma: of the channel.
    measured: (n, m), y at the ticks.
    period_s: of the ticks.
    chronaxie_us: taken as known: at a single current it cannot be told from the threshold.
    least_moved: least peak to peak of some output, in its units, that counts as a response.

    Raises InputError where nothing moves, so that there is no curve.
    """
    moved = np.ptp(measured, axis=0)
    if not (moved > least_moved).any():
        raise InputError("recruitment", f"nothing moved by more than {moved.max():.3g}",
                         f"a response above {least_moved:.3g}", "a higher current, or other electrodes")
    effective = effective_ma(width_s, current_ma, chronaxie_us)
    strongest = float(effective.max())
    deviation = measured - measured.mean(axis=0)
    scaled = deviation / max(float(np.sqrt((deviation**2).sum())), 1e-300)

    def course(logs: Array) -> Array:
        threshold, spread, lag = np.exp(logs)
        return lagged(_fractions(effective, threshold, spread), lag, period_s)

    def residual(logs: Array) -> Array:
        departure = logs - np.log([threshold_start, USUAL_SPREAD, USUAL_LAG_S])
        return np.concatenate([_left_over(course(logs), scaled)[0].ravel(), _PRIOR_WEIGHT * departure])

    threshold_start = 0.6 * strongest
    starts = [np.log([share * strongest, spread, USUAL_LAG_S])
              for share, spread in product((0.4, 0.6, 0.9), (0.15, 0.35))]
    start = min(starts, key=lambda logs: float(np.sum(residual(logs) ** 2)))
    lowest = np.log([0.02 * strongest, 0.03, period_s])
    highest = np.log([strongest, 2.0, 3.0])
    found = least_squares(residual, start, bounds=(lowest, highest)).x
    error, coefficients = _left_over(course(found), measured)
    percent = 100.0 * (1.0 - math.sqrt(float((error**2).sum() / (deviation**2).sum())))
    threshold, spread, lag = (float(value) for value in np.exp(found))
    return RecruitmentFit(threshold_ma=threshold, spread=spread, lag_s=lag, rest=coefficients[0],
                          gain=coefficients[1], fit_percent=percent, moved=moved,
                          at_bound=_at_bound(found, lowest, highest))


def _at_bound(found: Array, lowest: Array, highest: Array) -> dict[str, str]:
    ends = {name: "or less" if found[i] - lowest[i] < _NEAR else "or more" if highest[i] - found[i] < _NEAR
            else "" for i, name in enumerate(("threshold_ma", "spread"))}
    return {name: end for name, end in ends.items() if end}


def _fractions(effective: Array, threshold: float, spread: float) -> Array:
    fractions = np.zeros(effective.size)
    on = effective > 0.0
    fractions[on] = ndtr(np.log(effective[on] / threshold) / spread)
    return fractions


def lagged(course: Array, lag_s: float, period_s: float) -> Array:
    """A held input (n,) behind two equal lags of gain 1, at the ticks, from rest: exact (lags in steps
    of a tick, T = period / lag: e^-T (1 + T) and e^-T are what is left of a step after one tick)."""
    ratio = period_s / lag_s
    keep = math.exp(-ratio)
    first = 1.0 - keep * (1.0 + ratio)
    second = keep * (keep - 1.0 + ratio)
    return np.asarray(lfilter([0.0, first, second], [1.0, -2.0 * keep, keep**2], course))


def _left_over(course: Array, measured: Array) -> tuple[Array, Array]:
    """What a line in `course` leaves of each column, and the line: rows intercept, slope."""
    regressors = np.column_stack([np.ones(course.size), course])
    coefficients = np.linalg.lstsq(regressors, measured, rcond=None)[0]
    return measured - regressors @ coefficients, np.asarray(coefficients)
