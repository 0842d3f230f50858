"""Initial pose: gyroscope biases, and the heading of each sensor relative to its neighbour.

For 3 s or more the hand is still, fingers F2 to F5 straight, the thumb straight at a known angle
(Salchow-Hoemmen et al. 2019, doi 10.3390/s19010208, section 2.4.2). The gyroscopes then read their bias.
The difference between the measured and the known relative heading of two neighbouring segments is an error of
the sensors and is removed from then on. An implausible pose is refused, with the names of the sensors;
`pose_evidence` tests whether it is the one that was stated.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from estimators.arrivals import LOST
from estimators.body.body import Body
from fesloop.compiled import compiled
from fesloop.errors import InputError
from fesloop.hand import quaternion
from fesloop.hand.kinematics import relative_orientations
from fesloop.hand.motion import STANDARD_GRAVITY
from fesloop.hand.quaternion_kernels import about_z, conjugate, multiply, twist_z
from fesloop.hand.segments import SegmentTree

Array = NDArray[np.float64]


class PoseRecord(NamedTuple):
    """Sums over the samples of n sensors in a pose; the first axis of `acc` and `acc_counts` is its half.

    Attributes
    ----------
    rates, counts: (n, 3) rad/s, (n,).
    squares: (n,), rad^2/s^2, sums of squared sizes of rates.
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
        """Reset all sums."""
        for sums in self:
            sums[:] = 0.0


class Rest(NamedTuple):
    """Mean readings of n sensors in a pose; those of a sensor that is not `present` are 0.

    Attributes
    ----------
    bias: (n, 3), rad/s; acc: (n, 3), m/s^2; mag: (n, 3), T, or None.
    present: (n,), mask of the sensors with samples.
    """

    bias: Array
    acc: Array
    mag: Array | None
    present: NDArray[np.bool_]


def new_record(sensors: int) -> PoseRecord:
    """Empty record."""
    return PoseRecord(np.zeros((sensors, 3)), np.zeros(sensors), np.zeros(sensors), np.zeros((2, sensors, 3)),
                      np.zeros((2, sensors)), np.zeros((sensors, 3)), np.zeros(sensors))


