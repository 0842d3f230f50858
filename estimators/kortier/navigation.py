"""One tick of a hand's filter: its start, the gates of its measurements, and standing still."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from estimators.kortier.chain import Gates, length
from estimators.kortier.error_state import turn
from estimators.kortier.hand import (
    SIZE,
    HandWork,
    correct_hand,
    fill_still_rows,
    fill_vector_rows,
    new_hand_work,
    predict_hand,
    stillness,
)
from estimators.kortier.samples import Moment, repeats
from fesloop.compiled import compiled
from fesloop.hand.motion import STANDARD_GRAVITY, UPWARDS
from fesloop.hand.quaternion_kernels import about_z

UNTURNED = (1.0, 0.0, 0.0, 0.0)
FILLED, BEGUN, FIELD_KNOWN, STILL, OLDEST = range(5)


class HandGates(NamedTuple):
    """What the hand's filter supposes.

    Attributes
    ----------
    motion_sd: of the hand's acceleration where the vertical is read, m/s^2.
    still_rate, still_acc: scales of the zero-velocity detector, rad/s and m/s^2.
    still_sd: of a velocity taken for zero, m/s.
    unknown_acc_sd: of an acceleration whose sample is missing, m/s^2.
    angle_sd, bias_sd: at the start, rad and rad/s.
    """

    motion_sd: float
    still_rate: float
    still_acc: float
    still_sd: float
    unknown_acc_sd: float
    angle_sd: float
    bias_sd: float


class HandFilter(NamedTuple):
    """Filter of one hand; or, with an axis before the others, filters of several.

    Attributes
    ----------
    q, bias, motion, covariance, shared: as of `kortier.hand`.
    acc: (2, 3), row 0 the accelerometer's sample in use, row 1 (its variance, 0, 0).
    rates, accs: (window, 3), of the zero-velocity detector. earth: (2, 3), up and the magnetic field.
    flags: (5,), samples in the window; whether the filter has begun, the field is known, the hand stands;
        where the window's oldest sample is.
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
    """Filters that have not begun, with so many samples in each zero-velocity detector."""
    return HandFilter(
        np.tile(UNTURNED, (count, 1)), np.zeros((count, 3)), np.zeros((count, 2, 3)),
        np.zeros((count, SIZE, SIZE)), np.zeros((count, SIZE, 3)), np.zeros((count, 2, 3)),
        np.zeros((count, window, 3)), np.zeros((count, window, 3)),
        np.tile([UPWARDS, (0.0, 0.0, 0.0)], (count, 1, 1)), np.zeros((count, 5), dtype=np.int64))


@compiled
def track_hands(
    hands: HandFilter, sensors: Any, moment: Moment, elapsed: Any, gates: Gates, own: HandGates
) -> None:
    """One tick of the filters of `sensors` (hands,); `elapsed` as Arrivals.note gives it."""
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
    """Upright by the accelerometer, heading zero, at rest at the origin: this defines them."""
    x, y, z = acc[0], acc[1], acc[2]
    size = length(acc)
    # The half turn about x where the body is upside down, else the shortest rotation of acc onto up.
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
    """The first sample defines the field and turns the heading to it: y to magnetic north."""
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
