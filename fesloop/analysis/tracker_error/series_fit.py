"""Fitting the error process of one angle: how much of a model the recording bears out.

What follows from the motion is settled first (`motion_columns`). Of what is left, time constants and shares
of the random parts are those of greatest likelihood; which parts there are is chosen by the Bayesian
information criterion (doi 10.1214/aos/1176344136). At last all random parts are scaled by one factor, so that
the process has the mean square that was measured. A time constant of more than a fifth of the record is one
that the record is too short to tell: `too_slow` says so.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import Bounds, minimize

from fesloop.analysis.tracker_error.error_record import ErrorRecord
from fesloop.analysis.tracker_error.motion_columns import MotionColumns
from fesloop.analysis.tracker_error.state_filter import Likelihood, likelihood
from fesloop.errors import InputError
from fesloop.loop.noise import stream_key
from fesloop.models.error_process import ErrorSeries
from fesloop.models.error_steps import DRAWS, ensemble, random_variance

Array = NDArray[np.float64]
FEWEST = 100
"""Known instants below which nothing is fitted (chosen: a dozen for each number that may be)."""
_LONGEST_FAST = 20.0
"""Time constants: the fast one from a sample to a 20th of the record, the slow one from two samples to all of
it; where there is no slow one, the fast one to all of it as well."""
_TOLD = 5.0
"""By how much the record must be longer than a time constant (chosen: two or three independent values)."""
_PERIOD_S = 0.1
"""Errors are compared with those of so long before, and not from sample to sample: a process in few numbers
cannot be right at every scale, and stimulated muscles do not follow what is faster (chosen: a twitch rises in
as long)."""
_RUNS = 300
"""Of the process, to learn how well its weights can be told (chosen: their sd within 4 %)."""
_ODDS = (math.log(1e-4), math.log(1e4))
_SPEEDS_S = (math.log(1e-3), math.log(1e2))


@dataclass(frozen=True, slots=True)
class Noise:
    """Which random parts there are besides the fast and the white one, and where a fit of them begins.

    Attributes
    ----------
    slow: whether there is a slow part. smooth: whether that has a derivative. shaken: whether motion drives
        the fast one.
    """

    slow: bool
    shaken: bool
    smooth: bool = False

    @property
    def free(self) -> tuple[int, ...]:
        """Numbers of the free ones of log (slow variance, slow_s, fast_s, white variance, speed_s)."""
        return tuple(i for i in range(5) if (i not in (0, 1) or self.slow) and (i != 4 or self.shaken))


NOISES = tuple(Noise(slow, shaken, smooth) for slow, smooth in ((False, False), (True, False), (True, True))
               for shaken in (False, True))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SeriesFit:
    """The process of one angle, fitted.

    Attributes
    ----------
    series: it.
    innovations: (n,), what the fit could not foresee, standardised; NaN where the error is not known.
    criterion: of the model that was chosen.
    weight_spread: (4, 4), covariance of bias, slope, curve and lead, in rad and s: how well a record of this
        length tells them.
    too_slow: whether the longest time constant is one that the record is too short to tell.
    """

    series: ErrorSeries
    innovations: Array
    criterion: float
    weight_spread: Array
    too_slow: bool


@dataclass(frozen=True, slots=True, eq=False)
class _Candidate:
    """Random parts at their greatest likelihood, `point` as of `Noise.free`."""

    noise: Noise
    point: Array
    found: Likelihood
    criterion: float


def fit_series(record: ErrorRecord) -> SeriesFit:
    """The process of one angle's error.

    Raises InputError where fewer than `FEWEST` errors are known, or none differs from another.
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
    return problem.told(min(every, key=lambda candidate: candidate.criterion))


class _Problem:
    """A record made ready: what follows from the motion taken off, bounds of the parameters."""

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
        self.weights, self.left = self.motion.least_squares(self.columns, np.flatnonzero(known))

    def fitted(self, noise: Noise, before: _Candidate | None = None) -> _Candidate:
        """The parts at their greatest likelihood; the search begins where that of those `before` ended."""
        free = list(noise.free)
        bounds = self.bounds.copy()
        if not noise.slow:
            bounds[2, 1] = bounds[1, 1]
        point = (self.start if before is None else before.point).copy()

        def unlikely(part: Array) -> float:
            point[free] = part
            return -self._likelihood(noise, point).log

        starts = [point[free].copy()]
        if before is not None and before.noise != noise:
            starts.append(self.start[free])
        limits = Bounds(*bounds[free].T)
        found = min((minimize(unlikely, each, method="L-BFGS-B", bounds=limits,
                              options={"maxiter": 60, "ftol": 1e-8}) for each in starts),
                    key=lambda one: float(one.fun))
        point[free] = found.x
        count = len(self.columns) + len(free) + 1
        criterion = count * math.log(self.known.sum() / self.thinning) + 2.0 * float(found.fun)
        return _Candidate(noise, point, self._likelihood(noise, point), criterion)

    def _likelihood(self, noise: Noise, point: Array) -> Likelihood:
        slow, slow_s, fast_s, white, speed_s = np.exp(point).tolist()
        return likelihood(
            self.left, self.record.times_s, self.speeds, self.thinning, slow=slow if noise.slow else 0.0,
            slow_s=slow_s, smooth=noise.smooth, fast_s=fast_s, white=white,
            speed_s=speed_s if noise.shaken else 0.0)

    def told(self, best: _Candidate) -> SeriesFit:
        """The process, its random parts scaled to the mean square that is left."""
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
        foreseen = random_variance(series.row(), record.rate, self.steps_s)[known]
        factor = math.sqrt(float(np.mean(self.left[known] ** 2) / np.mean(foreseen)))
        series = replace(series, **{name: factor * getattr(series, name)
                                    for name in ("slow_deg", "fast_deg", "quick_deg")})
        too_slow = (slow_s if noise.slow else fast_s) > math.exp(self.bounds[1, 1]) / _TOLD
        return SeriesFit(
            series=replace(series, quick_s=quick_time_s(series, self.left, record.rate, self.steps_s)),
            innovations=best.found.innovations, criterion=best.criterion, too_slow=too_slow,
            weight_spread=self._spread_of_weights(series))

    def _spread_of_weights(self, series: ErrorSeries) -> Array:
        """Covariance (4, 4) of the weights over records like this one: by runs of the process."""
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


def quick_time_s(series: ErrorSeries, left: Array, rates: Array, steps_s: Array) -> float:
    """Time constant of the quick part, by how much the error (n,) changes from one sample to the next.

    What the other parts change is taken off; 0 where as much is left as of independent samples.
    """
    step_s = float(np.median(steps_s[:-1]))
    changes = 0.5 * float(np.nanmean(np.square(np.diff(left))))
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
