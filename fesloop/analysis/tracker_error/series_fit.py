"""Fits the error process of one angle, as detailed a model as the recording supports.

The part that follows from the motion is fitted first (`MotionColumns`). For the residual, time constants and
shares of the random parts maximise the likelihood; the Bayesian information criterion (doi
10.1214/aos/1176344136) chooses the parts. Finally all random parts are scaled by one factor, so that the
process has the measured mean square. A record is too short to estimate a time constant above a fifth of it,
which `too_slow` reports.

The likelihood is a Kalman filter of three states, compiled. statsmodels' state space gives the same to 1e-15
and takes 120 times as long (30 ms for 1800 samples), which would make minutes of a fit's seconds.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import Bounds, minimize

from fesloop.analysis.tracker_error.error_record import ErrorRecord, independent_values
from fesloop.compiled import compiled
from fesloop.errors import InputError
from fesloop.loop.noise import stream_key
from fesloop.models.error_process import ErrorSeries
from fesloop.models.error_steps import DRAWS, ensemble, random_variance, smooth_steps

Array = NDArray[np.float64]


class Likelihood(NamedTuple):
    """Likelihood of an error at its most likely scale.

    Attributes
    ----------
    log: natural logarithm.
    scale: stationary variance of the fast part.
    innovations: (n,), standardised; NaN where the error is unknown.
    """

    log: float
    scale: float
    innovations: Array


def likelihood(
    error: Array, times_s: Array, speeds: Array, every: int = 1, *, slow: float, slow_s: float, smooth: bool,
    fast_s: float, white: float, speed_s: float
) -> Likelihood:
    """Likelihood of an error (n,), NaN where it is unknown, under a process of unknown scale.

    Parameters
    ----------
    times_s: (n,). speeds: (n,), rad/s.
    every: stride of compared samples; the result is the mean over all phases.
    slow, white: variance of the slow and the white part over the stationary variance of the fast part.
    slow_s, fast_s: time constants. smooth, speed_s: as in `ErrorSeries`.
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
    """Transition (2, 2) and driving covariance (2, 2) of the slow part, of variance `slow`, and its
    derivative.

    Entries of the derivative are zero where the slow part is not smooth.
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
    """Fill `innovations` (n,), standardised at scale 1; the sum of the logarithms of their variances.

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


Columns = tuple[int, ...]
_MOST = 3
_A_COLUMN = 10.0
"""Least number of independent angles per column (chosen)."""
_STILL = math.radians(1.0)
"""Least RMS of an angle from which an error can follow (chosen: the size of errors)."""
_BLOCKS = 4


class MotionColumns:
    """Regressors of an error on the motion.

    Attributes
    ----------
    values: (n, 4), a constant, the angle, its square, its rate; rad and s.
    """

    def __init__(self, record: ErrorRecord) -> None:
        self._error, self._known = record.error, record.known
        angle = record.angle
        self.values = np.stack([np.ones_like(angle), angle, angle * angle, record.rate], axis=1)

    def choices(self) -> Sequence[Columns]:
        """Sets of columns that the record is long enough for, each with the constant."""
        angle = self.values[:, 1]
        moving = float(np.std(angle[self._known])) > _STILL
        most = min(_MOST, int(independent_values(angle, self._known) / _A_COLUMN)) if moving else 0
        return [(0, *some) for size in range(most + 1) for some in combinations((1, 2, 3), size)]

    def best(self) -> Columns:
        """The set of columns with the least prediction error."""
        return min(self.choices(), key=self.prediction_error)

    def prediction_error(self, columns: Columns) -> float:
        """Mean square error of cross-validation: each quarter of the record by weights of the other three."""
        rows, total = np.flatnonzero(self._known), 0.0
        for quarter in np.array_split(rows, _BLOCKS):
            _, residual = self.least_squares(columns, np.setdiff1d(rows, quarter))
            total += float(np.sum(np.square(residual[quarter])))
        return total / rows.size

    def least_squares(self, columns: Columns, rows: NDArray[np.int64]) -> tuple[Array, Array]:
        """Weights (4,) from some of the rows, zero for other columns, and the residual error (n,)."""
        chosen = list(columns)
        weights = np.zeros(4)
        weights[chosen], *_ = np.linalg.lstsq(self.values[rows][:, chosen], self._error[rows], rcond=None)
        return weights, self._error - self.values @ weights


