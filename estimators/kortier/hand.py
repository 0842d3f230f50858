"""The hand filter of Kortier et al. 2014 (doi 10.1186/1743-0003-11-70, eq. 33): kernels of one rigid body.

The body's attitude R turns its coordinates into the earth's (ENU, z up); the error state of 12 is

    (dth, db, dv, dp),    R = Rh (I + [dth]x),    b = bh + db,    v = vh + dv,    p = ph + dp

with gyroscope bias b, velocity v and position p. The accelerometer reads a = R'(dv/dt - g) + noise. It drives
the strapdown integration, and where the body hardly accelerates it shows the vertical as well: the same noise
twice. `shared` (12, 3), the covariance of the error state with the noise of the accelerometer's sample in
use, carries that, also over several steps with one sample.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from estimators.kortier.error_state import (
    absorb,
    add_outer,
    fill_matrix,
    fill_minus_cross,
    fill_right_jacobian,
    from_rotation_vector,
    symmetrise,
    turn,
)
from fesloop.compiled import compiled
from fesloop.hand.motion import STANDARD_GRAVITY
from fesloop.hand.quaternion_kernels import conjugate

Array = NDArray[np.float64]
SIZE, BIAS, VELOCITY, POSITION = 12, 3, 6, 9
"""Length of the error state, and where its parts begin after the attitude."""
UNTURNED = (1.0, 0.0, 0.0, 0.0)


class HandWork(NamedTuple):
    """Scratch of the hand's kernels, made anew at each tick.

    Attributes
    ----------
    rotation, jacobian, block: (3, 3): Rh, right Jacobian of a step, a block of a Jacobian.
    transition: (12, 12), F. noise: (12, 3), how the error state answers to the accelerometer's noise.
    product: (12, 12).
    rows, residual: (3, 12) and (3,), a measurement. error, image, gain: (12,).
    """

    rotation: Array
    jacobian: Array
    block: Array
    transition: Array
    noise: Array
    product: Array
    rows: Array
    residual: Array
    error: Array
    image: Array
    gain: Array


@compiled
def new_hand_work() -> HandWork:
    """Scratch of the hand's kernels."""
    return HandWork(
        np.zeros((3, 3)), np.zeros((3, 3)), np.zeros((3, 3)), np.zeros((SIZE, SIZE)), np.zeros((SIZE, 3)),
        np.zeros((SIZE, SIZE)), np.zeros((3, SIZE)), np.zeros(3), np.zeros(SIZE), np.zeros(SIZE),
        np.zeros(SIZE))


@compiled
def predict_hand(
    q: Any, bias: Any, motion: Any, covariance: Any, shared: Any, rate: Any, acc: Any,
    gyr_variance: float, acc_variance: float, walk_variance: float, dt: float, work: HandWork,
) -> None:
    """Carry the hand over `dt` s.

    Parameters
    ----------
    q: (4,), body to earth; bias: (3,), rad/s; motion: (2, 3), velocity m/s and position m.
    covariance: (12, 12); shared: (12, 3), zero when the accelerometer's sample is a new one.
    rate, acc: (3,), rad/s and m/s^2, constant over the step.
    gyr_variance, acc_variance: of these; walk_variance: (rad/s)^2 that the bias gains in this step.
    """
    fill_matrix((q[0], q[1], q[2], q[3]), work.rotation)
    x, y, z = dt * (rate[0] - bias[0]), dt * (rate[1] - bias[1]), dt * (rate[2] - bias[2])
    after = from_rotation_vector(x, y, z)
    fill_right_jacobian(x, y, z, work.jacobian)
    fill_minus_cross(work.rotation, acc[0], acc[1], acc[2], work.block)
    transition, noise = work.transition, work.noise
    transition[:] = 0.0
    for i in range(SIZE):
        transition[i, i] = 1.0
    fill_matrix(conjugate(after), transition[:3, :3])
    for i in range(3):
        transition[POSITION + i, VELOCITY + i] = dt
        for j in range(3):
            transition[i, BIAS + j] = -dt * work.jacobian[i, j]
            transition[VELOCITY + i, j] = dt * work.block[i, j]
            transition[POSITION + i, j] = 0.5 * dt * dt * work.block[i, j]
            noise[VELOCITY + i, j] = -dt * work.rotation[i, j]
            noise[POSITION + i, j] = -0.5 * dt * dt * work.rotation[i, j]
    for i in range(3):
        earth = work.rotation[i, 0] * acc[0] + work.rotation[i, 1] * acc[1] + work.rotation[i, 2] * acc[2]
        if i == 2:
            earth -= STANDARD_GRAVITY
        motion[1, i] += dt * motion[0, i] + 0.5 * dt * dt * earth
        motion[0, i] += dt * earth
    turn(q, UNTURNED, after)
    _spread(covariance, shared, acc_variance, work)
    add_outer(covariance, 0, work.jacobian, 0, work.jacobian, gyr_variance * dt * dt)
    for i in range(3):
        covariance[BIAS + i, BIAS + i] += walk_variance


