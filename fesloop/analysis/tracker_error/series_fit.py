"""Fits the error process of one angle, as detailed a model as the recording supports.

The part that follows from the motion is fitted first (`MotionColumns`). For the residual, time constants,
frequency and shares of the random parts maximise the likelihood among the processes that have the mean square
of the residual; the Bayesian information criterion (doi 10.1214/aos/1176344136) chooses the parts. A record
is too short to estimate a time constant above a fifth of it, which `too_slow` reports.

The likelihood is a Kalman filter of five states, compiled. With three of them, statsmodels' state space gave
the same to 1e-15 and took 120 times as long, which would make minutes of a fit's seconds.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, product
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import Bounds, minimize

from fesloop.analysis.tracker_error.error_record import ErrorRecord, independent_values
from fesloop.compiled import compiled
from fesloop.errors import InputError
from fesloop.loop.noise import stream_key
from fesloop.models.error_process import ErrorSeries
from fesloop.models.error_steps import DRAWS, RISE, ensemble, random_variance, settled, smooth_steps

Array = NDArray[np.float64]


class Parts(NamedTuple):
    """Random parts of a process: variances over the stationary variance of the fast part, and times.

    Attributes
    ----------
    slow, quick, white: variances of the slow part, of the one that oscillates and of the independent one.
    slow_s, fast_s, quick_s: time constants. quick_rate: frequency, rad/s.
    rise_s: other time constant of the slow part; 0 where it is not smooth. speed_s: as in `ErrorSeries`.
    """

    slow: float
    slow_s: float
    rise_s: float
    fast_s: float
    quick: float
    quick_s: float
    quick_rate: float
    white: float
    speed_s: float


class Piece(NamedTuple):
    """Error (n,) of one record, NaN where it is unknown, at times (n,), s, with speeds (n,), rad/s.

    `every` is the stride of compared samples; a likelihood is the mean over all phases.
    """

    error: Array
    times_s: Array
    speeds: Array
    every: int = 1

    @property
    def phases(self) -> list[slice]:
        """Rows of each phase."""
        return [slice(first, None, self.every) for first in range(self.every)]


class Likelihood(NamedTuple):
    """Likelihood of errors.

    Attributes
    ----------
    log: natural logarithm.
    scale: stationary variance of the fast part at rest.
    innovations: (n,) of each record, standardised; NaN where the error is unknown.
    """

    log: float
    scale: float
    innovations: tuple[Array, ...]


def likelihood(pieces: Sequence[Piece], parts: Parts, scale: float | None = None) -> Likelihood:
    """Likelihood of errors under a process of a given or, where that is None, of the most likely scale."""
    innovations, spread, total, count = [], 0.0, 0.0, 0.0
    for piece in pieces:
        found = np.empty_like(piece.error)
        spread += sum(whiten(piece.error[rows], piece.times_s[rows], piece.speeds[rows], parts, found[rows])
                      for rows in piece.phases) / piece.every
        total += float(np.nansum(np.square(found))) / piece.every
        count += int(np.isfinite(found).sum()) / piece.every
        innovations.append(found)
    if scale is None:
        scale = max(total / count, np.finfo(float).tiny)
    log = -0.5 * (count * math.log(2.0 * math.pi * scale) + total / scale + spread)
    return Likelihood(log, scale, tuple(found / math.sqrt(scale) for found in innovations))


@compiled
def slow_steps(parts: Any, elapsed_s: float) -> Any:
    """Transition (2, 2) and driving covariance (2, 2) of the slow part and its derivative.

    Entries of the derivative are zero where the slow part is not smooth.
    """
    driven = np.zeros((2, 2))
    if parts.rise_s == 0.0:
        steps = np.zeros((2, 2))
        steps[0, 0] = math.exp(-elapsed_s / parts.slow_s)
        driven[0, 0] = parts.slow * (1.0 - steps[0, 0] ** 2)
        return steps, driven
    steps, root = smooth_steps(parts.slow_s, parts.rise_s, elapsed_s)
    for i in range(2):
        for j in range(2):
            driven[i, j] = parts.slow * (root[i, 0] * root[j, 0] + root[i, 1] * root[j, 1])
    return steps, driven


@compiled
def whiten(errors: Any, times_s: Any, speeds: Any, parts: Any, innovations: Any) -> Any:
    """Fill `innovations` (n,), standardised at scale 1; the sum of the logarithms of their variances."""
    # The state is slow part and derivative, fast part, quick part and quadrature; p is its covariance.
    state, p = np.zeros(5), np.zeros((5, 5))
    drive = 1.0 + (parts.speed_s * speeds[0]) ** 2
    p[0, 0], p[2, 2] = parts.slow, drive
    p[1, 1] = parts.slow / (parts.slow_s * parts.rise_s) if parts.rise_s > 0.0 else 0.0
    p[3, 3] = p[4, 4] = parts.quick * drive
    a, driven = slow_steps(parts, 0.0)
    total, elapsed, fast, quick, cosine, sine = 0.0, 0.0, 1.0, 1.0, 1.0, 0.0
    for k in range(errors.size):
        if k:
            # Even spacing but for the last bits needs no new exponentials.
            step = times_s[k] - times_s[k - 1]
            if abs(step - elapsed) > 1e-6 * elapsed:
                elapsed = step
                a, driven = slow_steps(parts, elapsed)
                fast, quick = math.exp(-elapsed / parts.fast_s), math.exp(-elapsed / parts.quick_s)
                cosine = quick * math.cos(parts.quick_rate * elapsed)
                sine = quick * math.sin(parts.quick_rate * elapsed)
            for j in range(5):
                move_on_state(p[:, j], a, fast, cosine, sine)
            for i in range(5):
                move_on_state(p[i], a, fast, cosine, sine)
            move_on_state(state, a, fast, cosine, sine)
            drive = 1.0 + (parts.speed_s * speeds[k]) ** 2
            p[0, 0] += driven[0, 0]
            p[0, 1] += driven[0, 1]
            p[1, 0] += driven[1, 0]
            p[1, 1] += driven[1, 1]
            p[2, 2] += (1.0 - fast * fast) * drive
            p[3, 3] += (1.0 - quick * quick) * drive * parts.quick
            p[4, 4] += (1.0 - quick * quick) * drive * parts.quick
        if not math.isfinite(errors[k]):
            innovations[k] = np.nan
            continue
        gain = p[:, 0] + p[:, 2] + p[:, 3]
        spread = gain[0] + gain[2] + gain[3] + parts.white
        innovation = errors[k] - state[0] - state[2] - state[3]
        innovations[k] = innovation / math.sqrt(spread)
        for i in range(5):
            state[i] += gain[i] / spread * innovation
            for j in range(5):
                p[i, j] -= gain[i] * gain[j] / spread
        total += math.log(spread)
    return total


@compiled
def move_on_state(x: Any, a: Any, fast: float, cosine: float, sine: float) -> None:
    """Multiply a vector (5,) by the transition of the state of `whiten`."""
    x[0], x[1] = a[0, 0] * x[0] + a[0, 1] * x[1], a[1, 0] * x[0] + a[1, 1] * x[1]
    x[2] *= fast
    x[3], x[4] = cosine * x[3] + sine * x[4], cosine * x[4] - sine * x[3]


@compiled
def summed_variance(errors: Any, times_s: Any, speeds: Any, parts: Any) -> Any:
    """Sum of the variances of a process of scale 1 at the instants at which an error (n,) is known."""
    total, fast, quick = 0.0, 0.0, 0.0
    for k in range(errors.size):
        elapsed_s = times_s[k] - times_s[k - 1] if k else math.inf
        drive = 1.0 + (parts.speed_s * speeds[k]) ** 2
        fast = settled(fast, drive, parts.fast_s, elapsed_s)
        quick = settled(quick, parts.quick * drive, parts.quick_s, elapsed_s)
        if math.isfinite(errors[k]):
            total += parts.slow + fast + quick + parts.white
    return total


Columns = tuple[int, ...]
_MOST = 3
_A_COLUMN = 10.0
"""Least number of independent angles per column (chosen)."""
_STILL = math.radians(1.0)
"""Least RMS of an angle from which an error can follow (chosen: the size of errors)."""
_BLOCKS = 4


class MotionColumns:
    """Regressors of an error on the motion in one or more recordings, each with a constant of its own.

    Attributes
    ----------
    values: (n, 4), a constant, the angle, its square, its rate; rad and s; records one after the other.
    """

    def __init__(self, *records: ErrorRecord) -> None:
        self._error = np.concatenate([record.error for record in records])
        self._known = np.concatenate([record.known for record in records])
        angle = np.concatenate([record.angle for record in records])
        rate = np.concatenate([record.rate for record in records])
        self.values = np.stack([np.ones_like(angle), angle, angle * angle, rate], axis=1)
        number = np.repeat(np.arange(len(records)), [record.times_s.size for record in records])
        self._constants = np.equal.outer(number, np.arange(len(records))).astype(np.float64)
        self._ends = np.cumsum([record.times_s.size for record in records])[:-1]

    def choices(self) -> Sequence[Columns]:
        """Sets of columns that the records are long enough for, each with the constant."""
        angles, known = np.split(self.values[:, 1], self._ends), np.split(self._known, self._ends)
        moving = float(np.std(self.values[self._known, 1])) > _STILL
        count = sum(independent_values(*each) for each in zip(angles, known, strict=True)) if moving else 0.0
        most = min(_MOST, int(count / _A_COLUMN))
        return [(0, *some) for size in range(most + 1) for some in combinations((1, 2, 3), size)]

    def best(self) -> Columns:
        """The set of columns with the least prediction error."""
        return min(self.choices(), key=self.prediction_error)

    def prediction_error(self, columns: Columns) -> float:
        """Mean square error of cross-validation: each quarter of each record by weights of the others."""
        rows, total = np.flatnonzero(self._known), 0.0
        of_records = np.split(rows, np.searchsorted(rows, self._ends))
        quarters = zip(*(np.array_split(some, _BLOCKS) for some in of_records), strict=True)
        for quarter in map(np.concatenate, quarters):
            _, residual = self.least_squares(columns, np.setdiff1d(rows, quarter))
            total += float(np.sum(np.square(residual[quarter])))
        return total / rows.size

    def matrix(self, columns: Columns) -> Array:
        """Columns of the records' constants and of the motion, (n, records + columns - 1)."""
        return np.hstack([self._constants, self.values[:, list(columns[1:])]])

    def least_squares(self, columns: Columns, rows: NDArray[np.int64]) -> tuple[Array, Array]:
        """Weights from some of the rows, and the residual error (n,).

        Weights are the constants of the records, then those of angle, its square and its rate, zero for
        columns that are not chosen: (records + 3,).
        """
        matrix, count = self.matrix(columns), self._constants.shape[1]
        found, *_ = np.linalg.lstsq(matrix[rows], self._error[rows], rcond=None)
        weights = np.zeros(count + 3)
        weights[:count] = found[:count]
        weights[[count - 1 + column for column in columns[1:]]] = found[count:]
        return weights, self._error - matrix @ found


