"""Orientation of each sensor on its segment, from two poses of the wearer or as stated.

Two directions that are known in a segment's frame and measured in its sensor's determine the rotation between
them: upwards while the hand lies flat, and the axis about which it then flexes (Kortier et al. 2014,
doi 10.1186/1743-0003-11-70, eq. 34). The equation as printed maps segment to sensor, and is no rotation
unless the two measured axes are perpendicular; here its inverse is used, and the departure of the two from
perpendicularity is shared equally between them. `estimators.calibration.poses` sums up the poses.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from estimators.calibration.poses import (
    USUAL_LIMITS,
    FlatPose,
    Flexion,
    PoseLimits,
    SensorFault,
    flat_faults,
    flexion_faults,
    raise_faults,
)
from fesloop.errors import InputError
from fesloop.hand import quaternion

Array = NDArray[np.float64]
Side = Literal["left", "right"]
FLEXION = (0.0, 0.0, 1.0)
"""Axis of flexion in every segment's frame, of both hands (fesloop.hand.skeleton)."""
_PARALLEL = 0.1
"""Sine of the least angle between two directions that determine a rotation (chosen: 6 deg)."""
_UNIT = 1e-6


class Mounting(NamedTuple):
    """Orientations of n sensors on their segments.

    Attributes
    ----------
    rotations: (n, 4), sensor to segment, w x y z.
    skew_deg: (n,), signed error of the angle between the two measured axes (for K14's two: from 90 deg), deg;
        each of the axes is off by half of it.
    wobble_deg: (n,), rotation of the flexion about other axes, deg; 0: about one alone.
    quality: (n,), in [0, 1], cos(skew) cos(wobble): fit of the two poses to a single axis at the right angle.
        It does not show a pure flexion about a wrong axis perpendicular to the vertical.
    """

    rotations: Array
    skew_deg: Array
    wobble_deg: Array
    quality: Array


def dorsal(side: str) -> tuple[float, float, float]:
    """Direction of the back of the hand in every segment's frame: +x of the left, -x of the right hand.

    Raises InputError for another side.
    """
    if side not in ("left", "right"):
        raise InputError("side", f"{side!r}", "'left', 'right'")
    return (1.0 if side == "left" else -1.0, 0.0, 0.0)


def assumed_mounting(rotations: ArrayLike, sensors: int) -> Array:
    """Rotations (sensors, 4), sensor to segment, as stated: identity if empty, one for all, or one each.

    Raises InputError for another number, and unless they are unit quaternions.
    """
    stated = np.asarray(rotations, dtype=np.float64)
    if stated.size == 0:
        stated = np.array([[1.0, 0.0, 0.0, 0.0]])
    stated = np.atleast_2d(stated)
    if stated.ndim != 2 or stated.shape[1] != 4 or len(stated) not in (1, sensors):
        raise InputError("rotations", f"shape {stated.shape}", f"none, one, or {sensors} quaternions",
                         "give the rotation of each sensor")
    lengths = np.linalg.norm(stated, axis=1)
    wrong = ~(np.abs(lengths - 1.0) <= _UNIT)
    if wrong.any():
        raise InputError(f"rotations[{int(np.argmax(wrong))}]", f"{stated[wrong][0].tolist()}",
                         "a quaternion (w, x, y, z) of length 1", "divide it by its length")
    return np.array(np.broadcast_to(stated, (sensors, 4)))


def directions(given: ArrayLike, usual: ArrayLike, sensors: int, where: str) -> Array:
    """Unit vectors (sensors, 3): `usual` for all if empty, else one for all or one each.

    Raises InputError for another number of them and for a zero vector.
    """
    stated = np.atleast_2d(np.asarray(given, dtype=np.float64))
    if stated.size == 0:
        stated = np.atleast_2d(np.asarray(usual, dtype=np.float64))
    if stated.ndim != 2 or stated.shape[1] != 3 or len(stated) not in (1, sensors):
        raise InputError(where, f"shape {stated.shape}", f"none, one, or {sensors} vectors (x, y, z)")
    lengths = np.linalg.norm(stated, axis=1, keepdims=True)
    if not (np.isfinite(lengths).all() and (lengths > 0.0).all()):
        raise InputError(where, f"{stated.tolist()}", "finite vectors, none of them zero")
    return np.array(np.broadcast_to(stated / lengths, (sensors, 3)))


