"""Metrics of orientation: a tracker's against a recording's reference.

The error of an orientation is e = q_estimate q_reference*, a rotation in the earth frame, with total,
heading and inclination error as BROAD defines them (Laidig et al. 2021, doi 10.3390/data6070072): the angle
of e, of its part about the vertical, and of the tilt that is left. The total error does not exceed the sum
of the other two.
"""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.hand import quaternion
from fesloop.loop.clock import NS_PER_MS
from fesloop.streams.recording import MotionRecording, Reference

Array = NDArray[np.float64]
Heading = Literal["absolute", "relative"]
_STEP_NS = 100 * NS_PER_MS
_MOVES_RAD = np.radians(0.5)
"""RMS turn in such a step above which a joint moves (chosen: 5 deg/s)."""


def orientation_error(estimate: Array, reference: Array) -> Array:
    """Error in the earth frame, (..., 4), of orientations "sensor to earth" (..., 4)."""
    return quaternion.multiply(estimate, quaternion.conjugate(reference))


def relative_orientation_error(parent_error: Array, child_error: Array) -> Array:
    """Error of the orientation of child relative to parent, (..., 4), in the reference's earth frame.

    From the errors of both: e_parent* e_child has the angle of (relative estimate) (relative reference)*,
    and its vertical part is the error of the heading of one against the other.
    """
    return quaternion.relative(parent_error, child_error)


def constant_heading(error: Array) -> float:
    """Circular mean of the heading error over the rows (m, 4) that are known, rad."""
    heading = quaternion.twist_z(error)
    heading = heading[np.isfinite(heading)]
    return float(np.angle(np.mean(np.exp(1j * heading))))


def without_heading(error: Array, heading: float) -> Array:
    """The error with a constant heading taken off, (m, 4)."""
    return quaternion.multiply(quaternion.about_z(-heading), error)


def error_rmse_deg(error: Array) -> dict[str, float]:
    """RMS of total, heading and inclination error, deg, over the rows (m, 4) that are known."""
    known = error[np.isfinite(error).all(axis=-1)]
    parts = {"total": quaternion.rotation_angle(known), "heading": quaternion.twist_z(known),
             "inclination": quaternion.tilt_z(known)}
    return {name: _rms_deg(part) for name, part in parts.items()}


def relative_angle_rmse_deg(estimate: Array, reference: Array) -> float:
    """RMS difference, deg, between the angles of relative orientations (m, 4) of two segments.

    It does not depend on how each sensor sits on its segment, as long as both sit alike.
    """
    difference = quaternion.rotation_angle(estimate) - quaternion.rotation_angle(reference)
    return _rms_deg(difference[np.isfinite(difference)])


def flexion_rmse_deg(times_ns: NDArray[np.int64], angle: Array, reference: Reference, pair: tuple[int, int]
                     ) -> float:
    """RMS error, deg, of a joint's flexion as a tracker puts it out, (n,), rad, at its captures (n,).

    That of the reference is the first of the z-x-y Euler angles of child to parent, as of `vqf`. Estimates
    are interpolated to the reference's instants. NaN where nothing is known of both.
    """
    at = reference.scored & (reference.stamps_ns >= times_ns[0]) & (reference.stamps_ns <= times_ns[-1])
    true = quaternion.euler_zxy(quaternion.relative(*(reference.orientation[at, end] for end in pair)))[:, 0]
    known = np.isfinite(angle)
    if known.sum() < 2:
        return float("nan")
    error = np.interp(reference.stamps_ns[at], times_ns[known], np.unwrap(angle[known])) - true
    error = np.angle(np.exp(1j * error))
    return _rms_deg(error[np.isfinite(error)])