@compiled
def add_samples(
    gyr: Array, acc: Array, mag: Array, codes: NDArray[np.uint8], fresh: NDArray[np.bool_], half: int,
    rate_limit: float, record: PoseRecord
) -> int:
    """Add samples (n, 3) to a record; return the fastest sensor above `rate_limit` (rad/s), else -1.

    Parameters
    ----------
    codes: (3, n), LOST for gyr, acc and mag.
    fresh: (3,), mask of the new kinds.
    half: half of the pose, 0 or 1.
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
    """Mean readings of a record. Raises InputError without samples."""
    present = (record.counts > 0) & (record.acc_counts > 0).all(axis=0)
    if magnetometer:
        present &= record.mag_counts > 0
    counts, acc_counts, mag_counts = (np.where(present, count, 1.0)[:, np.newaxis] for count in (
        record.counts, record.acc_counts.sum(axis=0), record.mag_counts))
    held = present[:, np.newaxis]
    return Rest(held * record.rates / counts, held * record.acc.sum(axis=0) / acc_counts,
                held * record.mag / mag_counts if magnetometer else None, present)


KEEP_STILL = "keep still in the known pose"
NO_SAMPLE = "no sensor has given a sample"


@dataclass(frozen=True, slots=True, kw_only=True)
class InitialPoseLimits:
    """Limits of a sensor's readings in a plausible initial pose.

    Attributes
    ----------
    rate_deg_s: rate of any sample above which the hand moves (chosen: physiological tremor stays below).
    rate_sd_deg_s: sd of the rates about their mean (chosen: a third of it).
    bias_deg_s: mean rate above which the hand turns slowly (5: usual zero-rate level of MEMS).
    turned_deg: angle between the verticals of the first and of the second half (chosen).
    gravity: difference of the mean acceleration's size from gravity, m/s^2 (chosen: above usual bias and
        scale).
    share: least share of the pose's samples that a sensor must give (chosen).
    """

    rate_deg_s: float = 30.0
    rate_sd_deg_s: float = 10.0
    bias_deg_s: float = 5.0
    turned_deg: float = 5.0
    gravity: float = 0.5
    share: float = 0.8

    def __post_init__(self) -> None:
        for name in self.__slots__:
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0.0):
                raise InputError(f"pose_limits.{name}", f"{value} is not positive", "a finite number above 0")
        if self.share > 1.0:
            raise InputError("pose_limits.share", f"{self.share}", "at most 1")


class Ties(NamedTuple):
    """Neighbour of each sensor, and its relative orientation in the known pose.

    Attributes
    ----------
    neighbours: (n,), number of each sensor's neighbour; -1 for none.
    relative: (n, 4), from the sensor's segment to its neighbour's, in the known pose.
    order: (n,), sensors in an order with each after its neighbour.
    """

    neighbours: NDArray[np.int64]
    relative: Array
    order: NDArray[np.int64]


def known_angles(tree: SegmentTree, angles_deg: Mapping[str, float]) -> Array:
    """Angles (f,), rad, of a pose; freedoms that are not named are 0.

    Raises InputError for unknown names and for angles outside the joint's range.
    """
    angles = np.zeros(len(tree.ranges))
    for name, value in angles_deg.items():
        number = tree.freedom(name)
        low, high = np.degrees(tree.ranges[number])
        if not low <= value <= high:
            raise InputError(f"initial_angles_deg.{name}", f"{value}", f"{low:g} to {high:g} deg")
        angles[number] = math.radians(value)
    return angles


def ties_of(body: Body, angles: Array, present: NDArray[np.bool_]) -> Ties:
    """Ties of each sensor to the next `present` one (n,) towards the root, in a pose (f,), rad."""
    relative = relative_orientations(body.tree, angles)
    neighbours = np.full(len(body.sensed), -1, dtype=np.int64)
    turns = np.tile([1.0, 0.0, 0.0, 0.0], (len(body.sensed), 1))
    for s, segment in enumerate(body.sensed):
        k = int(segment)
        while body.tree.layout[k, 0] >= 0 and neighbours[s] < 0:
            turns[s] = quaternion.multiply(relative[k], turns[s])
            k = int(body.tree.layout[k, 0])
            above = int(body.sensors[k])
            if above >= 0 and present[above]:
                neighbours[s] = above
    return Ties(neighbours, turns, np.argsort(body.sensed, kind="stable"))


def headings(ties: Ties, orientation: Array) -> Array:
    """Rotation of each sensor about the vertical, (n,), rad, that gives the known pose.

    Parameters
    ----------
    orientation: (n, 4), fused orientations, sensor to earth, in the pose; inclinations do not change.
    """
    turns = np.zeros(len(orientation))
    turn_headings(ties.neighbours, ties.relative, ties.order, orientation, turns)
    return turns


@compiled
def turn_headings(
    neighbours: NDArray[np.int64], relative: Array, order: NDArray[np.int64], orientation: Array, turns: Array
) -> None:
    """Fill `turns` (n,), the result of `headings`; the other arrays are those of Ties."""
    for s in order:
        above = neighbours[s]
        if above >= 0:
            q, p, known = orientation[s], orientation[above], relative[s]
            held = multiply(about_z(turns[above]), (p[0], p[1], p[2], p[3]))
            meant = multiply(held, (known[0], known[1], known[2], known[3]))
            turns[s] = twist_z(multiply(meant, conjugate((q[0], q[1], q[2], q[3]))))


def faults(
    record: PoseRecord, rest: Rest, body: Body, limits: InitialPoseLimits, least: int
) -> list[str]:
    """Faults of a pose, a text a sensor; empty for a plausible one.

    Parameters
    ----------
    rest: mean readings of the record.
    least: least number of samples of each sensor.
    """
    if not rest.present.any():
        return [NO_SAMPLE]
    found = []
    for s in range(len(rest.present)):
        why = _fault(record, rest, limits, least, s) if rest.present[s] else _silent(record, s)
        if why:
            found.append(f"{sensor_name(body, s)} {why}")
    return found


def sensor_name(body: Body, sensor: int) -> str:
    """Name of a sensor, such as "sensor 3 (F2m)"."""
    return f"sensor {sensor} ({body.tree.names[body.sensed[sensor]]})"


def _silent(record: PoseRecord, s: int) -> str:
    """A sensor without any sample is left out of the pose; one that gave some, but not all that is needed."""
    some = record.counts[s] + record.acc_counts[:, s].sum() + record.mag_counts[s] > 0
    return "gave too few samples" if some else ""


def _fault(record: PoseRecord, rest: Rest, limits: InitialPoseLimits, least: int, s: int) -> str:
    """Fault of sensor s."""
    size = float(np.linalg.norm(rest.acc[s]))
    bias = math.degrees(float(np.linalg.norm(rest.bias[s])))
    variance = record.squares[s] / record.counts[s] - float(rest.bias[s] @ rest.bias[s])
    sd = math.degrees(math.sqrt(max(variance, 0.0)))
    turned = _between_deg(record.acc[0, s], record.acc[1, s])
    if record.counts[s] < limits.share * least:
        return f"gave {record.counts[s]:.0f} of {least} samples"
    if sd > limits.rate_sd_deg_s:
        return f"moved: its rates vary by {sd:.0f} deg/s"
    if bias > limits.bias_deg_s:
        return f"turned on at {bias:.1f} deg/s"
    if abs(size - STANDARD_GRAVITY) > limits.gravity:
        return f"reads {size:.2f} m/s^2 at rest, gravity is {STANDARD_GRAVITY:.2f}: calibrate it"
    if turned > limits.turned_deg:
        return f"moved: its inclination changed by {turned:.0f} deg"
    return ""


def _between_deg(a: Array, b: Array) -> float:
    return math.degrees(math.atan2(float(np.linalg.norm(np.cross(a, b))), float(a @ b)))


def moved(body: Body, sensor: int, rates: Array) -> str:
    """Text for a sensor that turns at `rates` (3,), rad/s."""
    return f"{sensor_name(body, sensor)} moved: {math.degrees(float(np.linalg.norm(rates))):.0f} deg/s"
