"""The finger filter of Kortier et al. 2014 (doi 10.1186/1743-0003-11-70): kernels of one chain of segments.

A chain of n joints joins n + 1 segments, each with a gyroscope and an accelerometer (hand, proximal, middle
and distal segment: n = 3 and an error state of 21). Joint k joins segments k (its parent) and k + 1 (its
child); R_k turns the child's coordinates into the parent's. The error state is

    (dth_0 .. dth_(n-1), db_0 .. db_n),    R_k = Rh_k (I + [dth_k]x),    b = bh + db

The paper's equations 21 and 30 to 32 are misprinted; those used here are derived anew. With w = y - bh the
corrected rates, E = Exp(w dt) and J the right Jacobian of Exp, over one step of constant rates

    Rh_k+  = E_k' Rh_k E_(k+1)
    dth_k+ = E_(k+1)' dth_k - dt J_(k+1) (db_(k+1) + noise) + dt Rh_k+' J_k (db_k + noise)

Neighbouring joints share a gyroscope, so their process noise is correlated; neighbouring pairs of
accelerometers share one, so theirs is (estimators.kortier.rows): both are modelled.
"""

from __future__ import annotations

from typing import Any

from estimators.kortier.error_state import (
    absorb,
    add_outer,
    fill_matrix,
    fill_right_jacobian,
    from_rotation_vector,
    turn,
)
from estimators.kortier.work import Work, fill_rotations
from fesloop.compiled import compiled
from fesloop.hand.quaternion_kernels import conjugate

UNTURNED = (1.0, 0.0, 0.0, 0.0)


@compiled
def predict(
    q: Any, bias: Any, covariance: Any, rates: Any, gyr_variance: Any, walk_variance: float, dt: float,
    work: Work,
) -> None:
    """Carry a chain over `dt` s.

    Parameters
    ----------
    q: (n, 4), child to parent of each joint; bias: (n + 1, 3), rad/s; covariance of the error state.
    rates: (n + 1, 3), rad/s, what the gyroscopes read on average over the step.
    gyr_variance: (n + 1,), of that reading.
    walk_variance: (rad/s)^2 that a bias gains in this step.
    """
    joints = q.shape[0]
    before = UNTURNED
    for s in range(joints + 1):
        x, y = dt * (rates[s, 0] - bias[s, 0]), dt * (rates[s, 1] - bias[s, 1])
        z = dt * (rates[s, 2] - bias[s, 2])
        after = from_rotation_vector(x, y, z)
        fill_matrix(conjugate(after), work.step[s])
        fill_right_jacobian(x, y, z, work.jacobian[s])
        if s > 0:
            turn(q[s - 1], conjugate(before), after)
        before = after
    fill_rotations(q, work)
    for k in range(joints):
        for i in range(3):
            for j in range(3):
                work.of_child[k, i, j] = -dt * work.jacobian[k + 1, i, j]
                work.of_parent[k, i, j] = dt * (
                    work.rotation[k, 0, i] * work.jacobian[k, 0, j]
                    + work.rotation[k, 1, i] * work.jacobian[k, 1, j]
                    + work.rotation[k, 2, i] * work.jacobian[k, 2, j])
    _transform(covariance, joints, work)
    for s in range(joints + 1):
        variance = gyr_variance[s]
        if s > 0:
            add_outer(covariance, 3 * s - 3, work.of_child[s - 1], 3 * s - 3, work.of_child[s - 1], variance)
        if s < joints:
            add_outer(covariance, 3 * s, work.of_parent[s], 3 * s, work.of_parent[s], variance)
        if 0 < s < joints:
            add_outer(covariance, 3 * s - 3, work.of_child[s - 1], 3 * s, work.of_parent[s], variance)
            add_outer(covariance, 3 * s, work.of_parent[s], 3 * s - 3, work.of_child[s - 1], variance)
    for i in range(3 * joints, covariance.shape[0]):
        covariance[i, i] += walk_variance


@compiled
def _transform(covariance: Any, joints: int, work: Work) -> None:
    """F P F': biases stay, each dth depends on itself and on the biases of its two segments."""
    size, turns = covariance.shape[0], 3 * joints
    for k in range(joints):
        at, parent, child = 3 * k, turns + 3 * k, turns + 3 * k + 3
        for i in range(3):
            row = work.rows[i]
            for j in range(size):
                row[j] = 0.0
            for m in range(3):
                a, b, c = work.step[k + 1, i, m], work.of_parent[k, i, m], work.of_child[k, i, m]
                for j in range(size):
                    row[j] += (a * covariance[at + m, j] + b * covariance[parent + m, j]
                               + c * covariance[child + m, j])
        for i in range(3):
            for j in range(size):
                covariance[at + i, j] = work.rows[i, j]
    for j in range(turns):
        row = covariance[j]
        # The lower triangle only, and the biases' rows from the joints': the rest is their mirror image.
        for k in range(j // 3 + 1):
            at, parent, child = 3 * k, turns + 3 * k, turns + 3 * k + 3
            for i in range(3):
                total = 0.0
                for m in range(3):
                    total += (work.step[k + 1, i, m] * row[at + m] + work.of_parent[k, i, m] * row[parent + m]
                              + work.of_child[k, i, m] * row[child + m])
                work.image[i] = total
            for i in range(3):
                row[at + i] = work.image[i]
        for k in range(j):
            covariance[k, j] = row[k]
        for b in range(turns, size):
            covariance[b, j] = row[b]


@compiled
def correct(q: Any, bias: Any, covariance: Any, count: int, work: Work) -> float:
    """Absorb the first `count` measurement rows and move their errors into the state (eq. 12-15).

    Returns the normalised innovation squared, chi-squared with `count` degrees of freedom.
    """
    joints = q.shape[0]
    work.error[:] = 0.0
    nis = 0.0
    for m in range(count):
        nis += absorb(covariance, work.error, work.design[m], work.span[m, 0], work.span[m, 1],
                      work.residual[m], work.variance[m], work.image, work.gain)
    error = work.error
    for k in range(joints):
        turn(q[k], UNTURNED, from_rotation_vector(error[3 * k], error[3 * k + 1], error[3 * k + 2]))
    for s in range(joints + 1):
        for i in range(3):
            bias[s, i] += error[3 * joints + 3 * s + i]
    return nis
