"""Identification of a patient's model from the record of an experiment (`identification.excitation`)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.signal import lfilter
from scipy.special import ndtr

from controllers.identification.dynamics import Dynamics, Method, identify_dynamics
from fesloop.errors import InputError
from fesloop.loop.clock import NS_PER_S
from fesloop.models.linear_model import LinearModel, Recruitment

Array = NDArray[np.float64]
USUAL_SPREAD, USUAL_LAG_S = 0.35, 0.1
"""Prior values and start of the fit (chosen: spread as of a finger's muscles; two such lags rise in about
.3 s)."""
_PRIOR_WEIGHT = 0.01
"""Cost of a parameter off by a factor e, as a share of the total variance (chosen: negligible where the
whole recruitment curve is recorded, decisive where only its lower end is)."""
_NEAR = 0.01
"""Relative distance to a bound at which a fit counts as being at it (chosen): fits never reach one."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RecruitmentFit:
    """Recruitment curve of one channel.

    Attributes
    ----------
    threshold_ma, spread: as in `fesloop.models.linear_model.Recruitment`.
    lag_s: time constant of each of the two lags.
    rest, gain: (m,), y0 and g, in the units of y.
    fit_percent: 100 (1 - |error| / |y - mean|).
    moved: (m,), peak to peak of y.
    at_bound: "or less" or "or more" by name, for threshold_ma and spread at an end of the search.
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
    """Effective current, mA, (n,); 0 without a pulse."""
    width_us = 1e6 * width_s
    return np.asarray(current_ma * width_us / (width_us + chronaxie_us))


def fit_recruitment(width_s: Array, current_ma: float, measured: Array, period_s: float, *,
                    chronaxie_us: float = 122.0, least_moved: float = 0.0) -> RecruitmentFit:
    """Fit the recruitment curve to a record of one channel.

    Parameters
    ----------
    width_s: (n,), pulse width at each tick, s, held until the next.
    current_ma: current of the channel.
    measured: (n, m), y at the ticks.
    period_s: period of the ticks.
    chronaxie_us: chronaxie, at a single current not separable from the threshold (the electrodes' default).
    least_moved: least peak-to-peak movement of an output, in its units, that counts as a response.

    Raises InputError without a pulse or a response.
    """
    if not (width_s > 0.0).any():
        raise InputError("recruitment", "no pulse was given", "stimulation",
                         "read the recording's events: `pose_contradicted` or `posture_jumped`, for example, "
                         "withholds it")
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
    """Held input (n,) behind two equal lags of gain 1, at the ticks, from rest: exact (with T = period / lag,
    the remainders of a step after one tick are e^-T (1 + T) and e^-T)."""
    ratio = period_s / lag_s
    keep = math.exp(-ratio)
    first = 1.0 - keep * (1.0 + ratio)
    second = keep * (keep - 1.0 + ratio)
    return np.asarray(lfilter([0.0, first, second], [1.0, -2.0 * keep, keep**2], course))


def _left_over(course: Array, measured: Array) -> tuple[Array, Array]:
    """Residuals of each column after a line in `course`, and the line: rows intercept, slope."""
    regressors = np.column_stack([np.ones(course.size), course])
    coefficients = np.linalg.lstsq(regressors, measured, rcond=None)[0]
    return measured - regressors @ coefficients, np.asarray(coefficients)


LEAST_MOVED = np.deg2rad(1.0)
"""Response of an angle, rad, above which a channel counts as recruiting (chosen: above the scatter of a
tracker at rest)."""
AHEAD_S = 0.5
"""Horizon of the prediction "half_second", like a predictive controller's."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class IdentificationRecord:
    """Record of an identification experiment on the ticks of the stimulation.

    Attributes
    ----------
    period_s: period of the ticks.
    stimulation: (n, channels, 2), A and s, held until the next tick.
    measured: (n, outputs), measurements at the ticks, by their instants of capture.
    phase: (n,), as in `Excitation`.
    outputs: names of the outputs.
    """

    period_s: float
    stimulation: Array
    measured: Array
    phase: Array
    outputs: tuple[str, ...]

    def __post_init__(self) -> None:
        used = self.phase >= 0.0
        if not np.isfinite(self.measured[used]).all():
            raise InputError("measured", "holds values that are not finite", "a number at every tick",
                             "use a tracker that observes all outputs")

    @property
    def channels(self) -> int:
        """Number of channels."""
        return int(self.stimulation.shape[1])


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Identified:
    """Identified model, with the results of its parts.

    Attributes
    ----------
    model: recruitment, delay and dynamics.
    curves: curve of each channel.
    current_ma: (channels,), currents.
    operating_drive, operating_outputs: means of the binary part.
    fit: percent (`fit_of`) by kind of prediction and output, on held-out samples.
    held_out_s: duration of these.
    """

    model: LinearModel
    curves: tuple[RecruitmentFit, ...]
    current_ma: tuple[float, ...]
    operating_drive: Array
    operating_outputs: Array
    fit: dict[str, dict[str, float]]
    held_out_s: float


def identify(record: IdentificationRecord, *, method: Method = "subspace", held_out: float = 1.0 / 3.0,
             chronaxie_us: float = 122.0, least_moved: float = LEAST_MOVED) -> Identified:
    """Identify the model of a record.

    Parameters
    ----------
    method: method of `identify_dynamics`.
    held_out: share of the binary part, at its end, that is not used for fitting.
    chronaxie_us: chronaxie, at a single current not separable from the threshold (the electrodes' default).
    least_moved: least movement that counts as a response, in the units of the outputs.

    Raises InputError for a channel without a response, a record that is too short, or no stable model.
    """
    curves = tuple(_curve(record, channel, chronaxie_us, least_moved) for channel in range(record.channels))
    used = record.stimulation[record.phase >= 0.0, :, 0]
    current_ma = tuple(float(1e3 * each) for each in used.max(axis=0))
    recruitment = Recruitment(threshold_ma=tuple(curve.threshold_ma for curve in curves),
                              spread=tuple(curve.spread for curve in curves), chronaxie_us=chronaxie_us)
    binary = record.phase == record.channels
    if not 0.0 < held_out < 1.0 or binary.sum() < 2:
        raise InputError("held_out", f"{held_out:g} of {int(binary.sum())} samples",
                         "a share between 0 and 1, of a run that reached its binary part")
    drive = np.array([recruitment.fraction(pulses) for pulses in record.stimulation[binary]])
    measured = record.measured[binary]
    first = len(drive) - round(held_out * len(drive))
    dynamics = identify_dynamics(drive[:first], measured[:first], record.period_s, method=method)
    a, b = dynamics.continuous()
    return Identified(
        model=LinearModel(a=a, b=b, c=dynamics.c, offset=dynamics.offset, recruitment=recruitment,
                          delay_ns=round(dynamics.delay_s * NS_PER_S)),
        curves=curves, current_ma=current_ma, operating_drive=drive[:first].mean(axis=0),
        operating_outputs=measured[:first].mean(axis=0),
        fit=predictions(dynamics, drive, measured, first, record.outputs),
        held_out_s=(len(drive) - first) * record.period_s)


def _curve(record: IdentificationRecord, channel: int, chronaxie_us: float,
           least_moved: float) -> RecruitmentFit:
    rows = record.phase == channel
    if not rows.any():
        raise InputError(f"channel {channel}", "was not recruited alone", "every channel",
                         "let the experiment run until its end")
    pulses = record.stimulation[rows, channel]
    try:
        return fit_recruitment(pulses[:, 1], float(1e3 * pulses[:, 0].max()), record.measured[rows],
                               record.period_s, chronaxie_us=chronaxie_us, least_moved=least_moved)
    except InputError as fault:
        raise InputError(f"channel {channel}: {fault.where}", fault.found, fault.allowed,
                         fault.remedy) from None


def predictions(dynamics: Dynamics, drive: Array, measured: Array, first: int,
                outputs: Sequence[str]) -> dict[str, dict[str, float]]:
    """Fit of three predictions from sample `first` on, percent by output.

    "free_run" uses the drives alone; "half_second" and "one_step" add the error of the free run that long
    before, as a controller does that estimates an output disturbance.
    """
    free = dynamics.response(drive)
    missed = measured - free
    found = {"free_run": free[first:]}
    for kind, steps in (("half_second", max(1, round(AHEAD_S / dynamics.period_s))), ("one_step", 1)):
        found[kind] = free[first:] + missed[first - steps:len(drive) - steps]
    return {kind: dict(zip(outputs, fit_of(measured[first:], predicted), strict=True))
            for kind, predicted in found.items()}


def fit_of(measured: Array, predicted: Array) -> list[float]:
    """Fit 100 (1 - |measured - predicted| / |measured - mean|) of each column."""
    error = np.linalg.norm(measured - predicted, axis=0)
    spread = np.linalg.norm(measured - measured.mean(axis=0), axis=0)
    return [float(value) for value in 100.0 * (1.0 - error / np.maximum(spread, 1e-300))]