def rotation_from_axes(measured: tuple[ArrayLike, ArrayLike], known: tuple[ArrayLike, ArrayLike]) -> Array:
    """Rotations (..., 4), w x y z, that take two measured directions to two known ones.

    Where the angles between the two differ, both have equal errors: the least-squares
    rotation of two equally trusted directions (Wahba's problem), and for perpendicular known directions
    the orthogonalised eq. 34 of doi 10.1186/1743-0003-11-70, transposed.

    Parameters
    ----------
    measured, known: each two arrays (..., 3) of unit vectors.

    Raises InputError for nearly parallel directions, which do not determine a rotation.
    """
    from_frame, to_frame = _bisecting_frame(*measured), _bisecting_frame(*known)
    matrices = to_frame @ np.swapaxes(from_frame, -1, -2)
    shape = matrices.shape[:-2]
    quaternions = Rotation.from_matrix(matrices.reshape(-1, 3, 3)).as_quat(canonical=True, scalar_first=True)
    return np.asarray(quaternions).reshape(*shape, 4)


def _bisecting_frame(first: ArrayLike, second: ArrayLike) -> Array:
    """Matrices (..., 3, 3) with the columns bisector, in-plane normal and normal of two unit vectors."""
    a, b = np.asarray(first, dtype=np.float64), np.asarray(second, dtype=np.float64)
    normal, middle = np.cross(a, b), a + b
    sine = np.linalg.norm(normal, axis=-1, keepdims=True)
    if not (sine > _PARALLEL).all():
        raise InputError("axes", "two directions are nearly parallel: they determine no rotation",
                         "directions well apart, best perpendicular", "choose another pose or axis")
    normal = normal / sine
    middle = middle / np.linalg.norm(middle, axis=-1, keepdims=True)
    return np.stack([middle, np.cross(normal, middle), normal], axis=-1)


def mounting_from_poses(flat: FlatPose, flexion: Flexion, verticals: Array, axes: Array) -> Mounting:
    """Mounting from two poses, with `verticals` and `axes` (n, 3) in the segments' frames.

    A sensor whose measured directions determine no rotation has the identity, and a large skew.
    """
    up, about = flat.vertical(), flexion.axis()
    skew = np.degrees(_angles(up, about) - _angles(verticals, axes))
    rotations = np.tile([1.0, 0.0, 0.0, 0.0], (len(up), 1))
    fixed = np.linalg.norm(np.cross(up, about), axis=1) > _PARALLEL
    rotations[fixed] = rotation_from_axes((up[fixed], about[fixed]), (verticals[fixed], axes[fixed]))
    wobble = flexion.wobble_deg()
    quality = np.clip(np.cos(np.radians(skew)) * np.cos(np.radians(wobble)), 0.0, 1.0)
    return Mounting(rotations, skew, wobble, quality)


def mounting_from_flat(flat: FlatPose, verticals: Array, stated: Array) -> Array:
    """Rotations (n, 4), sensor to segment, from one pose: the stated ones with the least change that aligns
    the vertical with `verticals` (n, 3) in the segments' frames.

    The rotation about the vertical, which accelerometers do not show, stays as stated. Sensors without a
    vertical keep their stated rotation.
    """
    up = quaternion.rotate(stated, flat.vertical())
    cosine = np.sum(up * verticals, axis=1, keepdims=True)
    half = np.concatenate([1.0 + cosine, np.cross(up, verticals)], axis=1)
    known = np.linalg.norm(half, axis=1) > _PARALLEL
    found = stated.copy()
    found[known] = quaternion.multiply(quaternion.normalized(half[known]), stated[known])
    return found


def _angles(a: Array, b: Array) -> Array:
    """Angles (n,) between unit vectors (n, 3), rad in [0, pi]."""
    return np.asarray(np.arctan2(np.linalg.norm(np.cross(a, b), axis=-1), np.sum(a * b, axis=-1)))


