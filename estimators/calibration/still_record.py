"""What sensors read while they are to be still, as sums from which their mean readings follow."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from estimators.samples.faults import LOST
from fesloop.compiled import compiled

Array = NDArray[np.float64]


class PoseRecord(NamedTuple):
    """Sums over the samples of n sensors in a pose; the first axis of `acc` and `acc_counts` is its halves.

    Attributes
    ----------
    rates, counts: (n, 3) rad/s, (n,).
    squares: (n,), rad^2/s^2, of the rates' sizes.
    acc, acc_counts: (2, n, 3) m/s^2, (2, n).
    mag, mag_counts: (n, 3) T, (n,).
    """

    rates: Array
    counts: Array
    squares: Array
    acc: Array
    acc_counts: Array
    mag: Array
    mag_counts: Array

    def clear(self) -> None:
        """Begin anew."""
        for sums in self:
            sums[:] = 0.0


class Rest(NamedTuple):
    """Mean readings of n sensors in a pose; of a sensor that is not `present`, which gave none, they are 0.

    Attributes
    ----------
    bias: (n, 3), rad/s; acc: (n, 3), m/s^2; mag: (n, 3), T, or None.
    present: (n,).
    """

    bias: Array
    acc: Array
    mag: Array | None
    present: NDArray[np.bool_]


def new_record(sensors: int) -> PoseRecord:
    """Without a sample."""
    return PoseRecord(np.zeros((sensors, 3)), np.zeros(sensors), np.zeros(sensors), np.zeros((2, sensors, 3)),
                      np.zeros((2, sensors)), np.zeros((sensors, 3)), np.zeros(sensors))


@compiled
def add_samples(
    gyr: Array, acc: Array, mag: Array, codes: NDArray[np.uint8], fresh: NDArray[np.bool_], half: int,
    rate_limit: float, record: PoseRecord
) -> int:
    """Add samples (n, 3) to a record; the sensor that turns fastest above `rate_limit` (rad/s), else -1.

    Parameters
    ----------
    codes: (3, n), LOST of gyr, acc and mag. fresh: (3,), which kinds are new.
    half: 0 or 1, of the pose.
    """
    fastest, moving = rate_limit * rate_limit, -1
    for s in range(gyr.shape[0]):
        if fresh[0] and not codes[0, s] & LOST:
            square = gyr[s, 0] ** 2 + gyr[s, 1] ** 2 + gyr[s, 2] ** 2
            if square > fastest:
                fastest, moving = square, s
            record.squares[s] += square
            record.counts[s] += 1.0
            record.rates[s] += gyr[s]
        if fresh[1] and not codes[1, s] & LOST:
            record.acc[half, s] += acc[s]
            record.acc_counts[half, s] += 1.0
        if fresh[2] and not codes[2, s] & LOST:
            record.mag[s] += mag[s]
            record.mag_counts[s] += 1.0
    return moving


def rest_of(record: PoseRecord, magnetometer: bool) -> Rest:
    """Mean readings."""
    present = (record.counts > 0) & (record.acc_counts > 0).all(axis=0)
    if magnetometer:
        present &= record.mag_counts > 0
    counts, acc_counts, mag_counts = (np.where(present, count, 1.0)[:, np.newaxis] for count in (
        record.counts, record.acc_counts.sum(axis=0), record.mag_counts))
    held = present[:, np.newaxis]
    return Rest(held * record.rates / counts, held * record.acc.sum(axis=0) / acc_counts,
                held * record.mag / mag_counts if magnetometer else None, present)