FEWEST = 100
"""Least number of known errors (chosen: a dozen per parameter)."""
_LONGEST_FAST = 20.0
"""The fast time constant lies between one sampling period and the record's length divided by this, the slow
one between two sampling periods and the record's length. Without a slow part, the fast one has its limit."""
_LEAST_TIMES = 5.0
"""Least ratio of the record's length to a time constant (chosen: two or three independent values)."""
_PERIOD_S = 1.0 / 30.0
"""Time between compared errors, rather than a sample: the period of usual cameras (chosen). A process with
few parameters cannot be right at every scale, and no controller of muscles reacts to faster errors."""
_SHORT_S = 0.1
"""Least time constant of the slow part, and greatest one of a quick part that does not oscillate."""
_RUNS = 300
"""Runs of the process that give the uncertainty of its weights (chosen: their sd within 4 %)."""
_ODDS = (math.log(1e-4), math.log(1e4))
_SPEEDS_S = (math.log(1e-3), math.log(1e2))
_LEAST_HZ = 1.0
"""Least frequency of an oscillation (chosen: slower ones are the motion's)."""
_LONGEST_QUICK_S = 1.0
"""Greatest time constant of an oscillation (chosen)."""
_GRID, _FREQUENCIES = 4, 6
"""Time constants of each part, and frequencies, from the likeliest of which the search begins."""
SLOW, SLOW_TIME, RISE_TIME, FAST_TIME, QUICK, QUICK_TIME, FREQUENCY, SPEED = range(8)
"""Indices of the parameters, as logarithms: variance and time constants of the slow part, time constant of
the fast one, variance, time constant and frequency of the quick one, and `speed_s`."""


