"""Sums over the flat pose and the flexion of a wearer, and their plausibility.

Sums are enough for both poses, so that they can be gathered sample by sample while a loop runs. A sample
that is not finite, or an acceleration of exactly zero, is none (`estimators.arrivals`).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError, InputErrors
from fesloop.hand import quaternion
from fesloop.hand.motion import STANDARD_GRAVITY


class SensorFault(NamedTuple):
    """Fault of a sensor: its number, the finding, the allowed values, the remedy."""

    sensor: int
    found: str
    allowed: str
    remedy: str


def sensor_name(sensor: int, names: Sequence[str]) -> str:
    """Name of a sensor in messages: its segment, or its number."""
    return names[sensor] if names else f"sensor {sensor}"


def fault_errors(faults: Iterable[SensorFault], names: Sequence[str]) -> dict[int, InputError]:
    """First fault of every sensor with one, ordered by its number."""
    first: dict[int, InputError] = {}
    for sensor, found, allowed, remedy in faults:
        if sensor not in first:
            first[sensor] = InputError(sensor_name(sensor, names), found, allowed, remedy)
    return dict(sorted(first.items()))


def raise_faults(faults: Iterable[SensorFault], names: Sequence[str]) -> None:
    """Raise InputErrors, a line a sensor, unless there are no faults."""
    errors = fault_errors(faults, names)
    if errors:
        raise InputErrors(list(errors.values()))


Array = NDArray[np.float64]
Counts = NDArray[np.int64]


@dataclass(frozen=True, slots=True, kw_only=True)
class PoseLimits:
    """Limits beyond which a calibration pose is refused.

    Attributes
    ----------
    least_samples: least number of samples of each sensor in each pose (chosen: half a second at 100 Hz).
    still_deg_s: rate above which the flat hand has moved (chosen: above a gyroscope's bias and the tremor of
        a resting hand).
    spread_m_s2: rms deviation of the flat hand's accelerations from their mean above which it has moved
        (chosen: 2 deg of gravity's direction, eight times the noise of doi 10.1186/1743-0003-11-70, Table 1).
    gravity_m_s2: greatest difference of the mean acceleration from gravity (chosen: 5 %, the offset and scale
        error of a sensor of this kind).
    placement_deg: greatest angle of a sensor's vertical, and of its rotation, from the stated mounting
        (chosen: three times the 5-10 deg of misalignment in doi 10.3390/s19010208).
    least_flexion_deg: least rotation of each sensor in the flexion (chosen: a third of a finger's reach).
    wobble_deg: limit of the flexion's rotation about other axes (chosen).
    skew_deg: greatest error of the angle between vertical and flexion axis (chosen:
        each axis is then within the 5-10 deg of misalignment that a calibration is to remove).

    Raises InputError for a limit that is not positive.
    """

    least_samples: int = 50
    still_deg_s: float = 10.0
    spread_m_s2: float = 0.35
    gravity_m_s2: float = 0.5
    placement_deg: float = 30.0
    least_flexion_deg: float = 30.0
    wobble_deg: float = 20.0
    skew_deg: float = 15.0

    def __post_init__(self) -> None:
        for limit in fields(self):
            value = getattr(self, limit.name)
            if not (math.isfinite(value) and value > 0.0):
                raise InputError(f"limits.{limit.name}", f"{value} is not positive",
                                 "a finite number above 0")


USUAL_LIMITS = PoseLimits()


@dataclass(slots=True, eq=False)
class FlatPose:
    """Sums over the flat hand, of n sensors.

    Attributes
    ----------
    offered: numbers of samples of gyroscopes and of accelerometers, sound or not.
    gyr_count, acc_count: (n,), numbers of sound ones.
    gyr_sum, acc_sum: (n, 3), rad/s and m/s^2.
    acc_square: (n,), m^2/s^4.
    fastest: (n,), largest rate, rad/s.
    """

    offered: list[int]
    gyr_count: Counts
    acc_count: Counts
    gyr_sum: Array
    acc_sum: Array
    acc_square: Array
    fastest: Array

    @classmethod
    def of(cls, sensors: int) -> FlatPose:
        """Empty sums."""
        return cls([0, 0], np.zeros(sensors, np.int64), np.zeros(sensors, np.int64), np.zeros((sensors, 3)),
                   np.zeros((sensors, 3)), np.zeros(sensors), np.zeros(sensors))

    def take_gyr(self, gyr: Array) -> None:
        """Add rates (m, n, 3), rad/s."""
        sound, rates = _sound(gyr, zero_is_lost=False)
        self.offered[0] += len(gyr)
        self.gyr_count += sound.sum(axis=0)
        self.gyr_sum += rates.sum(axis=0)
        np.maximum(self.fastest, np.linalg.norm(rates, axis=2).max(axis=0, initial=0.0), out=self.fastest)

    def take_acc(self, acc: Array) -> None:
        """Add specific forces (m, n, 3), m/s^2."""
        sound, forces = _sound(acc, zero_is_lost=True)
        self.offered[1] += len(acc)
        self.acc_count += sound.sum(axis=0)
        self.acc_sum += forces.sum(axis=0)
        self.acc_square += np.sum(forces * forces, axis=(0, 2))

    def force(self) -> Array:
        """Mean specific force, (n, 3), m/s^2; zero without samples."""
        return np.asarray(self.acc_sum / np.maximum(self.acc_count, 1)[:, np.newaxis])

    def vertical(self) -> Array:
        """Direction upwards in the sensors' frames, (n, 3); NaN where unknown."""
        mean = self.force()
        with np.errstate(invalid="ignore"):
            return np.asarray(mean / np.linalg.norm(mean, axis=1, keepdims=True))

    def bias(self) -> Array:
        """Mean rate of the hand at rest, (n, 3), rad/s."""
        return np.asarray(self.gyr_sum / np.maximum(self.gyr_count, 1)[:, np.newaxis])

    def spread(self) -> Array:
        """Rms deviation of the accelerations from their mean, (n,), m/s^2."""
        mean = self.force()
        variance = self.acc_square / np.maximum(self.acc_count, 1) - np.sum(mean * mean, axis=1)
        return np.asarray(np.sqrt(np.maximum(variance, 0.0)))


@dataclass(slots=True, eq=False)
class Flexion:
    """Sums over the flexion, of n sensors.

    Attributes
    ----------
    offered: number of samples, sound or not.
    count: (n,), numbers of sound ones.
    products: (n, 3, 3), sums of products of rates, rad^2/s^2.
    turned: (n, 3), integral of the rates, rad: for a single axis the angle about it.
    furthest: (n, 3), `turned` at its greatest length.
    """

    offered: int
    count: Counts
    products: Array
    turned: Array
    furthest: Array

    @classmethod
    def of(cls, sensors: int) -> Flexion:
        """Empty sums."""
        return cls(0, np.zeros(sensors, np.int64), np.zeros((sensors, 3, 3)), np.zeros((sensors, 3)),
                   np.zeros((sensors, 3)))

    def take(self, rates: Array, elapsed_s: Array) -> None:
        """Add rates (m, n, 3), rad/s, without bias, each `elapsed_s` (m,) after the one before."""
        if not len(rates):
            return
        sound, sure = _sound(rates, zero_is_lost=False)
        self.offered += len(rates)
        self.count += sound.sum(axis=0)
        self.products += np.einsum("mni,mnj->nij", sure, sure)
        path = self.turned + np.cumsum(sure * elapsed_s[:, np.newaxis, np.newaxis], axis=0)
        lengths = np.linalg.norm(path, axis=2)
        latest, sensors = lengths.argmax(axis=0), np.arange(len(self.count))
        further = lengths[latest, sensors] > np.linalg.norm(self.furthest, axis=1)
        self.furthest[further] = path[latest, sensors][further]
        self.turned[:] = path[-1]

    def axis(self) -> Array:
        """Main axes of rotation, unit vectors (n, 3), about which the furthest turn is positive."""
        axes = np.linalg.eigh(self.products)[1][:, :, 2]
        backwards = np.sum(axes * self.furthest, axis=1) < 0.0
        return np.asarray(np.where(backwards[:, np.newaxis], -axes, axes))

    def wobble_deg(self) -> Array:
        """Angle (n,), deg, whose tangent is the rms rate about all other axes over that about this one."""
        energy = np.maximum(np.linalg.eigvalsh(self.products), 0.0)
        return np.asarray(np.degrees(np.arctan2(np.sqrt(energy[:, 0] + energy[:, 1]), np.sqrt(energy[:, 2]))))

    def reach_deg(self) -> Array:
        """Furthest turn, (n,), deg."""
        return np.asarray(np.degrees(np.linalg.norm(self.furthest, axis=1)))


def _sound(samples: Array, zero_is_lost: bool) -> tuple[NDArray[np.bool_], Array]:
    """Mask (m, n) of the sound samples (m, n, 3), and the samples with zeros for the others."""
    sound = np.asarray(np.isfinite(samples).all(axis=2))
    if zero_is_lost:
        sound &= samples.any(axis=2)
    return sound, np.where(sound[:, :, np.newaxis], samples, 0.0)


def _count_faults(pose: str, kind: str, offered: int, count: Counts, limits: PoseLimits) -> list[SensorFault]:
    allowed = f"{limits.least_samples} or more"
    if offered < limits.least_samples:
        return [SensorFault(i, f"the {pose} was too short: {offered} {kind} samples", allowed,
                            "hold it longer") for i in range(count.size)]
    return [SensorFault(int(i), f"lost in the {pose}: {count[i]} sound {kind} samples of {offered}", allowed,
                        "check its cable and repeat the pose")
            for i in np.flatnonzero(count < limits.least_samples)]


def flat_faults(
    flat: FlatPose, limits: PoseLimits, stated: Array | None, verticals: Array
) -> list[SensorFault]:
    """Faults of the flat pose of each sensor.

    Parameters
    ----------
    stated: (n, 4), stated mounting, or None.
    verticals: (n, 3), direction upwards in the segments' frames.
    """
    faults = _count_faults("flat pose", "gyroscope", flat.offered[0], flat.gyr_count, limits)
    faults += _count_faults("flat pose", "accelerometer", flat.offered[1], flat.acc_count, limits)
    rate, spread, size = np.degrees(flat.fastest), flat.spread(), np.linalg.norm(flat.force(), axis=1)
    faults += [SensorFault(int(i), f"moved in the flat pose: {rate[i]:.1f} deg/s, accelerations spread by "
                                   f"{spread[i]:.2f} m/s^2",
                           f"{limits.still_deg_s:g} deg/s, {limits.spread_m_s2:g} m/s^2",
                           "rest the hand on a table and hold it still")
               for i in np.flatnonzero((rate > limits.still_deg_s) | (spread > limits.spread_m_s2))]
    faults += [SensorFault(int(i), f"the flat pose does not agree with gravity: {size[i]:.2f} m/s^2",
                           f"{STANDARD_GRAVITY:.2f} within {limits.gravity_m_s2:g} m/s^2",
                           "check the accelerometer's scale and unit")
               for i in np.flatnonzero(np.abs(size - STANDARD_GRAVITY) > limits.gravity_m_s2)]
    if stated is not None:
        up = quaternion.rotate(stated, flat.vertical())
        tilt = np.degrees(np.arctan2(np.linalg.norm(np.cross(up, verticals), axis=1),
                                     np.sum(up * verticals, axis=1)))
        faults += [SensorFault(int(i), f"upwards is {tilt[i]:.0f} deg from the stated mounting's",
                               f"within {limits.placement_deg:g} deg",
                               "lay the whole hand flat, or correct `rotations`")
                   for i in np.flatnonzero(tilt > limits.placement_deg)]
    return faults


def flexion_faults(flexion: Flexion, limits: PoseLimits) -> list[SensorFault]:
    """Faults of the flexion of each sensor."""
    faults = _count_faults("flexion", "gyroscope", flexion.offered, flexion.count, limits)
    reach, wobble = flexion.reach_deg(), flexion.wobble_deg()
    faults += [SensorFault(int(i), f"turned by {reach[i]:.0f} deg in the flexion",
                           f"{limits.least_flexion_deg:g} deg or more", "flex every joint, and further")
               for i in np.flatnonzero(reach < limits.least_flexion_deg)]
    faults += [SensorFault(int(i), f"the flexion was about several axes: {wobble[i]:.0f} deg off one",
                           f"within {limits.wobble_deg:g} deg",
                           "flex without abduction or rotation, the forearm at rest")
               for i in np.flatnonzero(wobble > limits.wobble_deg)]
    return faults
