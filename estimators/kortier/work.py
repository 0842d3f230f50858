"""What the kernels of a chain of segments work on: scratch that is made anew at each tick."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from estimators.kortier.error_state import fill_matrix
from fesloop.compiled import compiled

Array = NDArray[np.float64]


class Work(NamedTuple):
    """Scratch of a chain's kernels, large enough for n joints.

    Attributes
    ----------
    rotation: (n, 3, 3), Rh of each joint.
    step: (n + 1, 3, 3), E' of each segment.
    jacobian: (n + 1, 3, 3), right Jacobian of each segment's step.
    of_child, of_parent: (n, 3, 3), how dth answers to the child's and the parent's rate error.
    product: (n, 3, 3), Rh_0 .. Rh_k.
    rows: (3, size), some rows of a covariance.
    design, residual, variance, span: measurements, one a row: Jacobian, residual, variance of the noise, and
        the first column that is not zero with the one past the last.
    error, image, gain: (size,).
    """

    rotation: Array
    step: Array
    jacobian: Array
    of_child: Array
    of_parent: Array
    product: Array
    rows: Array
    design: Array
    residual: Array
    variance: Array
    span: NDArray[np.int64]
    error: Array
    image: Array
    gain: Array


@compiled
def error_size(joints: int) -> int:
    """Length of the error state of a chain: 3 a joint and 3 a segment."""
    return 3 * joints + 3 * (joints + 1)


@compiled
def new_work(joints: int) -> Work:
    """Scratch for chains of so many joints at most: 3 rows a joint of accelerations, 3 of its constraints."""
    size, measurements = error_size(joints), 6 * joints + 3
    return Work(
        np.zeros((joints, 3, 3)), np.zeros((joints + 1, 3, 3)), np.zeros((joints + 1, 3, 3)),
        np.zeros((joints, 3, 3)), np.zeros((joints, 3, 3)), np.zeros((joints, 3, 3)), np.zeros((3, size)),
        np.zeros((measurements, 3 * joints)), np.zeros(measurements), np.zeros(measurements),
        np.zeros((measurements, 2), dtype=np.int64), np.zeros(size), np.zeros(size), np.zeros(size))


@compiled
def fill_rotations(q: Any, work: Work) -> None:
    """Write Rh of each joint."""
    for k in range(q.shape[0]):
        fill_matrix((q[k, 0], q[k, 1], q[k, 2], q[k, 3]), work.rotation[k])
