"""Filter of a hand's attitude, velocity and position, with gates and a zero-velocity detector."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from estimators.kortier.chain import Gates, length
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
from estimators.kortier.samples import Moment, repeats
from fesloop.compiled import compiled
from fesloop.hand.motion import STANDARD_GRAVITY, UPWARDS
from fesloop.hand.quaternion_kernels import about_z, conjugate

Array = NDArray[np.float64]
SIZE, BIAS, VELOCITY, POSITION = 12, 3, 6, 9
"""Length of the error state, and first indices of its parts after the attitude."""
UNTURNED = (1.0, 0.0, 0.0, 0.0)


class HandWork(NamedTuple):
    """Scratch arrays of the hand's kernels, allocated at each tick.

    Attributes
    ----------
    rotation, jacobian, block: (3, 3): Rh, right Jacobian of a step, a block of a Jacobian.
    transition: (12, 12), F. noise: (12, 3), Jacobian of the error state by the accelerometer's noise.
    product: (12, 12).
    rows, residual: (3, 12) and (3,), Jacobian and residual of a measurement. error, image, gain: (12,).
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
    """Allocate the scratch arrays of the hand's kernels."""
    return HandWork(
        np.zeros((3, 3)), np.zeros((3, 3)), np.zeros((3, 3)), np.zeros((SIZE, SIZE)), np.zeros((SIZE, 3)),
        np.zeros((SIZE, SIZE)), np.zeros((3, SIZE)), np.zeros(3), np.zeros(SIZE), np.zeros(SIZE),
        np.zeros(SIZE))


