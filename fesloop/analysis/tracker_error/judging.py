"""Judges a fitted process by errors that it was not fitted to.

Many runs of the process along the measured motion, with the same gaps, answer three questions:

- Is the RMS error of all runs within 15 % of the measured one?
- Are the increments, the changes of the error over 0.05 to 0.5 s to which a controller reacts, as large?
  The RMS of all runs must be within 15 % of the measured one at each of these times.
- Does the measured autocorrelation lie in the band of the runs' autocorrelations? These are of errors less
  their mean, at 40 lags up to a quarter of the record. For these runs, the part of the error that follows
  from the motion is random within the uncertainty of its fit. The band covers 95 % of the runs as a whole,
  not lag by lag: each lag's distance from the mean of the runs is measured in units of its own sd (the
  studentised global envelope, doi 10.1111/rssb.12172). The share of lags between the 2.5th and the 97.5th
  percentile of the runs at that lag is reported beside it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.analysis.tracker_error.error_record import ErrorRecord, autocorrelation
from fesloop.analysis.tracker_error.series_fit import SeriesFit
from fesloop.loop.noise import stream_key
from fesloop.models.error_process import ErrorSeries
from fesloop.models.error_steps import BIAS, CURVE, DRAWS, LEAD, SLOPE, along, ensemble, sizes

Array = NDArray[np.float64]
WITHIN = 0.15
RUNS, LAGS = 999, 40
CONFIDENCE = 0.95
INCREMENTS_S = (0.05, 0.1, 0.2, 0.5)
"""Times over which increments are compared (chosen: from a controller's period to the end of a twitch)."""
_SHORTEST = 4
"""Least ratio of the record's length to a lag: at longer lags an autocorrelation has too few pairs."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Judgement:
    """A fitted process compared with a measured record.

    Attributes
    ----------
    name, moved: of the angle.
    fitted_deg: RMS error of the fitted record. measured_deg: RMS error of the record it is compared with.
    process_deg: RMS error of the process along that motion; process_low_deg, process_high_deg: bounds of the
        central 95 % of its runs.
    lags_s: (lags,). measured, low, high: (lags,), autocorrelation, and the band as a whole.
    share: of the lags inside the band lag by lag.
    increment_times_s: (times,), the times over which increments are compared: whole samples.
    increments_deg: (times,), RMS of the measured increments; process_increments_deg: those of the runs.
    """

    name: str
    moved: bool
    fitted_deg: float
    measured_deg: float
    process_deg: float
    process_low_deg: float
    process_high_deg: float
    lags_s: Array
    measured: Array
    low: Array
    high: Array
    share: float
    increment_times_s: Array
    increments_deg: Array
    process_increments_deg: Array

    @property
    def rmse_off(self) -> float:
        """Relative difference of the process's RMSE from the measured one."""
        return self.process_deg / self.measured_deg - 1.0

    @property
    def rmse_holds(self) -> bool:
        """Whether `rmse_off` is within 15 %."""
        return bool(abs(self.rmse_off) <= WITHIN)

    @property
    def halves_differ(self) -> float:
        """Relative difference of the fitted record's RMSE from the measured one."""
        return self.fitted_deg / self.measured_deg - 1.0

    @property
    def autocorrelation_holds(self) -> bool:
        """Whether the whole autocorrelation lies in the band."""
        return bool(((self.measured >= self.low) & (self.measured <= self.high)).all())

    @property
    def increments_off(self) -> Array:
        """Relative difference of the process's increments from the measured ones, (times,)."""
        return self.process_increments_deg / self.increments_deg - 1.0

    @property
    def increments_hold(self) -> bool:
        """Whether all `increments_off` are within 15 %."""
        return bool((np.abs(self.increments_off) <= WITHIN).all())

    def as_table(self) -> dict[str, Any]:
        """The table that commands print with --json."""
        return {"angle": self.name, "moved": self.moved, "rmse_fitted_deg": self.fitted_deg,
                "rmse_measured_deg": self.measured_deg, "rmse_process_deg": self.process_deg,
                "rmse_process_95_deg": [self.process_low_deg, self.process_high_deg],
                "rmse_within_15_percent": self.rmse_holds, "halves_differ": self.halves_differ,
                "autocorrelation_in_band": self.autocorrelation_holds, "lags_in_band_share": self.share,
                "increments": {"times_s": self.increment_times_s.tolist(),
                               "measured_deg": self.increments_deg.tolist(),
                               "process_deg": self.process_increments_deg.tolist(),
                               "within_15_percent": self.increments_hold}}


def judge(fit: SeriesFit, fitted: ErrorRecord, record: ErrorRecord, seed: int = 0) -> Judgement:
    """Judge a process that was fitted to one record by another record."""
    series, known = fit.series, record.known
    noise = np.random.Generator(np.random.Philox(key=stream_key(seed, f"judge/{series.name}", 0)))
    draws = noise.standard_normal((RUNS, DRAWS, record.times_s.size))
    runs = ensemble(series.row(), record.angle, record.rate, record.steps_s, draws)
    factors, offsets = of_recordings(series, seed)
    if series.size_sd:
        follows = along(series.row(), record.angle, record.rate)
        runs = follows + factors * (runs - follows)
    squares = np.mean(np.square(runs[:, known] + offsets), axis=1)
    each = np.degrees(np.sqrt(squares))
    steps = increment_steps(record)
    increments = np.sqrt(np.mean(np.square(rms_increments(runs, known, steps)), axis=0))
    lags = lags_of(record)
    measured = autocorrelation(record.error[np.newaxis], known, lags)[0]
    row = series.row()
    offs = noise.multivariate_normal(np.zeros(4), fit.weight_spread, RUNS, method="eigh")
    for run, off in zip(runs, offs, strict=True):
        other = row.copy()
        other[[BIAS, SLOPE, CURVE, LEAD]] = off
        run += along(other, record.angle, record.rate)
    made = autocorrelation(runs, known, lags)
    low, high = whole_band(made)
    lowest, highest = np.percentile(made, [50.0 * (1.0 - CONFIDENCE), 50.0 * (1.0 + CONFIDENCE)], axis=0)
    period_s = float(np.median(record.steps_s[:-1]))
    return Judgement(
        name=series.name, moved=series.moved, fitted_deg=fitted.rms_deg, measured_deg=record.rms_deg,
        process_deg=float(np.degrees(np.sqrt(squares.mean()))),
        process_low_deg=float(np.percentile(each, 2.5)), process_high_deg=float(np.percentile(each, 97.5)),
        lags_s=np.asarray(lags * period_s, dtype=np.float64),
        measured=measured, low=low, high=high,
        share=float(np.mean((measured >= lowest) & (measured <= highest))),
        increment_times_s=np.asarray(steps * period_s, dtype=np.float64),
        increments_deg=np.degrees(rms_increments(record.error[np.newaxis], known, steps)[0]),
        process_increments_deg=np.degrees(increments))


def of_recordings(series: ErrorSeries, seed: int) -> tuple[Array, Array]:
    """Factors on the random parts of the runs, and differences of constant parts, rad: (runs, 1) each."""
    noise = np.random.Generator(np.random.Philox(key=stream_key(seed, f"recording/{series.name}", 0)))
    size, bias = noise.standard_normal((2, RUNS, 1))
    return sizes(np.array(series.size_sd), size), np.asarray(np.radians(series.bias_sd_deg) * bias)


def increment_steps(record: ErrorRecord) -> NDArray[np.int64]:
    """Times over which increments are compared, in samples: those nearest to `INCREMENTS_S`, each once.

    Times within which a record has no two known errors are left out; the shortest one always has.
    """
    steps = np.unique(np.maximum(np.rint(np.array(INCREMENTS_S) / np.median(record.steps_s[:-1])), 1.0))
    known = record.known
    return np.array([step for step in steps.astype(np.int64) if (known[step:] & known[:-step]).any()])


def rms_increments(errors: Array, known: NDArray[np.bool_], steps: NDArray[np.int64]) -> Array:
    """RMS change of each row of errors (runs, n) over numbers of samples, (runs, steps).

    Each uses the pairs of instants that are both `known` (n,).
    """
    found = np.empty((len(errors), steps.size))
    for i, step in enumerate(steps):
        both = np.flatnonzero(known[step:] & known[:-step])
        found[:, i] = np.sqrt(np.mean(np.square(errors[:, both + step] - errors[:, both]), axis=1))
    return found


def lags_of(record: ErrorRecord) -> NDArray[np.int64]:
    """Compared lags in samples: evenly spaced up to a quarter of the record, at most `LAGS` of them."""
    most = max(1, record.times_s.size // _SHORTEST)
    return np.unique(np.linspace(1, most, min(LAGS, most)).round().astype(np.int64))


def whole_band(made: Array) -> tuple[Array, Array]:
    """Band that covers 95 % of curves (runs, lags) as a whole: lower and upper bound, (lags,) each."""
    middle = made.mean(axis=0)
    sd = np.maximum(made.std(axis=0, ddof=1), np.finfo(float).eps)
    reach = float(np.quantile(np.abs((made - middle) / sd).max(axis=1), CONFIDENCE))
    return middle - reach * sd, middle + reach * sd