@dataclass(frozen=True, slots=True)
class Noise:
    """The random parts of a model besides the fast and the quick one.

    Attributes
    ----------
    slow: whether there is a slow part. smooth: whether this has a derivative. shaken: whether motion drives
        the fast part, and a quick part that oscillates. swinging: whether the quick part oscillates.
    """

    slow: bool
    smooth: bool = False
    shaken: bool = False
    swinging: bool = False

    @property
    def free(self) -> tuple[int, ...]:
        """Indices of free parameters."""
        absent = {*(() if self.slow else (SLOW, SLOW_TIME)), *(() if self.smooth else (RISE_TIME,)),
                  *(() if self.shaken else (SPEED,)), *(() if self.swinging else (QUICK_TIME, FREQUENCY))}
        return tuple(i for i in range(8) if i not in absent)

    def parts(self, point: Array) -> Parts:
        """The parts at a point, (8,)."""
        slow, slow_s, rise_s, fast_s, quick, quick_s, hz, speed_s = np.exp(point).tolist()
        slow_s, rise_s = (max(slow_s, rise_s), min(slow_s, rise_s)) if self.smooth else (slow_s, 0.0)
        return Parts(
            slow=slow if self.slow else 0.0, slow_s=slow_s, rise_s=rise_s, fast_s=fast_s,
            quick=quick if self.swinging else 0.0, quick_s=quick_s, quick_rate=2.0 * math.pi * hz,
            white=0.0 if self.swinging else quick, speed_s=speed_s if self.shaken else 0.0)


