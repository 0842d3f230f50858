"""A hand in motion and what ideal sensors on it read, in closed form."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fesloop.hand import quaternion
from fesloop.hand.kinematics import segment_poses
from fesloop.hand.motion import UPWARDS, root_motion, sensed, sensor_points

FIELD = np.array([0.0, 20e-6, -40e-6])
"""Earth's, ENU, T: northwards and down."""


class HandMotion(NamedTuple):
    """Angles (t, d), fingertips (t, 5, 3) in the root's frame, samples (t, n, 3), orientation (t, n, 4)."""

    angles: np.ndarray
    tips: np.ndarray
    gyr: np.ndarray
    acc: np.ndarray
    mag: np.ndarray
    orientation: np.ndarray


def moving_hand(
    tree, rate, duration_s, seed, still_s=3.5, base=None, start=None, names=None, share=0.8, inertia=True
):
    """A hand whose joints swing through `share` of their ranges from `start` (d,) on, `base` at rest.

    With `inertia` left out, accelerometers feel gravity only, as in motion that is slow without end. Sensors
    sit at the segments' own origins. Rates are means over the step before each sample, as a gyroscope that
    integrates gives them, so that a strapdown integration is exact but for turning axes.
    """
    rng = np.random.default_rng(seed)
    count, freedoms = round(duration_s * rate), len(tree.ranges)
    times = np.arange(count) / rate
    start = np.zeros(freedoms) if start is None else start
    base = quaternion.normalized(rng.normal(size=4)) if base is None else base
    goal = tree.ranges[:, 0] + (0.5 + share * rng.uniform(-0.5, 0.5, freedoms)) * np.ptp(tree.ranges, axis=1)
    w = 2 * np.pi * rng.uniform(0.1, 0.4, freedoms)
    phase = w * np.maximum(times - still_s, 0.0)[:, np.newaxis]
    moving = (times > still_s)[:, np.newaxis]
    angles = start + 0.5 * (goal - start) * (1 - np.cos(phase))
    rates = 0.5 * (goal - start) * w * np.sin(phase) * moving
    accelerations = 0.5 * (goal - start) * w * w * np.cos(phase) * moving
    names = tree.names if names is None else names
    points = sensor_points(tree, names, np.zeros((len(names), 3)))
    acc = sensed(tree, points, angles, rates, accelerations, root_motion(base)).acc
    poses = segment_poses(tree, angles)
    orientation = quaternion.multiply(base, poses.orientation)[:, points.segments]
    if not inertia:
        acc = quaternion.rotate(quaternion.conjugate(orientation), UPWARDS)
    turn = quaternion.relative(orientation[:-1], orientation[1:])
    turn = np.where(turn[..., :1] < 0.0, -turn, turn)
    half = np.linalg.norm(turn[..., 1:], axis=-1, keepdims=True)
    gyr = np.zeros((count, len(names), 3))
    gyr[1:] = rate * turn[..., 1:] * 2.0 / np.sinc(np.arcsin(np.clip(half, 0.0, 1.0)) / np.pi)
    parents = set(tree.layout[:, 0].tolist())
    tips = [k for k in range(len(tree.names)) if k not in parents]
    mag = quaternion.rotate(quaternion.conjugate(orientation), FIELD)
    return HandMotion(angles, poses.position[:, tips], gyr, acc, mag, orientation)