@compiled
def predict_hand(
    q: Any, bias: Any, motion: Any, covariance: Any, shared: Any, rate: Any, acc: Any,
    gyr_variance: float, acc_variance: float, walk_variance: float, dt: float, work: HandWork,
) -> None:
    """Predict the state and covariance of the hand over `dt` s.

    Parameters
    ----------
    q: (4,), body to earth; bias: (3,), rad/s; motion: (2, 3), velocity m/s and position m.
    covariance: (12, 12); shared: (12, 3), covariance of the error state with the noise of the accelerometer
        sample in use, zero for a new sample.
    rate, acc: (3,), rad/s and m/s^2, constant over the step.
    gyr_variance, acc_variance: their variances.
    walk_variance: variance that the bias gains in this step, (rad/s)^2.
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
    """Replace P by F P F' + F C G' + G C' F' + variance G G', and C = shared by F C + variance G."""
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
    """Fill rows and residuals of a vector known in the earth frame: y - Rh'u = [Rh'u]x dth + noise.

    Parameters
    ----------
    q: (4,); earth: (3,), u; vector: (3,), y, its measurement in the body's frame.
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
    """Fill rows and residuals of a velocity of zero: 0 - vh = dv + noise."""
    work.rows[:] = 0.0
    for i in range(3):
        work.rows[i, VELOCITY + i] = 1.0
        work.residual[i] = -motion[0, i]


@compiled
def correct_hand(
    q: Any, bias: Any, motion: Any, covariance: Any, shared: Any,
    variance: float, shared_variance: float, work: HandWork,
) -> float:
    """Update the filter with the three rows in `work` and correct the state.

    Parameters
    ----------
    variance: of the noise of each row; shared_variance: the part of it that comes from the accelerometer
        sample in use, zero for any other sensor.

    Returns the normalised innovation squared, chi-squared with 3 degrees of freedom.
    """
    error, gain = work.error, work.gain
    error[:] = 0.0
    nis = 0.0
    for r in range(3):
        row = work.rows[r]
        nis += absorb(covariance, error, row, 0, VELOCITY + 3, work.residual[r], variance, work.image, gain)
        for j in range(3):
            noise_covariance = shared_variance if j == r else 0.0
            for c in range(VELOCITY + 3):
                noise_covariance += row[c] * shared[c, j]
            for i in range(SIZE):
                shared[i, j] -= gain[i] * noise_covariance
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
    small while the body is still.

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


FILLED, BEGUN, FIELD_KNOWN, STILL, OLDEST = range(5)


class HandGates(NamedTuple):
    """Parameters of the hand's filter.

    Attributes
    ----------
    motion_sd: sd of the hand's acceleration where the accelerometer gives the vertical, m/s^2.
    still_rate, still_acc: scales of the zero-velocity detector, rad/s and m/s^2.
    still_sd: sd of a velocity taken as zero, m/s.
    unknown_acc_sd: sd of an acceleration whose sample is missing, m/s^2.
    angle_sd, bias_sd: initial sds, rad and rad/s.
    """

    motion_sd: float
    still_rate: float
    still_acc: float
    still_sd: float
    unknown_acc_sd: float
    angle_sd: float
    bias_sd: float


class HandFilter(NamedTuple):
    """State of the filter of one hand or, with a leading axis, of the filters of several.

    Attributes
    ----------
    q, bias, motion, covariance, shared: as in `predict_hand`.
    acc: (2, 3), row 0 the accelerometer sample in use, row 1 (its variance, 0, 0).
    rates, accs: (window, 3), samples of the zero-velocity detector.
    earth: (2, 3), up and the magnetic field.
    flags: (5,), number of samples in the window; whether the filter has begun, the field is known, the hand
        is still; index of the window's oldest sample.
    """

    q: Any
    bias: Any
    motion: Any
    covariance: Any
    shared: Any
    acc: Any
    rates: Any
    accs: Any
    earth: Any
    flags: Any


def new_hands(count: int, window: int) -> HandFilter:
    """Create `count` filters that have not begun, with `window` samples in each zero-velocity detector."""
    return HandFilter(
        np.tile(UNTURNED, (count, 1)), np.zeros((count, 3)), np.zeros((count, 2, 3)),
        np.zeros((count, SIZE, SIZE)), np.zeros((count, SIZE, 3)), np.zeros((count, 2, 3)),
        np.zeros((count, window, 3)), np.zeros((count, window, 3)),
        np.tile([UPWARDS, (0.0, 0.0, 0.0)], (count, 1, 1)), np.zeros((count, 5), dtype=np.int64))


def begin_hands_again(hands: HandFilter, own: HandGates) -> None:
    """Give filters the covariance, biases and velocities of the beginning; attitudes and positions stay."""
    hands.bias[:], hands.motion[:, 0], hands.covariance[:], hands.shared[:] = 0.0, 0.0, 0.0, 0.0
    for first, sd in ((0, own.angle_sd), (BIAS, own.bias_sd), (VELOCITY, own.still_sd)):
        for i in range(first, first + 3):
            hands.covariance[:, i, i] = sd ** 2


@compiled
def track_hands(
    hands: HandFilter, sensors: Any, moment: Moment, elapsed: Any, gates: Gates, own: HandGates
) -> None:
    """Advance the filters of `sensors` (hands,) by a tick; `elapsed` is what Arrivals.note returns."""
    work = new_hand_work()
    for i in range(sensors.size):
        hand = HandFilter(hands.q[i], hands.bias[i], hands.motion[i], hands.covariance[i], hands.shared[i],
                          hands.acc[i], hands.rates[i], hands.accs[i], hands.earth[i], hands.flags[i])
        _track(hand, sensors[i], moment, elapsed, gates, own, work)


@compiled
def _track(
    hand: HandFilter, sensor: int, moment: Moment, elapsed: Any, gates: Gates, own: HandGates, work: HandWork
) -> None:
    rate, dt = moment.rates[sensor], elapsed[0]
    fresh = elapsed[1] > 0.0
    sound = fresh and moment.acc_variance[sensor] < math.inf
    if not hand.flags[BEGUN]:
        if sound:
            _begin(hand, moment.acc[sensor], own)
    elif dt > 0.0:
        predict_hand(hand.q, hand.bias, hand.motion, hand.covariance, hand.shared, rate, hand.acc[0],
                     moment.gyr_variance[sensor], hand.acc[1, 0], gates.walk ** 2 * dt, dt, work)
    if not hand.flags[BEGUN]:
        return
    if fresh:
        hand.shared[:] = 0.0
        hand.acc[1, 0] = own.unknown_acc_sd ** 2
    if sound:
        hand.acc[0] = moment.acc[sensor]
        hand.acc[1, 0] = moment.acc_variance[sensor]
        _read_vertical(hand, rate, repeats(gates.error_time_s, elapsed[1]), gates, own, work)
        _stand_still(hand, rate, own, work)
    if elapsed[2] > 0.0 and moment.mag_variance[sensor] < math.inf:
        _read_field(hand, moment.mag[sensor], moment.mag_variance[sensor], gates, work)


@compiled
def _begin(hand: HandFilter, acc: Any, own: HandGates) -> None:
    """Start a filter at rest: upright by the accelerometer, with heading and position zero by definition."""
    x, y, z = acc[0], acc[1], acc[2]
    size = length(acc)
    # Half a turn about x where the body is upside down, else the smallest rotation of acc onto up.
    if size + z < 1e-9 * size:
        w, a, b, c = 0.0, 1.0, 0.0, 0.0
    else:
        w, a, b, c = size + z, y, -x, 0.0
    scale = 1.0 / math.sqrt(w * w + a * a + b * b)
    hand.q[0], hand.q[1], hand.q[2], hand.q[3] = scale * w, scale * a, scale * b, scale * c
    hand.acc[0] = acc
    for i in range(3):
        hand.covariance[i, i] = own.angle_sd ** 2
        hand.covariance[3 + i, 3 + i] = own.bias_sd ** 2
        hand.covariance[6 + i, 6 + i] = own.still_sd ** 2
    hand.flags[BEGUN] = 1


@compiled
def _read_vertical(
    hand: HandFilter, rate: Any, times: float, gates: Gates, own: HandGates, work: HandWork
) -> None:
    acc = hand.acc[0]
    difference = abs(length(acc) - STANDARD_GRAVITY)
    if difference < gates.acc_difference and length(rate) < gates.rate:
        fill_vector_rows(hand.q, hand.earth[0], acc, work)
        variance = hand.acc[1, 0]
        correct_hand(hand.q, hand.bias, hand.motion, hand.covariance, hand.shared,
                     variance + times * own.motion_sd ** 2, variance, work)


@compiled
def _stand_still(hand: HandFilter, rate: Any, own: HandGates, work: HandWork) -> None:
    window = hand.rates.shape[0]
    oldest = hand.flags[OLDEST]
    hand.rates[oldest] = rate
    hand.accs[oldest] = hand.acc[0]
    hand.flags[OLDEST] = (oldest + 1) % window
    hand.flags[FILLED] = min(window, hand.flags[FILLED] + 1)
    hand.flags[STILL] = 0
    if hand.flags[FILLED] == window and stillness(
            hand.rates, hand.accs, hand.bias, own.still_rate, own.still_acc) < 1.0:
        hand.flags[STILL] = 1
        fill_still_rows(hand.motion, work)
        correct_hand(hand.q, hand.bias, hand.motion, hand.covariance, hand.shared, own.still_sd ** 2, 0.0,
                     work)


@compiled
def _read_field(hand: HandFilter, mag: Any, variance: float, gates: Gates, work: HandWork) -> None:
    """Correct by the magnetic field; the first sample defines it and sets y to magnetic north."""
    if hand.flags[FIELD_KNOWN]:
        known = hand.earth[1]
        if abs(length(mag) - length(known)) < gates.mag_difference:
            fill_vector_rows(hand.q, known, mag, work)
            correct_hand(hand.q, hand.bias, hand.motion, hand.covariance, hand.shared, variance, 0.0,
                         work)
        return
    w, x, y, z = hand.q[0], hand.q[1], hand.q[2], hand.q[3]
    east = ((1.0 - 2.0 * (y * y + z * z)) * mag[0] + 2.0 * (x * y - w * z) * mag[1]
            + 2.0 * (x * z + w * y) * mag[2])
    north = (2.0 * (x * y + w * z) * mag[0] + (1.0 - 2.0 * (x * x + z * z)) * mag[1]
             + 2.0 * (y * z - w * x) * mag[2])
    up = (2.0 * (x * z - w * y) * mag[0] + 2.0 * (y * z + w * x) * mag[1]
          + (1.0 - 2.0 * (x * x + y * y)) * mag[2])
    turn(hand.q, about_z(math.atan2(east, north)), UNTURNED)
    hand.motion[:] = 0.0
    hand.earth[1, 0], hand.earth[1, 1], hand.earth[1, 2] = 0.0, math.hypot(east, north), up
    hand.flags[FIELD_KNOWN] = 1
