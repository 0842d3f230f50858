"""Metrics as pure functions on arrays: joint angles, and how their error divides.

Everything is in rad and ns in, degrees out where the name says so. A joint by itself may have no axis of
joints, in one trace and not in another. NaN in a reference means unknown and is left out; NaN anywhere else
comes out as NaN.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from fesloop.loop.clock import NS_PER_S

Array = NDArray[np.float64]
Stamps = NDArray[np.int64]
_ROWS_AT_ONCE = 8192
"""Rows of a trace that are read at once, so that an hour need not be in memory."""


class Values(Protocol):
    """An array (n, ...), or an object that reads slices of one that is too long for memory."""

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the array."""

    def __getitem__(self, rows: Any, /) -> Array:
        """A span of rows."""


Trace = tuple[Stamps, Values]
"""Increasing instants (n,), ns, and the values from each on, (n, ...)."""


def held(trace: Trace, at_ns: Stamps) -> Array:
    """Values at other instants by zero-order hold, (m, ...); NaN before the first."""
    times, values = trace
    newest = np.searchsorted(times, at_ns, side="right") - 1
    values_then = np.full((at_ns.size, *values.shape[1:]), np.nan)
    known = newest >= 0
    if known.any():
        first, last = newest[known].min(), newest.max()
        values_then[known] = values[first:last + 1][newest[known] - first]
    return values_then


def columns(values: Array) -> Array:
    """Rows as vectors, (n, size): a number is a vector of one."""
    return values.reshape(len(values), -1)


def rms(error: Array) -> Array:
    """Root mean square over the first axis."""
    return np.asarray(np.sqrt(np.mean(np.square(error), axis=0)))


def _pieces(trace: Trace) -> Iterator[tuple[Stamps, Array]]:
    """The trace in spans of rows."""
    times, values = trace
    for first in range(0, times.size, _ROWS_AT_ONCE):
        rows = slice(first, first + _ROWS_AT_ONCE)
        yield times[rows], values[rows]


def _known(values: Array) -> NDArray[np.bool_]:
    """Rows without NaN, (n,)."""
    return np.asarray(np.isfinite(values).all(axis=tuple(range(1, values.ndim))))


def rmse_deg(measured: Trace, wanted: Trace, *, still: Array | None = None) -> Array:
    """RMS of measured minus wanted at the measured instants that have both, (joints,), deg.

    NaN where there is no such instant. `still`: a value, (joints,), that replaces every measured one.
    """
    total, count = np.zeros(measured[1].shape[1:]), 0
    for times, values in _pieces(measured):
        if still is not None:
            values = np.broadcast_to(still, values.shape)
        reference = held(wanted, times).reshape(values.shape)
        known = _known(reference)
        total += np.square((values - reference)[known]).sum(axis=0)
        count += int(known.sum())
    return np.degrees(np.sqrt(total / count)) if count else np.full(total.shape, np.nan)


def joint_rmse_deg(trials: Sequence[tuple[Trace, Trace]]) -> list[float]:
    """RMSE of the true joint angles against the reference, over all joints, one a trial.

    `trials` holds (truth, reference) of each.
    """
    return [float(rms(np.atleast_1d(rmse_deg(truth, reference)))) for truth, reference in trials]


def unmoved_rmse_deg(trials: Sequence[tuple[Trace, Trace]], begun: Sequence[Array]) -> list[float]:
    """Baseline `joint_rmse_deg` of joints that stay at each trial's first angles, `begun`, (joints,)."""
    return [float(rms(np.atleast_1d(rmse_deg(truth, reference, still=still))))
            for (truth, reference), still in zip(trials, begun, strict=True)]


def tracker_rmse_deg(trials: Sequence[tuple[Trace, Trace]]) -> list[float]:
    """RMSE of the estimate against the truth, over all joints, one a trial.

    `trials` holds (estimate, truth) of each. Estimates are to be stamped with the instant at which the
    samples behind them were captured: latency then counts as latency and not as error of the tracker.
    """
    return [float(rms(np.atleast_1d(rmse_deg(estimate, truth)))) for estimate, truth in trials]


def range_deg(trace: Trace) -> Array:
    """Range from the least to the greatest angle of a trial, (joints,), deg; NaN for an empty trial."""
    least = np.full(trace[1].shape[1:], np.inf)
    greatest = np.full(least.shape, -np.inf)
    for _, values in _pieces(trace):
        np.minimum(least, values.min(axis=0), out=least)
        np.maximum(greatest, values.max(axis=0), out=greatest)
    return np.degrees(greatest - least) if trace[0].size else np.full(least.shape, np.nan)


