"""Unit dual quaternions Q = r + eps d on arrays (..., 8): real part (w, x, y, z), then dual part.

They carry a rotation and a translation at once (doi 10.3390/s19010208, eq. 12-16): Q "b to a" takes the
coordinates of a point in frame b to those in frame a. Leading axes broadcast; lengths in m.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fesloop.hand import quaternion

Array = NDArray[np.float64]


def _joined(real: Array, dual: Array) -> Array:
    return np.concatenate(np.broadcast_arrays(real, dual), axis=-1)


def _pure(vector: ArrayLike) -> Array:
    """The vector (..., 3) as a quaternion without a scalar part, (..., 4)."""
    v = np.asarray(vector, dtype=np.float64)
    return np.concatenate([np.zeros((*v.shape[:-1], 1)), v], axis=-1)


def rotation(q: ArrayLike) -> Array:
    """Q_r of a unit quaternion (..., 4): (..., 8), eq. 14."""
    real = np.asarray(q, dtype=np.float64)
    return _joined(real, np.zeros(4))


def translation(vector: ArrayLike) -> Array:
    """Q_t = 1 + eps (0, vector) / 2 of a displacement (..., 3): (..., 8), eq. 15."""
    return _joined(np.array([1.0, 0.0, 0.0, 0.0]), 0.5 * _pure(vector))


def multiply(a: ArrayLike, b: ArrayLike) -> Array:
    """Product a b, (..., 8), where eps squared is 0: first b, then a."""
    left, right = np.asarray(a, dtype=np.float64), np.asarray(b, dtype=np.float64)
    real = quaternion.multiply(left[..., :4], right[..., :4])
    dual = quaternion.multiply(left[..., :4], right[..., 4:]) + quaternion.multiply(left[..., 4:],
                                                                                   right[..., :4])
    return _joined(real, dual)


def inverse(q: ArrayLike) -> Array:
    """The inverse transformation of a unit dual quaternion, (..., 8): both parts conjugated."""
    array = np.asarray(q, dtype=np.float64)
    return _joined(quaternion.conjugate(array[..., :4]), quaternion.conjugate(array[..., 4:]))


def transform(q: ArrayLike, point: ArrayLike) -> Array:
    """L(point, Q), (..., 3): the point turned, then moved, eq. 13 and 27."""
    # Eq. 13's sandwich Q D(v) Q* with Q* = r* - eps d* has v as eps (r v r* + d r* - r d*).
    array = np.asarray(q, dtype=np.float64)
    return quaternion.rotate(array[..., :4], point) + position(array)


def orientation(q: ArrayLike) -> Array:
    """Unit quaternion of the rotation, (..., 4)."""
    return np.asarray(q, dtype=np.float64)[..., :4]


def position(q: ArrayLike) -> Array:
    """Image of the origin, (..., 3): the vector part of 2 d r*."""
    array = np.asarray(q, dtype=np.float64)
    return 2.0 * quaternion.multiply(array[..., 4:], quaternion.conjugate(array[..., :4]))[..., 1:]
