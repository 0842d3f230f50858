"""Metrics as pure functions on arrays: joint angles, and how their error divides.

Everything is in rad and ns in, degrees out where the name says so. NaN in a reference means unknown and is
left out; NaN anywhere else comes out as NaN.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Stamps = NDArray[np.int64]
Trace = tuple[Stamps, Array]
"""Increasing instants (n,), ns, and the values from each on, (n, ...)."""


def held(trace: Trace, at_ns: Stamps) -> Array:
    """Values that stand at other instants (zero-order hold), (m, ...); NaN before the first."""
    times, values = trace
    if not times.size:
        return np.full((at_ns.size, *values.shape[1:]), np.nan)
    newest = np.searchsorted(times, at_ns, side="right") - 1
    standing = np.array(values[np.maximum(newest, 0)], dtype=np.float64)
    standing[newest < 0] = np.nan
    return standing


def rms(error: Array) -> Array:
    """Root mean square over the first axis."""
    return np.asarray(np.sqrt(np.mean(np.square(error), axis=0)))


def rmse_deg(measured: Trace, wanted: Trace) -> Array:
    """RMS of measured minus wanted at the measured instants that have both, (joints,), deg.

    NaN where there is no such instant.
    """
    times, values = measured
    error = values - held(wanted, times)
    error = error[np.isfinite(error).all(axis=tuple(range(1, error.ndim)))]
    return np.degrees(rms(error)) if len(error) else np.full(values.shape[1:], np.nan)


def joint_rmse_deg(trials: Sequence[tuple[Trace, Trace]]) -> list[float]:
    """RMSE of the true joint angles against the reference, over all joints, one a trial.

    `trials` holds (truth, reference) of each.
    """
    return [float(rms(rmse_deg(truth, reference))) for truth, reference in trials]


def tracker_rmse_deg(trials: Sequence[tuple[Trace, Trace]]) -> list[float]:
    """RMSE of the estimate against the truth, over all joints, one a trial.

    `trials` holds (estimate, truth) of each. Estimates are to be stamped with the instant at which the
    samples behind them were captured: latency then counts as latency and not as error of the tracker.
    """
    return [float(rms(rmse_deg(estimate, truth))) for estimate, truth in trials]


@dataclass(frozen=True, slots=True)
class TrackingSplit:
    """Error of one trial, RMS over time, (joints,) each, deg.

    At every instant: truth - reference = (truth - estimate) + (estimate - reference).

    Attributes
    ----------
    total: truth against reference, what the patient sees.
    tracker: truth against estimate, what the controller could not see, latency included.
    controller: estimate against reference, what it saw and did not put right.
    correlation: of the two parts, (joints,), so that total^2 = tracker^2 + controller^2
        + 2 correlation tracker controller; negative where the two errors cancel.
    """

    total: Array
    tracker: Array
    controller: Array
    correlation: Array


def split_error(truth: Trace, estimate: Trace, reference: Trace) -> TrackingSplit:
    """Divide the tracking error between tracker and controller, at the instants of the truth.

    Estimate and reference are held between their instants. Here the estimate is to be stamped with its
    arrival at the controller. Instants before the first estimate or reference are left out; all NaN where
    none are left.
    """
    times, true_values = truth
    seen, wanted = held(estimate, times), held(reference, times)
    sound = np.isfinite(seen + wanted + true_values)
    both = sound.all(axis=tuple(range(1, sound.ndim)))
    if not both.any():
        nothing = np.full(true_values.shape[1:], np.nan)
        return TrackingSplit(nothing, nothing, nothing, nothing)
    missed_by_tracker = (true_values - seen)[both]
    missed_by_controller = (seen - wanted)[both]
    tracker, controller = rms(missed_by_tracker), rms(missed_by_controller)
    product = np.mean(missed_by_tracker * missed_by_controller, axis=0)
    scale = tracker * controller
    correlation = np.divide(product, scale, out=np.zeros_like(scale), where=scale > 0.0)
    total = rms(missed_by_tracker + missed_by_controller)
    return TrackingSplit(np.degrees(total), np.degrees(tracker), np.degrees(controller), correlation)


def by_joint(values: Array, names: Sequence[str]) -> dict[str, float]:
    """Per-joint values under the joints' names."""
    return {name: float(value) for name, value in zip(names, values, strict=True)}