FEWEST = 100
"""Least number of known errors (chosen: a dozen per parameter)."""
_LONGEST_FAST = 20.0
"""The fast time constant lies between one sampling period and the record's length divided by this, the slow
one between two sampling periods and the record's length. Without a slow part, the fast one has its limit."""
_LEAST_TIMES = 5.0
"""Least ratio of the record's length to a time constant (chosen: two or three independent values)."""
_PERIOD_S = 0.1
"""Time between compared errors, rather than a sample: a process with few parameters cannot be right at every
scale, and stimulated muscles do not follow faster errors (chosen: rise time of a twitch)."""
_RUNS = 300
"""Runs of the process that give the uncertainty of its weights (chosen: their sd within 4 %)."""
_ODDS = (math.log(1e-4), math.log(1e4))
_SPEEDS_S = (math.log(1e-3), math.log(1e2))


@dataclass(frozen=True, slots=True)
class Noise:
    """The random parts of a model besides the fast and the white one.

    Attributes
    ----------
    slow: whether there is a slow part. smooth: whether this has a derivative. shaken: whether motion drives
        the fast part.
    """

    slow: bool
    shaken: bool
    smooth: bool = False

    @property
    def free(self) -> tuple[int, ...]:
        """Indices of free parameters in log (slow variance, slow_s, fast_s, white variance, speed_s)."""
        return tuple(i for i in range(5) if (i not in (0, 1) or self.slow) and (i != 4 or self.shaken))


NOISES = tuple(Noise(slow, shaken, smooth) for slow, smooth in ((False, False), (True, False), (True, True))
               for shaken in (False, True))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SeriesFit:
    """The fitted process of one angle.

    Attributes
    ----------
    series: the process.
    innovations: (n,), standardised; NaN where the error is unknown.
    criterion: Bayesian information criterion of the chosen model.
    weight_spread: (4, 4), covariance of the estimates of bias, slope, curve and lead from a record of this
        length, in rad and s.
    too_slow: whether the record is too short to estimate the longest time constant.
    """

    series: ErrorSeries
    innovations: Array
    criterion: float
    weight_spread: Array
    too_slow: bool


@dataclass(frozen=True, slots=True, eq=False)
class _Candidate:
    """Random parts at their greatest likelihood; `point` has the parameters that `Noise.free` counts."""

    noise: Noise
    point: Array
    found: Likelihood
    criterion: float


def fit_series(record: ErrorRecord) -> SeriesFit:
    """Fit the process of one angle's error.

    Raises InputError where fewer than `FEWEST` errors are known, or all are equal.
    """
    known = int(record.known.sum())
    if known < FEWEST:
        raise InputError(record.name, f"{known} errors are known", f"{FEWEST} or more to fit a process")
    if not np.ptp(record.error[record.known]) > 0.0:
        raise InputError(record.name, "the error never changes", "an error that does",
                         "a bias is all there is: take a tracker of kind ideal")
    problem = _Problem(record)
    first = problem.fitted(Noise(slow=True, shaken=False))
    every = [problem.fitted(noise, first) for noise in NOISES]
    return problem.scaled(min(every, key=lambda candidate: candidate.criterion))


