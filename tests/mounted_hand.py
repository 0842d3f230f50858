"""A kinematic hand that lies flat and then flexes, felt by sensors mounted anyhow."""

from __future__ import annotations

import functools

import numpy as np

from fesloop.hand import motion, quaternion
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.skeleton import dorsal_points, hand_tree

RATE = 100
NAMES = hand_tree(HandSize()).names[1:]
BENT = 1.2
"""Flexion of every joint at the end, rad."""
FLAT = {"left": quaternion.from_axis_angle([0.0, 1.0, 0.0], -np.pi / 2),
        "right": quaternion.from_axis_angle([0.0, 1.0, 0.0], np.pi / 2)}
"""Hand's frame to the global one (z up) while the back of the hand is upwards."""


@functools.cache
def flat_then_bent(side, tilt_deg=0.0, swerve_deg=0.0, flat_s=3.0, bent_s=4.0):
    """(flat, bent): Samples (m, 16, 3) of sensors that sit exactly as their segments do.

    The table leans about the fingers' direction by `tilt_deg`; the whole hand turns about an axis
    `swerve_deg` off the flexion axis while it flexes, towards the direction of the fingers.
    """
    size = HandSize(side=side)
    tree = hand_tree(size)
    sensors = motion.sensor_points(tree, tree.names[1:], dorsal_points(size)[1:])
    tilt = quaternion.from_axis_angle([0.0, 1.0, 0.0], np.radians(tilt_deg))
    root = motion.root_motion(quaternion.multiply(FLAT[side], tilt))
    still = np.zeros((round(flat_s * RATE), len(tree.ranges)))
    flat = motion.sensed(tree, sensors, still, still, still, root)
    if swerve_deg:
        return flat, _swerving(flat, np.radians(swerve_deg), bent_s)
    time = np.arange(round(bent_s * RATE)) / RATE
    angle, rate, acceleration = minimum_jerk(time / bent_s)
    bend = np.array([name.endswith("flexion") for name in tree.freedoms]) * BENT
    motions = (np.outer(part, bend) for part in (angle, rate / bent_s, acceleration / bent_s**2))
    return flat, motion.sensed(tree, sensors, *motions, root)


def _swerving(flat, off, bent_s):
    """Every segment turns about one axis that lies `off` the flexion axis."""
    time = np.arange(round(bent_s * RATE)) / RATE
    axis = np.array([0.0, np.sin(off), np.cos(off)])
    rate = np.multiply.outer(BENT / bent_s * minimum_jerk(time / bent_s)[1], axis)
    gyr = np.repeat(rate[:, np.newaxis], flat.gyr.shape[1], axis=1)
    return motion.Samples(gyr, np.zeros_like(gyr))


def minimum_jerk(share):
    """Position, velocity, acceleration of a minimum-jerk move from 0 to 1 at shares of its duration."""
    s = share
    return (10 * s**3 - 15 * s**4 + 6 * s**5, 30 * s**2 - 60 * s**3 + 30 * s**4,
            60 * s - 180 * s**2 + 120 * s**3)


def mounted(samples, rotations):
    """The same as felt by sensors mounted by `rotations` (n, 4), sensor to segment."""
    turn = quaternion.conjugate(rotations)
    return motion.Samples(quaternion.rotate(turn, samples.gyr), quaternion.rotate(turn, samples.acc))