@compiled
def _spread(covariance: Any, shared: Any, acc_variance: float, work: HandWork) -> None:
    """P becomes F P F' + F C G' + G C' F' + variance G G', and C = shared becomes F C + variance G."""
    transition, noise, product = work.transition, work.noise, work.product
    product[:] = 0.0
    for i in range(SIZE):
        for m in range(SIZE):
            weight = transition[i, m]
            if weight != 0.0:
                for j in range(SIZE):
                    product[i, j] += weight * covariance[m, j]
    covariance[:] = 0.0
    for i in range(SIZE):
        for m in range(SIZE):
            weight = transition[i, m]
            if weight != 0.0:
                for j in range(SIZE):
                    covariance[j, i] += weight * product[j, m]
    for j in range(3):
        for i in range(SIZE):
            work.image[i] = 0.0
            for m in range(SIZE):
                work.image[i] += transition[i, m] * shared[m, j]
        for i in range(SIZE):
            shared[i, j] = work.image[i] + acc_variance * noise[i, j]
            for m in range(SIZE):
                covariance[i, m] += shared[i, j] * noise[m, j] + noise[i, j] * work.image[m]


@compiled
def fill_vector_rows(q: Any, earth: Any, vector: Any, work: HandWork) -> None:
    """Rows and residuals of a vector known in the earth's frame: y - Rh'u = [Rh'u]x dth + noise.

    Parameters
    ----------
    q: (4,); earth: (3,), u; vector: (3,), y, what the body reads of it.
    """
    fill_matrix(conjugate((q[0], q[1], q[2], q[3])), work.rotation)
    work.rows[:] = 0.0
    for i in range(3):
        work.block[0, i] = (work.rotation[i, 0] * earth[0] + work.rotation[i, 1] * earth[1]
                            + work.rotation[i, 2] * earth[2])
        work.residual[i] = vector[i] - work.block[0, i]
    x, y, z = work.block[0, 0], work.block[0, 1], work.block[0, 2]
    work.rows[0, 1], work.rows[0, 2] = -z, y
    work.rows[1, 0], work.rows[1, 2] = z, -x
    work.rows[2, 0], work.rows[2, 1] = -y, x


@compiled
def fill_still_rows(motion: Any, work: HandWork) -> None:
    """Rows and residuals of a velocity of zero: 0 - vh = dv + noise."""
    work.rows[:] = 0.0
    for i in range(3):
        work.rows[i, VELOCITY + i] = 1.0
        work.residual[i] = -motion[0, i]


@compiled
def correct_hand(
    q: Any, bias: Any, motion: Any, covariance: Any, shared: Any,
    variance: float, shared_variance: float, work: HandWork,
) -> float:
    """Absorb the three rows that stand in the work space and move their errors into the state.

    Parameters
    ----------
    variance: of the noise of each row; shared_variance: the part of it that is the noise of the
        accelerometer's sample in use, zero for any other sensor.

    Returns the normalised innovation squared, chi-squared with 3 degrees of freedom.
    """
    error, gain = work.error, work.gain
    error[:] = 0.0
    nis = 0.0
    for r in range(3):
        row = work.rows[r]
        nis += absorb(covariance, error, row, 0, VELOCITY + 3, work.residual[r], variance, work.image, gain)
        for j in range(3):
            told = shared_variance if j == r else 0.0
            for c in range(VELOCITY + 3):
                told += row[c] * shared[c, j]
            for i in range(SIZE):
                shared[i, j] -= gain[i] * told
    symmetrise(covariance)
    turn(q, UNTURNED, from_rotation_vector(error[0], error[1], error[2]))
    for i in range(3):
        bias[i] += error[BIAS + i]
        motion[0, i] += error[VELOCITY + i]
        motion[1, i] += error[POSITION + i]
    return nis


@compiled
def stillness(rates: Any, accs: Any, bias: Any, gyr_scale: float, acc_scale: float) -> float:
    """Statistic of the zero-velocity detector (Skog et al. 2010, doi 10.1109/TBME.2010.2060723, eq. 21).

    The mean over a window of |rate|^2 / gyr_scale^2 + |acc - g mean/|mean||^2 / acc_scale^2, without unit:
    small where the body stands still.

    Parameters
    ----------
    rates, accs: (window, 3), rad/s and m/s^2; bias: (3,), of the gyroscope.
    """
    window = rates.shape[0]
    mean_x, mean_y, mean_z = 0.0, 0.0, 0.0
    for k in range(window):
        mean_x, mean_y, mean_z = mean_x + accs[k, 0], mean_y + accs[k, 1], mean_z + accs[k, 2]
    length = math.sqrt(mean_x * mean_x + mean_y * mean_y + mean_z * mean_z)
    if length == 0.0:
        return math.inf
    up = STANDARD_GRAVITY / length
    total = 0.0
    for k in range(window):
        for i, mean in enumerate((mean_x, mean_y, mean_z)):
            total += ((rates[k, i] - bias[i]) / gyr_scale) ** 2 + ((accs[k, i] - up * mean) / acc_scale) ** 2
    return float(total / window)
