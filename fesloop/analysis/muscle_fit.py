"""Fit of a muscle with a tendon to recordings of its force at known lengths, with standard errors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from fesloop.errors import InputError
from fesloop.models.hill_muscle import HillMuscle
from fesloop.streams.stimulation import ForceCourse

Array = NDArray[np.float64]
STEP_S = 1e-3
"""Time between samples of a trial, s; faster recordings are averaged over it."""
Bounds = Mapping[str, tuple[float, float]]
"""Least and greatest value of each fitted parameter of `HillMuscle`, by name."""


class MuscleTrial(NamedTuple):
    """A recording of a muscle: name, kind; length with tendon, m, force, N, and drive, 0 to 1, (n,) each."""

    name: str
    kind: str
    length_m: Array
    force_n: Array
    drive: Array


def trial_of(course: ForceCourse, frequency_hz: float) -> MuscleTrial:
    """Trial at `STEP_S` of a recorded course; a pulse acts on all fibres until the next is due.

    Raises InputError for a course without length, or one whose sampling period does not divide `STEP_S`.
    """
    if not np.isfinite(course.length_m).all():
        raise InputError(course.name, "the length of the muscle is missing", "a length for every sample")
    ratio = STEP_S / course.period_s
    count = round(ratio)
    if count < 1 or abs(ratio - count) > 1e-6:
        raise InputError(course.name, f"a sample each {1e3 * course.period_s:g} ms",
                         "a whole number of samples in a millisecond")
    whole = course.force_n.size // count * count
    length, force = (each[:whole].reshape(-1, count).mean(axis=1)
                     for each in (course.length_m, course.force_n))
    times = STEP_S * np.arange(length.size)
    after = times[:, np.newaxis] - course.pulses_s
    driven = (after > -0.5 * course.period_s) & (after < 1.0 / frequency_hz - 0.5 * course.period_s)
    return MuscleTrial(course.name, course.kind, length, force, driven.any(axis=1).astype(float))


@dataclass(frozen=True, slots=True, kw_only=True)
class MuscleFit:
    """A fitted muscle.

    Attributes
    ----------
    muscle: with the fitted parameters.
    standard_errors: of each fitted parameter, by name; NaN for one that lies on its bound.
    """

    muscle: HillMuscle
    standard_errors: dict[str, float]


def rms_error(muscle: HillMuscle, trial: MuscleTrial) -> float:
    """Root mean square of the predicted less the measured force of a trial, N."""
    predicted = muscle.force(trial.length_m, trial.drive, STEP_S)
    return float(np.sqrt(np.mean((predicted - trial.force_n) ** 2)))


def fit_muscle(trials: Sequence[MuscleTrial], bounds: Bounds, start: HillMuscle | None = None) -> MuscleFit:
    """Fit the parameters named in `bounds` by least squares; every trial has the same weight.

    Standard errors are those of independent trials (White's covariance, clustered by trial: Cameron and
    Miller 2015, doi 10.3368/jhr.50.2.317), since errors within a trial depend on each other.

    Parameters
    ----------
    trials: at least two.
    bounds: of the fitted parameters.
    start: other parameters, and where the search starts (default: `HillMuscle()`), but for force and slack
        length, which start where the trials' greatest force says.

    Raises InputError for fewer trials, and for a muscle that never pulls.
    """
    if len(trials) < 2:
        raise InputError("trials of a muscle", f"{len(trials)}", "at least 2")
    strongest = max(trials, key=lambda trial: float(trial.force_n.max()))
    at = int(np.argmax(strongest.force_n))
    if not strongest.force_n[at] > 0.0 or not any(trial.drive.any() for trial in trials):
        raise InputError("trials of a muscle", "none of them has stimulation and force",
                         "force under stimulation")
    muscle = start or HillMuscle()
    begin = replace(muscle, force_n=float(strongest.force_n[at]), slack_mm=max(
        1.0, (1e3 * float(strongest.length_m[at]) - muscle.fibre_mm) / (1.0 + muscle.strain)))
    low, high = (np.array([each[k] for each in bounds.values()]) for k in (0, 1))
    names = list(bounds)
    first = np.clip([getattr(begin, name) for name in names], low + 0.01 * (high - low),
                    high - 0.01 * (high - low))

    def of(values: Any) -> HillMuscle:
        return replace(muscle, **dict(zip(names, map(float, values), strict=True)))

    def residuals(values: Any) -> Array:
        now = of(values)
        return np.concatenate([(now.force(each.length_m, each.drive, STEP_S) - each.force_n)
                               / np.sqrt(each.force_n.size) for each in trials])

    found = least_squares(residuals, first, bounds=(low, high), x_scale=first,
                          diff_step=np.full(first.size, 1e-4), max_nfev=100)
    return MuscleFit(muscle=of(found.x), standard_errors=_errors(found, names, trials))


def _errors(found: Any, names: Sequence[str], trials: Sequence[MuscleTrial]) -> dict[str, float]:
    """Standard error of each parameter by the sandwich of trials, NaN on a bound."""
    free = np.flatnonzero(found.active_mask == 0)
    jacobian, errors = found.jac[:, free], np.full(len(names), np.nan)
    edges = np.cumsum([trial.force_n.size for trial in trials])[:-1]
    scores = np.array([part.T @ rest for part, rest in zip(
        np.split(jacobian, edges), np.split(found.fun, edges), strict=True)])
    bread = np.linalg.pinv(jacobian.T @ jacobian)
    errors[free] = np.sqrt(np.diag(bread @ (scores.T @ scores) @ bread))
    return dict(zip(names, map(float, errors), strict=True))
