"""Unit quaternions on arrays of shape (..., 4): components (w, x, y, z), Hamilton.

A quaternion `q` called "a to b" turns the coordinates of a vector in frame a into its coordinates in frame
b: v_b = q v_a q*. Leading axes broadcast. NaN in, NaN out.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fesloop.hand import quaternion_kernels as kernels

Array = NDArray[np.float64]


def _plain(kernel: Any) -> Any:
    """The Python form of a kernel, which takes arrays; the kernel itself where compilation is turned off."""
    return getattr(kernel, "py_func", kernel)


def _parts(q: ArrayLike) -> tuple[Any, Any, Any, Any]:
    array = np.asarray(q, dtype=np.float64)
    return array[..., 0], array[..., 1], array[..., 2], array[..., 3]


def _joined(parts: tuple[Any, Any, Any, Any]) -> Array:
    return np.stack(np.broadcast_arrays(*parts), axis=-1)


def multiply(a: ArrayLike, b: ArrayLike) -> Array:
    """Product a b (first b, then a), (..., 4)."""
    return _joined(_plain(kernels.multiply)(_parts(a), _parts(b)))


def conjugate(q: ArrayLike) -> Array:
    """Inverse rotation, (..., 4)."""
    return _joined(_plain(kernels.conjugate)(_parts(q)))


def relative(a: ArrayLike, b: ArrayLike) -> Array:
    """a* b, (..., 4): with "a to world" and "b to world" given, "b to a"."""
    return multiply(conjugate(a), b)


def normalized(q: ArrayLike) -> Array:
    """The quaternion with length 1, (..., 4); NaN for length 0."""
    array = np.asarray(q, dtype=np.float64)
    length = np.linalg.norm(array, axis=-1, keepdims=True)
    unit = np.full_like(array, np.nan)
    np.divide(array, length, out=unit, where=length > 0.0)
    return unit


def rotate(q: ArrayLike, vector: ArrayLike) -> Array:
    """v turned by q, (..., 3): v + 2 w (u x v) + 2 u x (u x v) with q = (w, u)."""
    array, v = np.asarray(q, dtype=np.float64), np.asarray(vector, dtype=np.float64)
    w, u = array[..., :1], array[..., 1:]
    once = 2.0 * np.cross(u, v)
    return np.asarray(v + w * once + np.cross(u, once))


def from_axis_angle(axis: ArrayLike, angle: ArrayLike) -> Array:
    """Rotation by `angle` (...), rad, about `axis` (..., 3) of any length above 0: (..., 4)."""
    direction = np.asarray(axis, dtype=np.float64)
    direction = direction / np.linalg.norm(direction, axis=-1, keepdims=True)
    half = 0.5 * np.asarray(angle, dtype=np.float64)[..., np.newaxis]
    half, direction = np.broadcast_arrays(half, direction)
    return np.concatenate([np.cos(half[..., :1]), np.sin(half) * direction], axis=-1)


def to_matrix(q: ArrayLike) -> Array:
    """Rotation matrix, (..., 3, 3): v_b = R v_a."""
    w, x, y, z = _parts(q)
    rows = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def about_z(angle: ArrayLike) -> Array:
    """Rotation by `angle` (...), rad, about z: (..., 4)."""
    return _joined(_plain(kernels.about_z)(np.asarray(angle, dtype=np.float64)))


def rotation_angle(q: ArrayLike) -> Array:
    """Angle of the whole rotation, (...), rad in [0, pi]."""
    return np.asarray(_plain(kernels.rotation_angle)(_parts(q)))


def twist_z(q: ArrayLike) -> Array:
    """Angle of the part about z, (...), rad in [-pi, pi]: of an error where z is up, the heading."""
    return np.asarray(_plain(kernels.twist_z)(_parts(q)))


def tilt_z(q: ArrayLike) -> Array:
    """Angle by which z is tilted, (...), rad in [0, pi]: of an error where z is up, the inclination."""
    return np.asarray(_plain(kernels.tilt_z)(_parts(q)))


def from_euler_zxy(z: ArrayLike, x: ArrayLike, y: ArrayLike) -> Array:
    """q = Rz(z) Rx(x) Ry(y), rad: flexion, abduction, pronation of a joint; (..., 4)."""
    about_x, about_y = from_axis_angle([1.0, 0.0, 0.0], x), from_axis_angle([0.0, 1.0, 0.0], y)
    return multiply(multiply(about_z(z), about_x), about_y)


def euler_zxy(q: ArrayLike) -> Array:
    """Intrinsic z-x-y Euler angles, (..., 3), rad (doi 10.3390/s19010208, eq. 20-22).

    Flexion about z, abduction about x, pronation about y, in this order; the pole is at abduction
    +-90 deg, where flexion and pronation turn about one axis and only their sum is defined.
    """
    parts = _parts(q)
    angles = (_plain(kernels.euler_z_of_zxy)(parts), _plain(kernels.euler_x_of_zxy)(parts),
              _plain(kernels.euler_y_of_zxy)(parts))
    return np.stack(angles, axis=-1)


def interpolate(times_ns: NDArray[np.int64], q: Array, at_ns: NDArray[np.int64]) -> Array:
    """Orientations q (n, ..., 4) at increasing instants, spherically interpolated at other instants.

    NaN outside the first and the last instant, and where a neighbour is NaN.
    """
    last = times_ns.size - 1
    after = np.clip(np.searchsorted(times_ns, at_ns, side="left"), min(1, last), last)
    before = np.maximum(after - 1, 0)
    span = np.maximum(times_ns[after] - times_ns[before], 1)
    share = ((at_ns - times_ns[before]) / span).reshape((-1,) + (1,) * (q.ndim - 1))
    step = relative(q[before], q[after])
    step = np.where(step[..., :1] < 0.0, -step, step)
    half = np.arctan2(np.linalg.norm(step[..., 1:], axis=-1, keepdims=True), step[..., :1])
    # sin(share half)/sin(half), whose limit at half = 0 is share
    ratio = share * np.sinc(share * half / np.pi) / np.sinc(half / np.pi)
    turned = multiply(q[before], np.concatenate([np.cos(share * half), ratio * step[..., 1:]], axis=-1))
    outside = (at_ns < times_ns[0]) | (at_ns > times_ns[-1])
    turned[outside] = np.nan
    return turned
