"""Transformation between the frames of two measuring systems."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from fesloop.errors import InputError
from fesloop.hand import quaternion

Array = NDArray[np.float64]
_UNIT = 1e-6
LEAST_SPREAD = 0.03
"""Ratio of the second singular value to the first below which vectors are parallel (chosen: 2 deg)."""


class FrameAlignment(NamedTuple):
    """Transformation from frame a to frame b.

    Attributes
    ----------
    rotation: (4,), w x y z, from the coordinates of a to those of b.
    origin: (3,), b's origin in a's coordinates.
    rms: rms residual: for directions the angle, rad; for points the distance, in their unit.
    """

    rotation: Array
    origin: Array
    rms: float = 0.0

    def points(self, positions: ArrayLike) -> Array:
        """Positions (..., 3) in b from those in a: shifted by -origin, then rotated (S19 eq. 29)."""
        return quaternion.rotate(self.rotation, np.asarray(positions, dtype=np.float64) - self.origin)

    def orientations(self, orientations: ArrayLike) -> Array:
        """Orientations (..., 4) relative to b from those relative to a."""
        return quaternion.multiply(self.rotation, orientations)


def alignment(rotation: ArrayLike, centre: ArrayLike) -> FrameAlignment:
    """Transformation with a known rotation and an identified centre, such as to the wrist coordinate system.

    As in Salchow-Hoemmen et al. 2019 (doi 10.3390/s19010208, eq. 29): a translation by -centre, then the
    rotation from the optical system to the WCS.

    Raises InputError unless they are a unit quaternion and a finite point.
    """
    turn, origin = np.asarray(rotation, dtype=np.float64), np.asarray(centre, dtype=np.float64)
    if turn.shape != (4,) or not abs(float(np.linalg.norm(turn)) - 1.0) <= _UNIT:
        raise InputError("rotation", f"{turn.tolist()}", "a quaternion (w, x, y, z) of length 1")
    if origin.shape != (3,) or not np.isfinite(origin).all():
        raise InputError("centre", f"{origin.tolist()}", "three finite numbers")
    return FrameAlignment(turn, origin)


def align_directions(in_a: ArrayLike, in_b: ArrayLike, weights: ArrayLike | None = None) -> FrameAlignment:
    """Least-squares rotation from directions (m, 3) in a to the same directions in b (Wahba's problem).

    Pairs that are not finite are ignored; `weights` (m,) are 1 by default.

    Raises InputError for unequal numbers of directions, and if all are parallel.
    """
    a, b, given = _pairs(in_a, in_b, weights)
    a, b = (_units(rows, name) for rows, name in ((a, "in_a"), (b, "in_b")))
    rotation = _best_rotation(a, b, given, "directions are parallel")
    left = quaternion.rotate(rotation, a)
    angles = np.arctan2(np.linalg.norm(np.cross(left, b), axis=1), np.sum(left * b, axis=1))
    return FrameAlignment(rotation, np.zeros(3), float(np.sqrt(np.average(angles**2, weights=given))))


def align_points(in_a: ArrayLike, in_b: ArrayLike, weights: ArrayLike | None = None) -> FrameAlignment:
    """Least-squares rigid motion from points (m, 3) in a to the same points in b (Kabsch).

    Parameters and errors are those of `align_directions`; points on one line are refused too.
    """
    a, b, given = _pairs(in_a, in_b, weights)
    middle_a, middle_b = (np.average(rows, axis=0, weights=given) for rows in (a, b))
    rotation = _best_rotation(a - middle_a, b - middle_b, given, "points lie on one line")
    origin = middle_a - quaternion.rotate(quaternion.conjugate(rotation), middle_b)
    away = np.sum((quaternion.rotate(rotation, a - origin) - b) ** 2, axis=1)
    return FrameAlignment(rotation, origin, float(np.sqrt(np.average(away, weights=given))))


def _pairs(in_a: ArrayLike, in_b: ArrayLike, weights: ArrayLike | None) -> tuple[Array, Array, Array]:
    a, b = np.asarray(in_a, dtype=np.float64), np.asarray(in_b, dtype=np.float64)
    if a.ndim != 2 or a.shape[1:] != (3,) or a.shape != b.shape:
        raise InputError("in_a and in_b", f"shapes {a.shape} and {b.shape}", "(m, 3) both")
    given = np.ones(len(a)) if weights is None else np.asarray(weights, dtype=np.float64)
    if given.shape != (len(a),) or not (np.isfinite(given).all() and (given >= 0.0).all() and given.any()):
        raise InputError("weights", f"{given.tolist()}", f"{len(a)} finite numbers, 0 or more, not all 0")
    known = np.isfinite(a).all(axis=1) & np.isfinite(b).all(axis=1) & (given > 0.0)
    if known.sum() < 2:
        raise InputError("in_a and in_b", f"{known.sum()} pairs are known", "2 directions, 3 points or more",
                         "measure more of them in both frames")
    return a[known], b[known], given[known]


def _units(vectors: Array, where: str) -> Array:
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    if not (lengths > 0.0).all():
        raise InputError(where, "a vector is zero", "directions")
    return np.asarray(vectors / lengths)


def _best_rotation(a: Array, b: Array, weights: Array, fault: str) -> Array:
    """Least-squares rotation, (4,), from a to b, each (m, 3)."""
    for rows in (a, b):
        strengths = np.linalg.svd(np.sqrt(weights)[:, np.newaxis] * rows, compute_uv=False)
        if not strengths[1] > LEAST_SPREAD * strengths[0]:
            raise InputError("in_a and in_b", fault, "vectors in two directions or more",
                             "add one that is not parallel")
    found = Rotation.align_vectors(b, a, weights=weights)[0]
    return np.asarray(found.as_quat(canonical=True, scalar_first=True))
