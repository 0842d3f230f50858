"""A hand that moves by a script and wears inertial sensors with their errors, in chunks of any length.

The motion is exact (sums of sinusoids of a time that stands still in rests, and the chain's own recursion);
so an hour costs no more memory than a chunk of it. There are no magnetometers: the trackers that wear this
hand read none, so that a disturbed field, permanent or not, changes nothing.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.signal import cont2discrete, lfilter

from fesloop.hand import quaternion
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.kinematics import joint_angles, relative_orientations, segment_poses
from fesloop.hand.motion import root_motion, sensed, sensor_points
from fesloop.hand.segments import AXES, Segment, SegmentTree
from fesloop.hand.skeleton import dorsal_points, hand_tree


@dataclass(frozen=True, kw_only=True)
class Worn:
    """What is wrong with the sensors and with what the tracker knows of the joints; sd each.

    mounting_deg, axes_deg: of each sensor on its segment and of each joint's axes, about each axis (S19
    names 5 to 10 deg, doi 10.3390/s19010208, section 4).
    gyr_noise, acc_noise: of a sample, rad/s, m/s^2 (doi 10.1186/1743-0003-11-70, Table 1).
    bias_deg_s, acc_bias: constant over the run (chosen: as left by a calibration days ago).
    instability_deg_s, instability_s, walk: of the gyroscope's bias: a Gauss-Markov process (chosen: 10
    deg/h, of the kind of the MPU-9250), and its walk, rad/s after a second (Table 1).
    tissue_rad_s, tissue_damping: of the skin that carries a sensor: second order, its inertia lags behind
    the bone's angular acceleration (chosen: it wobbles by 1 to 2 deg in these motions).
    """

    mounting_deg: float = 5.0
    axes_deg: float = 5.0
    gyr_noise: float = 5e-4
    acc_noise: float = 4e-2
    bias_deg_s: float = 0.3
    acc_bias: float = 0.05
    instability_deg_s: float = 10.0 / 3600.0
    instability_s: float = 300.0
    walk: float = 1e-6
    tissue_rad_s: float = 25.0
    tissue_damping: float = 0.4


EXACT = Worn(mounting_deg=0.0, axes_deg=0.0, gyr_noise=0.0, acc_noise=0.0, bias_deg_s=0.0, acc_bias=0.0,
             instability_deg_s=0.0, walk=0.0, tissue_rad_s=np.inf)


BEGINS_S = 4.0
"""Until then the hand rests in its first pose, s (S19 keeps an initial pose for 3 s or more)."""


class Script:
    """Motion that stops smoothly: rest, 50 s of motion, 10 s of rest, again and again, and one long rest.

    Every freedom swings about the middle of its range by `reach` of half of it at most (sums of three
    sinusoids of 0.1 to 0.7 Hz: below 2 Hz as in S19); the forearm turns by 0.5 rad at most about each
    axis and moves by 10 cm.
    """

    ramp_s = 1.0

    def __init__(self, seed, ranges, long_rest=None, reach=0.7, rest=(50.0, 60.0), hours=1.1):
        rng = np.random.default_rng(seed)
        starts = np.arange(0.0, 3600.0 * hours, rest[1])
        rests = [(s + rest[0], s + rest[1]) for s in starts]
        rests = [(-2.0, BEGINS_S), *rests]
        if long_rest:
            kept = [(a, b) for a, b in rests if b < long_rest[0] - 3.0 or a > long_rest[1] + 3.0]
            rests = [*kept, long_rest]
        self.rests = np.array(rests)
        low, high = ranges.T
        self.middle = np.concatenate([np.zeros(6), 0.5 * (low + high)])
        size = np.concatenate([[0.5] * 3, [0.1] * 3, 0.5 * reach * (high - low)])
        count = len(size)
        shares = rng.uniform(0.3, 1.0, (3, count))
        self.amplitude = size * shares / shares.sum(axis=0)
        self.circular = 2 * np.pi * rng.uniform(0.1, 0.7, (3, count))
        self.circular[:, :6] *= 0.6
        self.phase = rng.uniform(0, 2 * np.pi, (3, count))

    def pace(self, times):
        """Warped time, its rate (0 in rests) and that rate's rate, (n,) each."""
        since = times[:, None] - (self.rests[:, 0] - self.ramp_s)
        until = times[:, None] - self.rests[:, 1]
        down, up = (np.clip(part / self.ramp_s, 0.0, 1.0) for part in (since, until))
        ramp = self.ramp_s
        lost = ramp * (_risen(down) - _risen(up)) + np.maximum(since - ramp, 0.0)
        lost -= np.maximum(until - ramp, 0.0)
        rate = 1.0 - (_rise(down) - _rise(up)).sum(axis=1)
        change = -(_slope(down) - _slope(up)).sum(axis=1) / ramp
        return times - lost.sum(axis=1), rate, change

    def __call__(self, times):
        """(value, rate, acceleration) of forearm turns (3), forearm place (3) and freedoms, (3, n, count)."""
        tau, rate, change = (part[:, None] for part in self.pace(times))
        value, first, second = self.middle + 0.0 * tau, 0.0, 0.0
        for a, w, p in zip(self.amplitude, self.circular, self.phase, strict=True):
            sine, cosine = np.sin(w * tau + p), np.cos(w * tau + p)
            value, first, second = value + a * sine, first + a * w * cosine, second - a * w * w * sine
        return np.stack([value, first * rate, second * rate ** 2 + first * change])


def _rise(u):
    return u * u * (3.0 - 2.0 * u)