class _Problem:
    """A record less the part that follows from its motion, and the bounds of the parameters."""

    def __init__(self, record: ErrorRecord) -> None:
        self.record, self.known, self.steps_s = record, record.known, record.steps_s
        known = self.known
        length = float(record.times_s[known][-1] - record.times_s[known][0])
        self.thinning = max(1, round(_PERIOD_S / float(np.median(self.steps_s[:-1]))))
        usual = self.thinning * float(np.median(self.steps_s[:-1]))
        longest_fast = max(length / _LONGEST_FAST, 4.0 * usual)
        self.bounds = np.array([_ODDS, (math.log(2.0 * usual), math.log(length)),
                                (math.log(usual), math.log(longest_fast)), _ODDS, _SPEEDS_S])
        agility = max(float(np.std(record.rate[known])), 1e-2)
        start = (0.0, math.log(length / 8.0), math.log(4.0 * usual), math.log(0.1), -math.log(agility))
        self.start = np.clip(start, *self.bounds.T)
        self.speeds = np.abs(record.rate)
        self.motion = MotionColumns(record)
        self.columns = self.motion.best()
        self.weights, self.residual = self.motion.least_squares(self.columns, np.flatnonzero(known))

    def fitted(self, noise: Noise, before: _Candidate | None = None) -> _Candidate:
        """Maximise the likelihood of the parts; the search starts at the result `before`, and elsewhere."""
        free = list(noise.free)
        bounds = self.bounds.copy()
        if not noise.slow:
            bounds[2, 1] = bounds[1, 1]
        point = (self.start if before is None else before.point).copy()

        def negative_log(part: Array) -> float:
            point[free] = part
            return -self._likelihood(noise, point).log

        starts = [point[free].copy()]
        if before is not None and before.noise != noise:
            starts.append(self.start[free])
        limits = Bounds(*bounds[free].T)
        found = min((minimize(negative_log, each, method="L-BFGS-B", bounds=limits,
                              options={"maxiter": 60, "ftol": 1e-8}) for each in starts),
                    key=lambda one: float(one.fun))
        point[free] = found.x
        count = len(self.columns) + len(free) + 1
        criterion = count * math.log(self.known.sum() / self.thinning) + 2.0 * float(found.fun)
        return _Candidate(noise, point, self._likelihood(noise, point), criterion)

    def _likelihood(self, noise: Noise, point: Array) -> Likelihood:
        slow, slow_s, fast_s, white, speed_s = np.exp(point).tolist()
        return likelihood(
            self.residual, self.record.times_s, self.speeds, self.thinning, slow=slow if noise.slow else 0.0,
            slow_s=slow_s, smooth=noise.smooth, fast_s=fast_s, white=white,
            speed_s=speed_s if noise.shaken else 0.0)

    def scaled(self, best: _Candidate) -> SeriesFit:
        """The process, with its random parts scaled to the mean square of the residual."""
        record, known, noise = self.record, self.known, best.noise
        slow, slow_s, fast_s, white, speed_s = np.exp(best.point).tolist()
        bias, slope, curve, lead = self.weights.tolist()
        sd_deg = math.degrees(math.sqrt(best.found.scale))
        angle, rate = np.degrees(record.angle[known]), np.degrees(record.rate[known])
        series = ErrorSeries(
            name=record.name, moved=record.moved, bias_deg=math.degrees(bias), slope=slope,
            curve_deg=math.degrees(curve), lead_s=lead, smooth=noise.smooth,
            slow_deg=sd_deg * math.sqrt(slow) if noise.slow else 0.0, slow_s=slow_s if noise.slow else 0.0,
            fast_deg=sd_deg, fast_s=fast_s, quick_deg=sd_deg * math.sqrt(white),
            speed_s=speed_s if noise.shaken else 0.0,
            angle_deg=(min(0.0, float(angle.min())), max(0.0, float(angle.max()))),
            rate_deg_s=float(np.abs(rate).max()))
        modelled = random_variance(series.row(), record.rate, self.steps_s)[known]
        factor = math.sqrt(float(np.mean(self.residual[known] ** 2) / np.mean(modelled)))
        series = replace(series, **{name: factor * getattr(series, name)
                                    for name in ("slow_deg", "fast_deg", "quick_deg")})
        too_slow = (slow_s if noise.slow else fast_s) > math.exp(self.bounds[1, 1]) / _LEAST_TIMES
        return SeriesFit(
            series=replace(series, quick_s=quick_time_s(series, self.residual, record.rate, self.steps_s)),
            innovations=best.found.innovations, criterion=best.criterion, too_slow=too_slow,
            weight_spread=self._spread_of_weights(series))

    def _spread_of_weights(self, series: ErrorSeries) -> Array:
        """Covariance (4, 4) of the weights over records like this one, from runs of the process."""
        record, chosen = self.record, list(self.columns)
        noise = np.random.Generator(np.random.Philox(key=stream_key(0, f"weights/{series.name}", 0)))
        row = replace(series, bias_deg=0.0, slope=0.0, curve_deg=0.0, lead_s=0.0).row()
        runs = ensemble(row, record.angle, record.rate, self.steps_s,
                        noise.standard_normal((_RUNS, DRAWS, record.times_s.size)))
        found, *_ = np.linalg.lstsq(self.motion.values[self.known][:, chosen], runs[:, self.known].T,
                                   rcond=None)
        covariance = np.zeros((4, 4))
        covariance[np.ix_(chosen, chosen)] = np.atleast_2d(np.cov(found))
        return covariance


def quick_time_s(series: ErrorSeries, residual: Array, rates: Array, steps_s: Array) -> float:
    """Time constant of the quick part, from the change of the error (n,) from sample to sample.

    The change of the other parts is subtracted; 0 where the rest is that of independent samples.
    """
    step_s = float(np.median(steps_s[:-1]))
    changes = 0.5 * float(np.nanmean(np.square(np.diff(residual))))
    quiet = replace(series, quick_deg=0.0)
    steps = np.full(rates.size, step_s)
    slow = math.radians(series.slow_deg) ** 2
    fast = float(np.mean(random_variance(quiet.row(), rates, steps))) - slow
    if series.slow_deg:
        x = step_s / series.slow_s
        slow *= 1.0 - math.exp(-x) * (1.0 + x if series.smooth else 1.0)
    quick = math.radians(series.quick_deg) ** 2
    share = (changes - slow - fast * -math.expm1(-step_s / series.fast_s)) / quick if quick > 0.0 else 1.0
    if share >= 1.0:
        return 0.0
    longest = _PERIOD_S / 3.0
    return min(-step_s / math.log1p(-share), longest) if share > 0.0 else longest