NOISES = tuple(Noise(slow=slow, smooth=smooth, swinging=swinging)
               for swinging in (False, True)
               for slow, smooth in ((False, False), (True, False), (True, True)))
"""Compared models; whether motion drives the best one is decided afterwards."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SeriesFit:
    """The fitted process of one angle.

    Attributes
    ----------
    series: the process.
    innovations: (n,), standardised; NaN where the error is unknown; records one after the other.
    biases_deg: constant part of each record.
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
    biases_deg: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class _Candidate:
    """Random parts at their greatest likelihood; `point` has the parameters that `Noise.free` counts."""

    noise: Noise
    point: Array
    found: Likelihood
    criterion: float


def fit_series(*records: ErrorRecord) -> SeriesFit:
    """Fit the process of one angle's error, measured in one or more recordings.

    Raises InputError where fewer than `FEWEST` errors of a recording are known, or all are equal.
    """
    for record in records:
        known = int(record.known.sum())
        if known < FEWEST:
            raise InputError(record.name, f"{known} errors are known", f"{FEWEST} or more to fit a process")
        if not np.ptp(record.error[record.known]) > 0.0:
            raise InputError(record.name, "the error never changes", "an error that does",
                             "a bias is all there is: take a tracker of kind ideal")
    problem = _Problem(records)
    first = problem.fitted(Noise(slow=True))
    still = min((problem.fitted(noise, first) for noise in NOISES), key=_criterion)
    shaken = problem.fitted(replace(still.noise, shaken=True), still)
    return problem.scaled(min(still, shaken, key=_criterion))


def _criterion(candidate: _Candidate) -> float:
    return candidate.criterion