def _risen(u):
    """Integral of _rise from 0."""
    return u ** 3 - 0.5 * u ** 4


def _slope(u):
    return 6.0 * u * (1.0 - u)


class WornHand:
    """A hand with its errors drawn, 17 sensors; `chunk` must be called over adjoining spans of time."""

    def __init__(self, seed, worn=Worn(), long_rest=None, rate=100):
        self.rng, self.worn, self.rate = np.random.default_rng(seed), worn, rate
        size = HandSize()
        self.nominal = hand_tree(size)
        self.tree = self._tilted(self.nominal)
        forearm = Segment(name="forearm", parent="earth", joint="ball")
        self.world = SegmentTree((Segment(name="earth"), forearm, *self.tree.segments[1:]))
        self.points = sensor_points(self.world, self.nominal.names, dorsal_points(size))
        self.script = Script(seed + 1000, self.nominal.ranges, long_rest)
        vector = np.radians(worn.mounting_deg) * self.rng.normal(size=(17, 3)) + 1e-15
        self.mounting = quaternion.from_axis_angle(vector, np.linalg.norm(vector, axis=1))
        self.bias = np.radians(worn.bias_deg_s) * self.rng.normal(size=(17, 3))
        self.acc_bias = worn.acc_bias * self.rng.normal(size=(17, 3))
        self.wander = np.radians(worn.instability_deg_s) * self.rng.normal(size=(17, 3))
        self.walked = np.zeros((17, 3))
        self.lag = None
        self.tips = [self.nominal.index(f"F{finger}d") for finger in range(1, 6)]

    def _tilted(self, tree):
        """The tree with each joint's axes turned by a small rotation of its own."""
        segments = []
        for segment in tree.segments:
            vector = np.radians(self.worn.axes_deg) * self.rng.normal(size=3) + 1e-15
            turn = quaternion.from_axis_angle(vector, np.linalg.norm(vector))
            count = {"fixed": 0, "hinge": 1, "saddle": 2, "ball": 0}[segment.joint]
            axes = quaternion.rotate(turn, np.array(AXES[:count]).reshape(-1, 3))
            segments.append(replace(segment, axes=tuple(map(tuple, axes.tolist()))) if count else segment)
        return SegmentTree(tuple(segments))

    def chunk(self, first, count):
        """gyr and acc (count, 17, 3), true angles (count, 23) and tips (count, 5, 3) from sample `first` on.

        Angles are about the axes as they are without tilt; tips in the frame of the forearm (WCS).
        """
        times = (first + np.arange(count)) / self.rate
        motion = self.script(times)
        joints = np.concatenate([motion[:, :, :3], motion[:, :, 6:]], axis=2)
        root = root_motion(acceleration=motion[2, :, 3:6])
        samples = sensed(self.world, self.points, *joints, root=root)
        gyr, acc = samples.gyr.copy(), samples.acc.copy()
        if np.isfinite(self.worn.tissue_rad_s):
            self._wobble(gyr, acc)
        turned = quaternion.conjugate(self.mounting)
        gyr, acc = quaternion.rotate(turned, gyr), quaternion.rotate(turned, acc)
        gyr += self._bias_over(count) + self.worn.gyr_noise * self.rng.normal(size=gyr.shape)
        acc += self.acc_bias + self.worn.acc_noise * self.rng.normal(size=acc.shape)
        relative = relative_orientations(self.tree, motion[0, :, 6:])
        tips = segment_poses(self.tree, motion[0, :, 6:]).position[:, self.tips]
        angles = joint_angles(self.nominal, relative)
        return np.ascontiguousarray(gyr), np.ascontiguousarray(acc), angles, tips

    def _bias_over(self, count):
        """(count, 17, 3), rad/s."""
        worn, shape = self.worn, (count, 17, 3)
        kept = np.exp(-1.0 / (self.rate * worn.instability_s))
        kicks = np.radians(worn.instability_deg_s) * np.sqrt(1.0 - kept ** 2) * self.rng.normal(size=shape)
        wander, _ = lfilter([1.0], [1.0, -kept], kicks, axis=0, zi=kept * self.wander[None])
        walk = self.walked + np.cumsum(worn.walk / np.sqrt(self.rate) * self.rng.normal(size=shape), axis=0)
        self.wander, self.walked = wander[-1], walk[-1]
        return self.bias + wander + walk

    def _wobble(self, gyr, acc):
        """Turn what the bone feels into what the skin above it feels, in place."""
        w, damping = self.worn.tissue_rad_s, self.worn.tissue_damping
        # Relative angle of skin to bone over the bone's rate: x'' + 2 d w x' + w^2 x = -rate'.
        outputs = ([-1.0, 0.0], [-1.0, 0.0, 0.0])
        states = []
        filtered = []
        for number, top in enumerate(outputs):
            numerator, denominator, _ = cont2discrete((top, [1.0, 2 * damping * w, w * w]), 1.0 / self.rate,
                                                      method="bilinear")
            numerator = numerator.ravel()
            start = np.zeros((2, *gyr.shape[1:])) if self.lag is None else self.lag[number]
            out, state = lfilter(numerator, denominator, gyr, axis=0, zi=start)
            filtered.append(out)
            states.append(state)
        self.lag = states
        vector, rate = filtered
        back = quaternion.from_axis_angle(-vector + 1e-15, np.linalg.norm(vector, axis=-1) + 1e-15)
        gyr[:] = quaternion.rotate(back, gyr) + rate
        acc[:] = quaternion.rotate(back, acc)
