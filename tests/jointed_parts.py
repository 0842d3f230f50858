"""Jointed segments in motion, as their sensors see them: rates and forces by differencing exact poses."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from estimators.body.joint_constraints import Joint
from fesloop.hand import quaternion

GRAVITY = np.array([0.0, 0.0, 9.81])
# InvenSense MPU-9250 data sheet: 0.01 deg/s/sqrt(Hz), 300 ug/sqrt(Hz); at 100 Hz, bandwidth 50 Hz.
GYR_NOISE, ACC_NOISE = np.radians(0.01) * np.sqrt(50), 300e-6 * 9.81 * np.sqrt(50)


@dataclass(frozen=True)
class Errors:
    """Sd of what is not ideal: mounting and axes (rad, each axis, of two segments together), bias, noise."""

    mounting: float = 0.0
    axes: float = 0.0
    bias: float = 0.0
    walk: float = 0.0
    noise: float = 1.0


def waves(rng, count, size, hertz=(0.1, 0.7)):
    """Amplitudes, circular frequencies, phases of random smooth motions of rms `size` each, (count, 4)."""
    amplitude = rng.normal(size=(count, 4)) * size / np.sqrt(2)
    return amplitude, 2 * np.pi * rng.uniform(*hertz, (count, 4)), rng.uniform(0, 2 * np.pi, (count, 4))


def along(wave, times):
    """(times, count)."""
    amplitude, circular, phase = wave
    return sum(amplitude[:, i] * np.sin(np.multiply.outer(times, circular[:, i]) + phase[:, i])
               for i in range(4))


def small(rng, sd):
    """A random small rotation, (4,)."""
    vector = sd * rng.normal(size=3)
    return quaternion.from_axis_angle(vector + 1e-12, np.linalg.norm(vector))


def across(rng, sd, axis):
    """A random small rotation across an axis, which it tilts; none where there is no axis."""
    if axis is None:
        return np.array([1.0, 0.0, 0.0, 0.0])
    vector = np.cross(axis, sd * rng.normal(size=3))
    return quaternion.from_axis_angle(vector + 1e-12, np.linalg.norm(vector))


class Jointed:
    """A random motion of a tree of joints: hand-sized, about 1 rad rms at the joints and 3 m/s^2 at the root.

    `lively` scales the motion; `rest_s` makes it stop smoothly that often.
    """

    def __init__(self, joints, seed, errors=Errors(), lively=1.0, rest_s=None, lever=0.02):
        self.rng = np.random.default_rng(seed)
        self.joints, self.errors, self.lively, self.rest_s = joints, errors, lively, rest_s
        rng, self.sensors = self.rng, 1 + max(joint.child for joint in joints)
        self.position = waves(rng, 3, 0.15 * lively)
        self.turning = waves(rng, 3, 0.8 * lively)
        self.start = quaternion.normalized(rng.normal(size=4))
        self.angle_waves = [waves(rng, joint.angles, 0.35 * lively) for joint in joints]
        self.middle = [rng.uniform(-0.5, 0.5, joint.angles) for joint in joints]
        self.levers = rng.normal(size=(len(joints), 2, 3)) * lever
        half = errors.mounting / np.sqrt(2)
        self.mounting = [small(rng, half) for _ in range(self.sensors)]
        self.tilts = [[across(rng, errors.axes / np.sqrt(2), axis if joint.kind != "ball" else None)
                       for axis in joint.axes] for joint in joints]

    def angles(self, times):
        """True joint angles, (times, angles)."""
        warped = times if self.rest_s is None else (
            times + self.rest_s / (2 * np.pi) * np.sin(2 * np.pi * times / self.rest_s))
        return np.hstack([middle + along(wave, warped)
                          for middle, wave in zip(self.middle, self.angle_waves, strict=True)])

    def poses(self, times):
        """Orientation (times, n, 4) and position (times, n, 3) of the sensors' places, mounting left out."""
        warped = times if self.rest_s is None else (
            times + self.rest_s / (2 * np.pi) * np.sin(2 * np.pi * times / self.rest_s))
        q = np.empty((len(times), self.sensors, 4))
        p = np.zeros((len(times), self.sensors, 3))
        euler = along(self.turning, warped)
        q[:, 0] = quaternion.multiply(quaternion.from_euler_zxy(*euler.T), self.start)
        p[:, 0] = along(self.position, warped)
        first, angles = 0, self.angles(times)
        for joint, tilt, lever in zip(self.joints, self.tilts, self.levers, strict=True):
            a = angles[:, first:first + joint.angles].T
            first += joint.angles
            parent, child = joint.axes
            if joint.kind == "ball":
                turns = quaternion.from_euler_zxy(*a)
            else:
                turns = quaternion.from_axis_angle(parent, a[0])
            if joint.kind == "saddle":
                turns = quaternion.multiply(turns, quaternion.from_axis_angle(child, a[1]))
            turns = quaternion.multiply(quaternion.multiply(tilt[0], turns), tilt[1])
            q[:, joint.child] = quaternion.multiply(q[:, joint.parent], turns)
            p[:, joint.child] = (p[:, joint.parent] - quaternion.rotate(q[:, joint.parent], lever[0])
                                 + quaternion.rotate(q[:, joint.child], lever[1]))
        return q, p

    def samples(self, times):
        """gyr and acc, (times, n, 3), with every error."""
        step, errors, rng = 1e-3, self.errors, self.rng
        (q0, p0), (q, p1), (q2, p2) = (self.poses(times + offset) for offset in (-step, 0.0, step))
        turned = quaternion.relative(q0, q2)
        turned *= np.sign(turned[..., :1])
        gyr = turned[..., 1:] / step  # 2 sin(angle/2) over 2 step, right to the third order of 1e-3 rad
        acc = quaternion.rotate(quaternion.conjugate(q), (p0 - 2 * p1 + p2) / step ** 2 + GRAVITY)
        for i, mounting in enumerate(self.mounting):
            for kind in (gyr, acc):
                kind[:, i] = quaternion.rotate(quaternion.conjugate(mounting), kind[:, i])
        gyr += errors.bias * rng.normal(size=(1, self.sensors, 3))
        gyr += errors.walk * np.sqrt(times[1] - times[0]) * np.cumsum(rng.normal(size=gyr.shape), axis=0)
        gyr += errors.noise * GYR_NOISE * rng.normal(size=gyr.shape)
        acc += errors.noise * ACC_NOISE * rng.normal(size=gyr.shape)
        return np.ascontiguousarray(gyr), np.ascontiguousarray(acc)


def away(estimate, true):
    """Difference of angles, wrapped, rad."""
    return np.angle(np.exp(1j * (estimate - true)))


def moving_hinge(seed, times, **options):
    """Samples of a hinge in random motion, its second sensor mounted anyhow, its true axes (2, 3), angle."""
    rng = np.random.default_rng(seed)
    axis, mounting = rng.normal(size=3), quaternion.normalized(rng.normal(size=4))
    axis /= np.linalg.norm(axis)
    joint = Joint(parent=0, child=1, kind="hinge", parent_axis=tuple(axis), child_axis=tuple(axis))
    motion = Jointed((joint,), seed, **options)
    gyr, acc = motion.samples(times)
    for kind in (gyr, acc):
        kind[:, 1] = quaternion.rotate(mounting, kind[:, 1])
    return gyr, acc, np.stack([axis, quaternion.rotate(mounting, axis)]), motion.angles(times)[:, 0]
