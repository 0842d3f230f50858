"""Scratch arrays and measurement rows of the filter of a chain, allocated at each tick."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from estimators.kortier.error_state import fill_matrix, fill_minus_cross
from fesloop.compiled import compiled

Array = NDArray[np.float64]


class Work(NamedTuple):
    """Scratch arrays of a chain's kernels, large enough for n joints.

    Attributes
    ----------
    rotation: (n, 3, 3), Rh of each joint.
    step: (n + 1, 3, 3), E' of each segment.
    jacobian: (n + 1, 3, 3), right Jacobian of each segment's step.
    of_child, of_parent: (n, 3, 3), Jacobians of dth by the rate errors of child and parent.
    product: (n, 3, 3), Rh_0 .. Rh_k.
    rows: (3, size), three rows of a covariance.
    design, residual, variance, span: measurements, one per row: Jacobian, residual, variance of the noise,
        and the range of its nonzero columns (first, one past the last).
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
    """Length of the error state of a chain: 3 per joint and 3 per segment."""
    return 3 * joints + 3 * (joints + 1)


@compiled
def new_work(joints: int) -> Work:
    """Allocate scratch arrays for chains of at most `joints` joints.

    Rows: 3 of accelerations and 3 of constraints per joint, 3 of the magnetic field.
    """
    size, measurements = error_size(joints), 6 * joints + 3
    return Work(
        np.zeros((joints, 3, 3)), np.zeros((joints + 1, 3, 3)), np.zeros((joints + 1, 3, 3)),
        np.zeros((joints, 3, 3)), np.zeros((joints, 3, 3)), np.zeros((joints, 3, 3)), np.zeros((3, size)),
        np.zeros((measurements, 3 * joints)), np.zeros(measurements), np.zeros(measurements),
        np.zeros((measurements, 2), dtype=np.int64), np.zeros(size), np.zeros(size), np.zeros(size))


@compiled
def fill_rotations(q: Any, work: Work) -> None:
    """Write the rotation matrix Rh of each joint."""
    for k in range(q.shape[0]):
        fill_matrix((q[k, 0], q[k, 1], q[k, 2], q[k, 3]), work.rotation[k])


@compiled
def add_accelerations(
    acc: Any, steady: Any, acc_variance: Any, used: Any, count: int, work: Work
) -> int:
    """Add rows of neighbouring accelerometers (eq. 26) from row `count`; return the new count.

    Pair k measures acc_k - Rh_k acc_(k+1) = -Rh_k [acc_(k+1)]x dth_k + noise. The paper puts the sample
    itself into the Jacobian, where its noise counts as information on rotations about the vertical; the
    smoothed sample `steady` replaces it here. Where pair k - 1 is used as well, the two share accelerometer
    k: the estimate of its noise from pair k - 1 is subtracted, with the weight c = variance_k / (variance of
    pair k - 1), which makes the rows independent.

    Parameters
    ----------
    acc, steady: (n + 1, 3), m/s^2; acc_variance: (n + 1,); used: (n,), whether each pair is used.
    """
    coupled = False
    for k in range(used.size):
        if not used[k]:
            coupled = False
            continue
        rows = work.design[count:count + 3]
        rows[:] = 0.0
        x, y, z = acc[k + 1, 0], acc[k + 1, 1], acc[k + 1, 2]
        fill_minus_cross(work.rotation[k], steady[k + 1, 0], steady[k + 1, 1], steady[k + 1, 2],
                         rows[:, 3 * k:3 * k + 3])
        variance = acc_variance[k] + acc_variance[k + 1]
        weight = acc_variance[k] / work.variance[count - 1] if coupled else 0.0
        for i in range(3):
            turned = work.rotation[k, i, 0] * x + work.rotation[k, i, 1] * y + work.rotation[k, i, 2] * z
            work.residual[count + i] = acc[k, i] - turned
            if coupled:
                for m in range(3):
                    share = weight * work.rotation[k - 1, m, i]
                    work.residual[count + i] += share * work.residual[count - 3 + m]
                    for j in range(3 * k):
                        rows[i, j] += share * work.design[count - 3 + m, j]
            work.variance[count + i] = variance - weight * acc_variance[k]
            work.span[count + i, 0] = work.span[count - 3, 0] if coupled else 3 * k
            work.span[count + i, 1] = 3 * k + 3
        count += 3
        coupled = True
    return count


@compiled
def add_field(base: Any, tip: Any, joints: int, variance: float, count: int, work: Work) -> int:
    """Add rows of the first and last segment's magnetometers from row `count`; return the new count.

    Parameters
    ----------
    base, tip: (3,), the field in the frames of the first and of the last segment.
    joints: number of joints between them.
    variance: sum of both noise variances.
    """
    work.product[0] = work.rotation[0]
    for k in range(1, joints):
        for i in range(3):
            for j in range(3):
                work.product[k, i, j] = (
                    work.product[k - 1, i, 0] * work.rotation[k, 0, j]
                    + work.product[k - 1, i, 1] * work.rotation[k, 1, j]
                    + work.product[k - 1, i, 2] * work.rotation[k, 2, j])
    rows = work.design[count:count + 3]
    x, y, z = tip[0], tip[1], tip[2]
    for k in range(joints - 1, -1, -1):
        fill_minus_cross(work.product[k], x, y, z, rows[:, 3 * k:3 * k + 3])
        m = work.rotation[k]
        x, y, z = (m[0, 0] * x + m[0, 1] * y + m[0, 2] * z, m[1, 0] * x + m[1, 1] * y + m[1, 2] * z,
                   m[2, 0] * x + m[2, 1] * y + m[2, 2] * z)
    work.residual[count], work.residual[count + 1] = base[0] - x, base[1] - y
    work.residual[count + 2] = base[2] - z
    for i in range(count, count + 3):
        work.variance[i] = variance
        work.span[i, 0], work.span[i, 1] = 0, 3 * joints
    return count + 3


@compiled
def add_constraints(freedoms: Any, axes: Any, variance: float, count: int, work: Work) -> int:
    """Add rows of joint constraints from row `count`; return the new count.

    f, a, p are the axes of flexion, abduction and pronation, the same in parent and child. A saddle keeps
    the parent's f orthogonal to the child's a (the paper's eq. 29), a hinge also to its p (eq. 32); a fixed
    joint also keeps the parent's a orthogonal to the child's p. An error dth changes u.(R v) = 0 by
    -(R'u x v).dth.

    Parameters
    ----------
    freedoms: (n,), 0 to 3 of each joint; axes: (n, 3, 3), f, a, p.
    variance: of each pseudo-measurement, rad^2.
    """
    for k in range(freedoms.size):
        for forbidden in range(3 - freedoms[k]):
            u, v = axes[k, 1 if forbidden == 2 else 0], axes[k, 1 if forbidden == 0 else 2]
            m = work.rotation[k]
            rx = m[0, 0] * u[0] + m[1, 0] * u[1] + m[2, 0] * u[2]
            ry = m[0, 1] * u[0] + m[1, 1] * u[1] + m[2, 1] * u[2]
            rz = m[0, 2] * u[0] + m[1, 2] * u[1] + m[2, 2] * u[2]
            row = work.design[count]
            row[3 * k] = v[1] * rz - v[2] * ry
            row[3 * k + 1] = v[2] * rx - v[0] * rz
            row[3 * k + 2] = v[0] * ry - v[1] * rx
            work.residual[count] = -(rx * v[0] + ry * v[1] + rz * v[2])
            work.variance[count] = variance
            work.span[count, 0], work.span[count, 1] = 3 * k, 3 * k + 3
            count += 1
    return count