def mounting_faults(mounting: Mounting, limits: PoseLimits, stated: Array | None) -> list[SensorFault]:
    """Faults of sensors whose two axes have a wrong angle, or that differ from the stated mounting (n, 4)."""
    faults = [SensorFault(i, f"vertical and flexion axis are {skew:+.1f} deg from the angle they should make",
                          f"within {limits.skew_deg:g} deg",
                          "lay the hand flat, then flex without abduction or rotation")
              for i, skew in enumerate(mounting.skew_deg) if not abs(skew) <= limits.skew_deg]
    if stated is not None:
        away = np.degrees(quaternion.rotation_angle(quaternion.relative(stated, mounting.rotations)))
        faults += [SensorFault(int(i), f"is {away[i]:.0f} deg from the stated `rotations`",
                               f"within {limits.placement_deg:g} deg",
                               "raise the hand before the flexion begins, flex first, or correct `rotations`")
                   for i in np.flatnonzero(away > limits.placement_deg)]
    return faults


def calibrate_by_poses(
    flat_gyr: ArrayLike, flat_acc: ArrayLike, flexion_gyr: ArrayLike, *, period_s: float,
    side: Side = "right", limits: PoseLimits = USUAL_LIMITS, names: Sequence[str] = (),
    rotations: ArrayLike = (), verticals: ArrayLike = (), axes: ArrayLike = (),
) -> Mounting:
    """Sensor to segment by the two poses of Kortier et al. 2014, from samples of n sensors.

    The wearer holds the hand flat on a table, its back upwards, raises it, and then flexes every joint. The
    furthest turn within `flexion_gyr` counts as flexion, so that it may contain the way back, not the
    raising.

    Parameters
    ----------
    flat_gyr, flat_acc: (m, n, 3), rad/s and m/s^2, in the sensors' frames, of the flat hand.
    flexion_gyr: (k, n, 3), rad/s, of the flexion, evenly spaced by `period_s`, s.
    side: side of the hand, which decides where dorsal is.
    limits: limits beyond which a pose is refused.
    names: names of the sensors, for messages.
    rotations: stated mountings (`assumed_mounting`) to check the poses against; empty: none.
    verticals: direction upwards in the segments' frames while the hand is flat; empty: dorsal.
    axes: first axes of rotation of the segments in the flexion, in their frames; empty: +z.

    Raises InputErrors with a line for every sensor that moved in the flat pose, has too few samples,
    disagrees with gravity or the stated mounting, or did not rotate about one axis.
    """
    still, resting, bending = (_samples(rows, name) for rows, name in (
        (flat_gyr, "flat_gyr"), (flat_acc, "flat_acc"), (flexion_gyr, "flexion_gyr")))
    sensors = still.shape[1]
    if not resting.shape[1] == bending.shape[1] == sensors:
        raise InputError("flexion_gyr", f"{resting.shape[1]} and {bending.shape[1]} sensors beside {sensors}",
                         "the same sensors in every pose")
    ups = directions(verticals, dorsal(side), sensors, "verticals")
    turns = directions(axes, FLEXION, sensors, "axes")
    flat = FlatPose.of(sensors)
    flat.take_gyr(still)
    flat.take_acc(resting)
    stated = assumed_mounting(rotations, sensors) if np.size(rotations) else None
    raise_faults(flat_faults(flat, limits, stated, ups), names)
    flexion = Flexion.of(sensors)
    flexion.take(bending - flat.bias(), np.full(len(bending), period_s))
    raise_faults(flexion_faults(flexion, limits), names)
    mounting = mounting_from_poses(flat, flexion, ups, turns)
    raise_faults(mounting_faults(mounting, limits, stated), names)
    return mounting


def _samples(rows: ArrayLike, where: str) -> Array:
    samples = np.asarray(rows, dtype=np.float64)
    if samples.ndim != 3 or samples.shape[2] != 3:
        raise InputError(where, f"shape {samples.shape}", "(samples, sensors, 3)")
    return samples