def flexion_axis_share(times_ns: NDArray[np.int64], relative: Array) -> float | None:
    """Share of a joint's turning that is about its parent's z, of orientations (n, 4) child to parent.

    Squares of what it turns in steps of a tenth of a second are summed. None where it hardly turns.
    """
    known = np.isfinite(relative).all(axis=1)
    captured, first = np.unique(times_ns[known], return_index=True)
    if captured.size < 2:
        return None
    at = np.arange(captured[0], captured[-1] + 1, _STEP_NS)
    posture = quaternion.interpolate(captured, relative[known][first][:, np.newaxis], at)[:, 0]
    turn = quaternion.multiply(posture[1:], quaternion.conjugate(posture[:-1]))
    turn = turn[np.isfinite(turn).all(axis=1)]
    squares = np.square(2.0 * turn[:, 1:])
    total = float(squares.sum())
    if not len(turn) or np.sqrt(total / len(turn)) < _MOVES_RAD:
        return None
    return float(squares[:, 2].sum()) / total


def _rms_deg(angles: Array) -> float:
    return float(np.degrees(np.sqrt(np.mean(np.square(angles))))) if angles.size else float("nan")


def score_recording(
    recording: MotionRecording, times_ns: NDArray[np.int64], orientation: Array, heading: Heading
) -> dict[str, Any]:
    """Score orientations of a recording's sensors against its reference.

    Estimates are interpolated to the reference's instants; instants that are not to be scored, lie outside
    the estimates or have no reference are left out.

    Parameters
    ----------
    times_ns: (n,), increasing, on the recording's time base: when the samples behind each were captured.
    orientation: (n, sensors, 4), sensor to earth.
    heading: "absolute" for a tracker with magnetometers; "relative" for one without: a constant heading
        (the circular mean of the heading error) is removed from each sensor's error by itself. It is also
        removed where the reference has no north.

    Returns
    -------
    "orientation_rmse_deg": segment, and "parent-child" for relative orientation, to {total, heading,
    inclination}. The relative error is that of the estimates as they are, with no heading removed: trackers
    without magnetometers answer for the drift and for the first heading of one sensor against the other.
    "relative_angle_rmse_deg": "parent-child" to the error of the angle between both. Segments and pairs
    without a single scored instant are left out, and a metric without any; so all is left out where the
    recording has no reference, and orientations where its frames are not the sensors'.

    Raises InputError for orientations of another number of sensors.
    """
    if orientation.shape != (times_ns.size, len(recording.sensors), 4):
        raise InputError("orientation", f"has shape {orientation.shape}",
                         f"({times_ns.size}, {len(recording.sensors)}, 4)")
    reference = recording.reference
    if reference is None or times_ns.size == 0:
        return {}
    scored = np.flatnonzero(reference.scored)
    estimate = quaternion.interpolate(times_ns, orientation, reference.stamps_ns[scored])
    true = reference.orientation[scored]
    known = np.asarray(np.isfinite(estimate * true).all(axis=-1))
    scores = {"orientation_rmse_deg": _orientation_scores(recording, reference, estimate, true, heading),
              "relative_angle_rmse_deg": {
                  recording.pair_name((p, c)): relative_angle_rmse_deg(
                      quaternion.relative(estimate[:, p], estimate[:, c]),
                      quaternion.relative(true[:, p], true[:, c]))
                  for p, c in recording.pairs if (known[:, p] & known[:, c]).any()}}
    return {name: values for name, values in scores.items() if values}


def _orientation_scores(
    recording: MotionRecording, reference: Reference, estimate: Array, true: Array, heading: Heading
) -> dict[str, dict[str, float]]:
    if not reference.sensor_frames:
        return {}
    error = orientation_error(estimate, true)
    errors = {name: error[:, i] for i, name in enumerate(recording.sensors)}
    errors = {name: of_sensor for name, of_sensor in errors.items() if np.isfinite(of_sensor).any()}
    if heading == "relative" or not reference.north:
        errors = {name: without_heading(e, constant_heading(e)) for name, e in errors.items()}
    for p, c in recording.pairs:
        of_pair = relative_orientation_error(error[:, p], error[:, c])
        if np.isfinite(of_pair).any():
            errors[recording.pair_name((p, c))] = of_pair
    return {name: error_rmse_deg(e) for name, e in errors.items()}
