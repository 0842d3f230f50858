"""Compares rotations of a reference with those of the gyroscopes, to refuse another quaternion convention.

An error against a quaternion with its components in another order, or with the inverse rotation, looks like
an error of the tracker. The reference's rotation in the sensor's frame from one instant to another must be
that of the gyroscope, whatever the earth frame is.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.hand import quaternion
from fesloop.loop.clock import NS_PER_S
from fesloop.streams.recording import MotionRecording

Array = NDArray[np.float64]
_TURN_S = 0.2
"""Duration of compared rotations (chosen: noise of 1 deg in the reference counts little)."""
_MOVES = np.radians(3.0)
"""Least compared rotation: 15 deg/s (chosen)."""
_LEAST, _MOST = 20, 600
"""Least number of rotations to decide by, and most to compare, evenly picked."""
_WRONG, _RIGHT = 0.7, 0.5
"""Median difference of rotations relative to their size: above the first the reference is wrong, below the
second another convention explains it (chosen; a reference that does not rotate at all gives 1)."""


def require_agreement(recording: MotionRecording) -> None:
    """Raise InputError for a sensor whose reference does not rotate as its gyroscope does.

    Only references in the sensors' frames are compared; with too few rotations to decide, they pass.
    """
    reference = recording.reference
    if reference is None or not reference.sensor_frames:
        return
    for number, name in enumerate(recording.sensors):
        begin, measured = _measured(recording, number)
        if len(begin) < _LEAST:
            continue
        left = {}
        for fault, conventional in _CONVENTIONS.items():
            given = conventional(reference.orientation[:, number])
            ends = [quaternion.interpolate(reference.stamps_ns, given, at)
                    for at in (begin, begin + round(_TURN_S * NS_PER_S))]
            turned = rotation_vector(quaternion.relative(*ends))
            known = np.isfinite(turned).all(axis=1)
            if known.sum() < _LEAST:
                break
            left[fault] = float(np.median(np.linalg.norm(turned - measured, axis=1)[known]
                                          / np.linalg.norm(measured, axis=1)[known]))
        if not left or left[""] < _WRONG:
            continue
        best = min(left, key=lambda fault: left[fault])
        raise InputError(
            f"{recording.path}: reference",
            f"{name}: does not rotate as the gyroscope does (they differ by {left['']:.0%} of a rotation)",
            "orientations of the sensor, w x y z, segment to reference",
            best if left[best] < _RIGHT else f"check `sensors.{name}.orientation`, its time, and "
            "`reference.order`, `direction` and `sensor_frames` in the layout")


def _other_way(q: Array) -> Array:
    return np.asarray(q * [1.0, -1.0, -1.0, -1.0])


_CONVENTIONS: dict[str, Callable[[Array], Array]] = {
    "": lambda q: q,
    "set the other `reference.direction` in the layout": _other_way,
    "set the other `reference.order` in the layout (scalar last)": lambda q: q[:, [3, 0, 1, 2]],
    "set the other `reference.order` in the layout (scalar first)": lambda q: q[:, [1, 2, 3, 0]],
    "set the other `reference.order` and `reference.direction` in the layout (scalar last)":
        lambda q: _other_way(q[:, [3, 0, 1, 2]]),
}
"""Conversions from other conventions of quaternions, by the remedy of each."""


def _measured(recording: MotionRecording, number: int) -> tuple[NDArray[np.int64], Array]:
    """Beginnings, ns, (m,), and rotation vectors (m, 3) of rotations that a gyroscope measured."""
    stamps, gyr = recording.stamps_ns, recording.gyr[:, number]
    assert recording.reference is not None
    first, last = recording.reference.stamps_ns[[0, -1]]
    length = round(_TURN_S * NS_PER_S)
    begin = np.arange(max(first, stamps[0]), min(last, stamps[-1]) - length, length)
    begin = begin[np.unique(np.linspace(0, len(begin) - 1, min(_MOST, len(begin))).astype(int))]
    if not len(begin):
        return begin, np.zeros((0, 3))
    first_row, end_row = np.searchsorted(stamps, [begin, begin + length])
    count = end_row - first_row
    turns = np.tile([1.0, 0.0, 0.0, 0.0], (len(begin), 1))
    turns[count < 2] = np.nan
    for step in range(int(count.max())):
        rates = gyr[np.minimum(first_row + step, len(gyr) - 1)]
        rotation = rates * np.where(step < count, _TURN_S / np.maximum(count, 1), 0.0)[:, np.newaxis]
        angle = np.linalg.norm(rotation, axis=1, keepdims=True)
        turns = quaternion.multiply(turns, np.hstack(
            [np.cos(0.5 * angle), 0.5 * np.sinc(0.5 * angle / np.pi) * rotation]))
    vectors = rotation_vector(turns)
    moves = np.linalg.norm(np.nan_to_num(vectors), axis=1) > _MOVES
    return begin[moves], vectors[moves]


def rotation_vector(q: Array) -> Array:
    """Axis times angle of the shorter rotation, (..., 3), rad; NaN for NaN."""
    shorter = np.where(q[..., :1] < 0.0, -q, q)
    length = np.linalg.norm(shorter[..., 1:], axis=-1, keepdims=True)
    angle = 2.0 * np.arctan2(length, shorter[..., :1])
    # For small angles the vector part is half the rotation vector.
    ratio = np.divide(angle, length, out=np.full_like(length, 2.0), where=length > 1e-12)
    return np.asarray(ratio * shorter[..., 1:])
