"""Vectors and quaternions as tuples of scalars, for the kernels of the joint filters."""

from __future__ import annotations

import math
from typing import Any

from fesloop.compiled import compiled


@compiled
def turn_by(x: float, y: float, z: float) -> Any:
    """Quaternion of a rotation vector."""
    angle = math.sqrt(x * x + y * y + z * z)
    scale = 0.5 if angle < 1e-9 else math.sin(0.5 * angle) / angle
    return math.cos(0.5 * angle), scale * x, scale * y, scale * z


@compiled
def rotated(q: Any, v: Any) -> Any:
    """Rotate v by the unit quaternion q."""
    w, x, y, z = q
    a = 2.0 * (y * v[2] - z * v[1])
    b = 2.0 * (z * v[0] - x * v[2])
    c = 2.0 * (x * v[1] - y * v[0])
    return (v[0] + w * a + y * c - z * b, v[1] + w * b + z * a - x * c, v[2] + w * c + x * b - y * a)


@compiled
def components(row: Any) -> Any:
    """Convert a row of four to a tuple."""
    return row[0], row[1], row[2], row[3]


@compiled
def cross(a: Any, b: Any) -> Any:
    """Vector product a x b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@compiled
def dot(a: Any, b: Any) -> float:
    """Scalar product a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]  # type: ignore[no-any-return]


@compiled
def unit(a: Any) -> Any:
    """Scale a to length 1."""
    length = math.sqrt(dot(a, a))
    return a[0] / length, a[1] / length, a[2] / length


@compiled
def store(q: Any, value: Any) -> None:
    """Write `value`, scaled to length 1, into the row q."""
    length = math.sqrt(value[0] ** 2 + value[1] ** 2 + value[2] ** 2 + value[3] ** 2)
    for i in range(4):
        q[i] = value[i] / length
