"""Compiled steps that error-state Kalman filters of rotations share.

A rotation R is estimated as Rh, and its error is the small rotation vector dth in R = Rh (I + [dth]x); the
filter's state holds such errors. Measurements are processed one scalar row after the other, which needs no
inverse: P becomes P - a a' with a = P h' / sqrt(h P h' + variance). The subtracted term is symmetric to the
last bit. Its round-off is relative to P before the update and must not exceed the noise: the sd of the noise
must stay above 1e-7 times the sd of the measured quantity.
"""

from __future__ import annotations

import math
from typing import Any

from fesloop.compiled import compiled
from fesloop.hand.quaternion_kernels import Components, multiply


@compiled
def from_rotation_vector(x: float, y: float, z: float) -> Components:
    """Quaternion of the rotation by |v| rad about v = (x, y, z)."""
    angle = math.sqrt(x * x + y * y + z * z)
    # sin(angle/2) / angle by its series where the quotient would lose digits
    scale = 0.5 - angle * angle / 48.0 if angle < 1e-4 else math.sin(0.5 * angle) / angle
    return math.cos(0.5 * angle), scale * x, scale * y, scale * z


@compiled
def turn(q: Any, before: Components, after: Components) -> None:
    """Replace q (4,) by the product before q after, scaled to unit length."""
    w, x, y, z = multiply(multiply(before, (q[0], q[1], q[2], q[3])), after)
    scale = 1.0 / math.sqrt(w * w + x * x + y * y + z * z)
    q[0], q[1], q[2], q[3] = scale * w, scale * x, scale * y, scale * z


@compiled
def fill_matrix(q: Components, matrix: Any) -> None:
    """Write the rotation matrix of q into `matrix` (3, 3)."""
    w, x, y, z = q
    matrix[0, 0] = 1.0 - 2.0 * (y * y + z * z)
    matrix[0, 1] = 2.0 * (x * y - w * z)
    matrix[0, 2] = 2.0 * (x * z + w * y)
    matrix[1, 0] = 2.0 * (x * y + w * z)
    matrix[1, 1] = 1.0 - 2.0 * (x * x + z * z)
    matrix[1, 2] = 2.0 * (y * z - w * x)
    matrix[2, 0] = 2.0 * (x * z - w * y)
    matrix[2, 1] = 2.0 * (y * z + w * x)
    matrix[2, 2] = 1.0 - 2.0 * (x * x + y * y)


@compiled
def fill_right_jacobian(x: float, y: float, z: float, matrix: Any) -> None:
    """Write the right Jacobian J (3, 3): Exp(v + d) = Exp(v) Exp(J d) to first order in d, v = (x, y, z).

    J = I - (1 - cos a)/a^2 [v]x + (a - sin a)/a^3 [v]x^2, a = |v| (Sola et al., arXiv 1812.01537, eq. 143).
    """
    square = x * x + y * y + z * z
    if square < 1e-6:
        first, second = 0.5 - square / 24.0, 1.0 / 6.0 - square / 120.0
    else:
        angle = math.sqrt(square)
        first, second = (1.0 - math.cos(angle)) / square, (angle - math.sin(angle)) / (angle * square)
    matrix[0, 0] = 1.0 - second * (y * y + z * z)
    matrix[1, 1] = 1.0 - second * (x * x + z * z)
    matrix[2, 2] = 1.0 - second * (x * x + y * y)
    matrix[0, 1], matrix[1, 0] = first * z + second * x * y, -first * z + second * x * y
    matrix[0, 2], matrix[2, 0] = -first * y + second * x * z, first * y + second * x * z
    matrix[1, 2], matrix[2, 1] = first * x + second * y * z, -first * x + second * y * z


@compiled
def fill_minus_cross(matrix: Any, x: float, y: float, z: float, out: Any) -> None:
    """Write -M [v]x into `out` (3, 3): the Jacobian of M v by an error of the rotation M."""
    for i in range(3):
        a, b, c = matrix[i, 0], matrix[i, 1], matrix[i, 2]
        out[i, 0] = c * y - b * z
        out[i, 1] = a * z - c * x
        out[i, 2] = b * x - a * y


@compiled
def add_outer(covariance: Any, row: int, a: Any, col: int, b: Any, variance: float) -> None:
    """Add variance a b' at (row, col) of the covariance, a and b (3, 3)."""
    for i in range(3):
        for j in range(3):
            covariance[row + i, col + j] += variance * (
                a[i, 0] * b[j, 0] + a[i, 1] * b[j, 1] + a[i, 2] * b[j, 2])


@compiled
def absorb(
    covariance: Any, error: Any, row: Any, first: int, stop: int,
    residual: float, variance: float, image: Any, gain: Any,
) -> float:
    """Update the error's mean and covariance with one scalar: residual = row error + noise.

    Parameters
    ----------
    covariance, error: (n, n), symmetric, and (n,); updated in place.
    row: row of the Jacobian; only columns `first` up to `stop` are read, the others are zero.
    variance: of the noise, which is independent of all earlier measurements.
    image, gain: scratch, (n,) or longer.

    Returns the squared innovation divided by its variance.
    """
    n = covariance.shape[0]
    for j in range(n):
        image[j] = 0.0
    for c in range(first, stop):
        weight = row[c]
        for j in range(n):
            image[j] += weight * covariance[c, j]
    predicted, spread = 0.0, variance
    for c in range(first, stop):
        predicted += row[c] * error[c]
        spread += row[c] * image[c]
    innovation, scale = residual - predicted, 1.0 / math.sqrt(spread)
    for i in range(n):
        image[i] *= scale
        gain[i] = scale * image[i]
        error[i] += gain[i] * innovation
    for i in range(n):
        weight = image[i]
        for j in range(n):
            covariance[i, j] -= weight * image[j]
    return innovation * innovation / spread


@compiled
def symmetrise(covariance: Any) -> None:
    """Replace the covariance by its symmetric part."""
    n = covariance.shape[0]
    for i in range(n):
        for j in range(i):
            mean = 0.5 * (covariance[i, j] + covariance[j, i])
            covariance[i, j] = mean
            covariance[j, i] = mean