@dataclass(frozen=True, slots=True)
class TrackingSplit:
    """Error of one trial, RMS over time, (joints,) each, deg.

    At every instant: truth - reference = (truth - estimate) + (estimate - reference).

    Attributes
    ----------
    total: truth against reference, the error of the movement.
    tracker: truth against estimate, the error that the controller cannot observe, latency included.
    controller: estimate against reference, the error that it observes and does not correct.
    correlation: of the two parts, (joints,), so that total^2 = tracker^2 + controller^2
        + 2 correlation tracker controller; negative where the two errors cancel.
    from_s: of the first instant that counts; NaN where none does.
    """

    total: Array
    tracker: Array
    controller: Array
    correlation: Array
    from_s: float


def split_error(truth: Trace, estimate: Trace, reference: Trace) -> TrackingSplit:
    """Divide the tracking error between tracker and controller, at the instants of the truth.

    Estimate and reference keep their values between their instants (zero-order hold). The estimate must be
    stamped with its arrival at the controller. Instants before the first estimate or reference are left out;
    all NaN where none are left.
    """
    tracker, controller, product, total = np.zeros((4, *truth[1].shape[1:]))
    count, from_s = 0, math.nan
    for times, true_values in _pieces(truth):
        seen, target = (held(trace, times).reshape(true_values.shape) for trace in (estimate, reference))
        both = _known(seen + target)
        missed_by_tracker = (true_values - seen)[both]
        missed_by_controller = (seen - target)[both]
        tracker += np.square(missed_by_tracker).sum(axis=0)
        controller += np.square(missed_by_controller).sum(axis=0)
        product += (missed_by_tracker * missed_by_controller).sum(axis=0)
        total += np.square(missed_by_tracker + missed_by_controller).sum(axis=0)
        if both.any() and not count:
            from_s = float(times[both][0]) / NS_PER_S
        count += int(both.sum())
    if not count:
        nothing = np.full(total.shape, np.nan)
        return TrackingSplit(nothing, nothing, nothing, nothing, from_s)
    scale = np.sqrt(tracker * controller)
    correlation = np.divide(product, scale, out=np.zeros_like(scale), where=scale > 0.0)
    # Where a sum of squares overflows, the correlation is not known; it is marked as infinite, like the sum.
    correlation[~np.isfinite(scale)] = np.inf
    total, tracker, controller = np.degrees(np.sqrt(np.stack([total, tracker, controller]) / count))
    return TrackingSplit(total, tracker, controller, correlation, from_s)


def by_joint(values: Array, names: Sequence[str]) -> dict[str, float]:
    """Values by the name of the joint."""
    return {name: float(value) for name, value in zip(names, values, strict=True)}


TWO_SIDED_95 = 1.959963984540054


def fingertip_error(estimate: Trace, truth: Trace) -> Array:
    """Vectors (n, tips, 3), m, from the truth to the estimate, at the estimate's instants.

    The truth keeps its value between its instants (zero-order hold); estimates before the first are left out.
    Estimates must be stamped with the capture of the samples behind them (doi 10.3390/s19010208, eq. 30).
    """
    times, values = estimate
    error = np.asarray(values[:]) - held(truth, times)
    return np.asarray(error[np.isfinite(error).all(axis=(1, 2))])


def fingertip_rmse_mm(error: Array) -> Array:
    """RMS distance of each fingertip from the truth, (tips,), mm (doi 10.3390/s19010208, eq. 31)."""
    squared = np.square(error).sum(axis=2)
    return np.asarray(1e3 * np.sqrt(squared.mean(axis=0))) if len(error) else np.full(error.shape[1], np.nan)


def coverage(error: Array, sd: Array) -> Array:
    """Share of each fingertip's coordinates, (tips,), within the 95 % interval of their sd (n, tips, 3)."""
    if not len(error):
        return np.full(error.shape[1], np.nan)
    inside = np.abs(error) <= TWO_SIDED_95 * sd
    return np.asarray(inside.mean(axis=(0, 2)))


def by_tip(trials: Sequence[Array], names: Sequence[str]) -> dict[str, list[float]]:
    """Values of all trials by the name of the fingertip."""
    return {name: [float(trial[i]) for trial in trials] for i, name in enumerate(names)}