class _Problem:
    """Records less the part that follows from their motion, and the bounds of the parameters."""

    def __init__(self, records: Sequence[ErrorRecord]) -> None:
        self.records = records
        self.known = np.concatenate([record.known for record in records])
        self.rate = np.concatenate([record.rate for record in records])
        length = max(float(np.ptp(record.times_s[record.known])) for record in records)
        periods_s = [float(np.median(record.steps_s[:-1])) for record in records]
        strides = [max(1, round(_PERIOD_S / period_s)) for period_s in periods_s]
        usual = max(stride * period_s for stride, period_s in zip(strides, periods_s, strict=True))
        longest_fast = max(length / _LONGEST_FAST, 4.0 * usual)
        self.bounds = np.array([
            _ODDS, (math.log(max(_SHORT_S, 2.0 * usual)), math.log(length)),
            (math.log(0.25 * usual), math.log(length)),
            (math.log(usual), math.log(longest_fast)), _ODDS,
            (math.log(0.5 * usual), math.log(max(_LONGEST_QUICK_S, usual))),
            (math.log(min(_LEAST_HZ, 0.25 / usual)), math.log(0.5 / usual)), _SPEEDS_S])
        agility = max(float(np.std(self.rate[self.known])), 1e-2)
        start = (0.0, math.log(length / 8.0), math.log(_SHORT_S), math.log(4.0 * usual), math.log(0.1),
                 math.log(_SHORT_S), 0.0, -math.log(agility))
        self.start = np.clip(start, *self.bounds.T)
        self.motion = MotionColumns(*records)
        self.columns = self.motion.best()
        self.weights, residual = self.motion.least_squares(self.columns, np.flatnonzero(self.known))
        greatest = np.abs(self.rate[self.known]).max()
        ends = np.cumsum([record.times_s.size for record in records])[:-1]
        self.pieces = [
            Piece(error, record.times_s, np.minimum(np.abs(record.rate), greatest), stride)
            for error, record, stride in zip(np.split(residual, ends), records, strides, strict=True)]
        self.squares = [float(np.nansum(np.square(piece.error))) / piece.every for piece in self.pieces]
        self.compared = sum(int(np.isfinite(piece.error).sum()) / piece.every for piece in self.pieces)

    def fitted(self, noise: Noise, before: _Candidate | None = None) -> _Candidate:
        """Maximise the likelihood of the parts; the search starts at the result `before`, and elsewhere."""
        free = list(noise.free)
        bounds = self.bounds.copy()
        if not noise.slow:
            bounds[FAST_TIME, 1] = bounds[SLOW_TIME, 1]
        point = (self.start if before is None else before.point).copy()

        def negative_log(part: Array) -> float:
            point[free] = part
            return -self._likelihood(noise, point).log

        starts = [] if before is None else [point[free].copy()]
        if before is None or before.noise != noise:
            starts.append(self._likeliest_start(noise, free, negative_log))
        limits = Bounds(*bounds[free].T)
        found = min((minimize(negative_log, each, method="L-BFGS-B", bounds=limits,
                              options={"maxiter": 60, "ftol": 1e-8}) for each in starts),
                    key=lambda one: float(one.fun))
        point[free] = found.x
        count = 2 * len(self.records) + len(self.columns) + len(free) - 1
        criterion = count * math.log(self.compared) + 2.0 * float(found.fun)
        return _Candidate(noise, point, self._likelihood(noise, point), criterion)

    def _likeliest_start(self, noise: Noise, free: list[int],
                         negative_log: Callable[[Array], float]) -> Array:
        """The likeliest point of a grid of time constants and frequencies: there are many maxima."""
        times = {SLOW_TIME: noise.slow, RISE_TIME: noise.smooth, FAST_TIME: True}
        numbers = {index: _GRID for index, there in times.items() if there}
        if noise.swinging:
            numbers[FREQUENCY] = _FREQUENCIES
        axes = [np.linspace(low, high, number + 2)[1:-1]
                for number, (low, high) in zip(numbers.values(), self.bounds[list(numbers)], strict=True)]
        tried = []
        for values in product(*axes):
            start = self.start.copy()
            start[list(numbers)] = values
            tried.append(start[free])
        return min(tried, key=negative_log)

    def _likelihood(self, noise: Noise, point: Array) -> Likelihood:
        """Likelihood of the parts at the scale that gives them each residual's mean square."""
        parts = noise.parts(point)
        found = [likelihood([piece], parts, square / variance) for piece, square, variance in zip(
            self.pieces, self.squares, self._variances(parts), strict=True)]
        return Likelihood(sum(each.log for each in found), float(np.mean([each.scale for each in found])),
                          tuple(each.innovations[0] for each in found))

    def _variances(self, parts: Parts) -> list[float]:
        return [float(summed_variance(piece.error, piece.times_s, piece.speeds, parts)) / piece.every
                for piece in self.pieces]

    def scaled(self, best: _Candidate) -> SeriesFit:
        """The process with these parts."""
        noise, parts = best.noise, best.noise.parts(best.point)
        count = len(self.records)
        biases = np.degrees(self.weights[:count])
        slope, curve, lead = self.weights[count:].tolist()
        variances = self._variances(parts)
        scale = sum(self.squares) / sum(variances)
        sizes = 0.5 * np.log(np.divide(self.squares, variances))
        sd_deg = math.degrees(math.sqrt(scale))
        angle = np.degrees(self.motion.values[self.known, 1])
        series = ErrorSeries(
            name=self.records[0].name, moved=any(record.moved for record in self.records),
            bias_deg=float(biases.mean()), bias_sd_deg=float(biases.std(ddof=1)) if count > 1 else 0.0,
            size_sd=float(sizes.std(ddof=1)) if count > 1 else 0.0, slope=slope,
            curve_deg=math.degrees(curve), lead_s=lead, smooth=noise.smooth,
            slow_deg=sd_deg * math.sqrt(parts.slow), slow_s=parts.slow_s if noise.slow else 0.0,
            rise_s=parts.rise_s,
            fast_deg=sd_deg, fast_s=parts.fast_s, speed_s=parts.speed_s,
            quick_deg=sd_deg * math.sqrt(parts.quick + parts.white),
            quick_s=parts.quick_s if noise.swinging else 0.0,
            quick_hz=parts.quick_rate / (2.0 * math.pi) if noise.swinging else 0.0,
            angle_deg=(min(0.0, float(angle.min())), max(0.0, float(angle.max()))),
            rate_deg_s=float(np.degrees(np.abs(self.rate[self.known]).max())))
        if not noise.swinging:
            times_s = [quick_time_s(series, piece.error, record.rate, record.steps_s)
                       for piece, record in zip(self.pieces, self.records, strict=True)]
            series = replace(series, quick_s=float(np.mean(times_s)))
        too_slow = (parts.slow_s if noise.slow else parts.fast_s) > math.exp(
            self.bounds[SLOW_TIME, 1]) / _LEAST_TIMES
        return SeriesFit(series=series, innovations=np.concatenate(best.found.innovations),
                         criterion=best.criterion, too_slow=too_slow, biases_deg=tuple(biases.tolist()),
                         weight_spread=self._spread_of_weights(series))

    def _spread_of_weights(self, series: ErrorSeries) -> Array:
        """Covariance (4, 4) of the weights over records like these, from runs of the process."""
        count = len(self.records)
        noise = np.random.Generator(np.random.Philox(key=stream_key(0, f"weights/{series.name}", 0)))
        row = replace(series, bias_deg=0.0, slope=0.0, curve_deg=0.0, lead_s=0.0).row()
        runs = np.hstack([ensemble(row, record.angle, record.rate, record.steps_s,
                                   noise.standard_normal((_RUNS, DRAWS, record.times_s.size)))
                          for record in self.records])
        found, *_ = np.linalg.lstsq(self.motion.matrix(self.columns)[self.known], runs[:, self.known].T,
                                    rcond=None)
        covariance = np.zeros((4, 4))
        covariance[np.ix_(self.columns, self.columns)] = np.atleast_2d(
            np.cov(np.vstack([found[:count].mean(axis=0), found[count:]])))
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
        rise_s = series.row()[RISE]
        slow *= 1.0 - (smooth_steps(series.slow_s, rise_s, step_s)[0][0, 0] if rise_s else
                       math.exp(-step_s / series.slow_s))
    quick = math.radians(series.quick_deg) ** 2
    share = (changes - slow - fast * -math.expm1(-step_s / series.fast_s)) / quick if quick > 0.0 else 1.0
    if share >= 1.0:
        return 0.0
    longest = _SHORT_S / 3.0
    return min(-step_s / math.log1p(-share), longest) if share > 0.0 else longest
