"""Trains of pulses to a biceps: rise and decay of force in half of the trains from the other half.

The muscle is held, so that its force is the active state of `fesloop.models.hill_muscle` at one length. Its
two parameters are fitted to every second train, whose scales are free, and predict the others. Force comes
from a torque at the hand, smoothed forward and backward by an unstated filter: its time constants are those
of the muscle, the arm and that filter, and a delay cannot be read from it
(doi 10.5281/zenodo.10427934).
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from fesloop.apps.reproduce.comparison import Row
from fesloop.apps.reproduce.people.part import Part
from fesloop.apps.reproduce.result import Sweep
from fesloop.streams.stimulation import ForceCourse, open_stimulation

Array = NDArray[np.float64]
WITHIN = 0.2
"""Greatest relative error that holds."""


class Shape(NamedTuple):
    """Parameters of the active state: time constant of calcium, ms, and calcium of half activation."""

    calcium_ms: float
    half: float


def active_course(shape: Shape, course: ForceCourse, frequency_hz: float) -> Array:
    """Active state (samples,) under the course's pulses, each of which acts until the next is due."""
    times = course.period_s * np.arange(course.force_n.size)
    end, tau = course.pulses_s[-1] + 1.0 / frequency_hz, 1e-3 * shape.calcium_ms
    rising = -np.expm1(-np.minimum(times, end) / tau)
    calcium = rising * np.exp(-np.maximum(times - end, 0.0) / tau)
    return np.asarray((1.0 + shape.half**3) * calcium**3 / (calcium**3 + shape.half**3))


def crossing(course: Array, level: float) -> float:
    """Index, with a fraction, at which a course first rises to a level; NaN if it never does."""
    after = int(np.argmax(course >= level))
    if course[after] < level:
        return np.nan
    return after - 1 + (level - course[after - 1]) / (course[after] - course[after - 1]) if after else 0.0


def rise_and_decay(force: Array, last_pulse_s: float, period_s: float) -> tuple[float, float]:
    """Rise from 10 to 90 % of the greatest force, and time from the last pulse to half the fall, ms."""
    above = force - force[0]
    rise = crossing(above, 0.9 * above.max()) - crossing(above, 0.1 * above.max())
    last = round(last_pulse_s / period_s)
    fallen = (above[last] - above[last:]) / (above[last] - above[-1])
    return 1e3 * period_s * rise, 1e3 * period_s * crossing(fallen, 0.5)


def scaled(shape: Shape, course: ForceCourse, frequency_hz: float) -> Array:
    """Active state times the scale that suits the course best, N."""
    active, above = active_course(shape, course, frequency_hz), course.force_n - course.force_n[0]
    return active * float(active @ above) / float(active @ active)


def fit_shape(courses: Sequence[ForceCourse], frequency_hz: float) -> Shape:
    """Fit the active state to courses, each with its own scale and the same weight."""
    def residuals(logs: Any) -> Array:
        shape = Shape(*np.exp(logs))
        return np.concatenate([
            (scaled(shape, each, frequency_hz) + each.force_n[0] - each.force_n)
            / (np.ptp(each.force_n) * np.sqrt(each.force_n.size)) for each in courses])

    return Shape(*map(float, np.exp(least_squares(residuals, np.log([100.0, 0.5])).x)))


def part(folder: Path, random_people: int) -> Part:
    """Rows of rise and decay, peaks of the trains, and courses for figures."""
    recording = open_stimulation(folder / "biceps_force.npz")
    frequency, courses = recording.frequency_hz, recording.forces
    shape = fit_shape(courses[1::2], frequency)
    others = courses[::2]
    measured, predicted = (np.median([rise_and_decay(force, each.pulses_s[-1], each.period_s)
                                      for each, force in zip(others, forces, strict=True)], axis=0)
                           for forces in ([each.force_n for each in others],
                                          [active_course(shape, each, frequency) for each in others]))
    rows = [_row(*each) for each in zip(("rise, 10 to 90 %", "half decay after the last pulse"), measured,
                                        predicted, strict=True)]
    sweeps = {"biceps_peaks": peaks(courses), "biceps_shape": Sweep(
        title="biceps: active state fitted to every second train", unit="ms, 1",
        columns=("calcium_ms", "half"), rows=(("biceps", tuple(shape)),))}
    return Part(rows, sweeps, {"trains": [
        {"name": each.name, "fitted": number % 2 == 1,
         "times_s": each.period_s * np.arange(each.force_n.size), "theirs_n": each.force_n,
         "ours_n": scaled(shape, each, frequency) + each.force_n[0]}
        for number, each in enumerate(courses)]})


def _row(name: str, theirs: float, ours: float) -> Row:
    off = ours / theirs - 1.0
    return Row("biceps, trains not fitted", name, float(round(theirs, 1)),
               f"{ours:.0f} ({100.0 * off:+.0f} %)", bool(abs(off) <= WITHIN), "ms")


def peaks(courses: Sequence[ForceCourse]) -> Sweep:
    """Greatest force of the trains that are not fitted: by an exponential fall of the others, and their mean.

    The first train, which has a kink, is left out.
    """
    number, peak = np.arange(1, len(courses)), np.array([each.force_n.max() for each in courses[1:]])
    seen = number % 2 == 1
    slope, level = np.polyfit(number[seen], np.log(peak[seen]), 1)
    errors = (np.exp(level + slope * number) / peak - 1.0, peak[seen].mean() / peak - 1.0)
    rms = tuple(float(100.0 * np.sqrt(np.mean(each[~seen]**2))) for each in errors)
    return Sweep(title="biceps: greatest force of trains not fitted, relative rms error, and fall per train",
                 unit="%", columns=("exponential", "mean", "fall"),
                 rows=(("biceps", (*rms, -100.0 * float(slope))),))
