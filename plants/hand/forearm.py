"""A forearm turned from outside: a heavy body on three hinges at the wrist's centre, driven stiffly."""

from __future__ import annotations

import math

import mujoco
import numpy as np
from numpy.typing import NDArray

from fesloop.errors import RunError
from fesloop.hand import quaternion
from fesloop.hand.segments import AXES, MOTIONS

Array = NDArray[np.float64]
PALM_DOWN = {"left": (math.sqrt(0.5), 0.0, -math.sqrt(0.5), 0.0),
             "right": (0.0, math.sqrt(0.5), 0.0, -math.sqrt(0.5))}
"""By side, (w, x, y, z) of the forearm to the global frame (ENU), palm down, fingers to the north."""
INERTIA, MASS = 0.1, 1.5
"""kg m^2 about each axis, and kg: chosen so heavy that what the hand does hardly moves it."""
QUICKNESS_RAD_S = 50.0
"""Chosen: the drive is critically damped and there within .1 s."""


def add_forearm_drive(spec: mujoco.MjSpec) -> None:
    """Hinges z, x, y (intrinsic) named `arm_flexion` and on, and a position drive on each.

    Call it before bodies hang on the forearm's joints and after the muscles' actuators.
    """
    stiffness, damping = INERTIA * QUICKNESS_RAD_S**2, 2.0 * INERTIA * QUICKNESS_RAD_S
    body = spec.body("forearm")
    body.mass, body.inertia, body.explicitinertial = MASS, [INERTIA] * 3, True
    for motion, axis in zip(MOTIONS, AXES, strict=True):
        body.add_joint(name=f"arm_{motion}", type=mujoco.mjtJoint.mjJNT_HINGE, axis=axis)
        drive = spec.add_actuator(name=f"arm_{motion}", target=f"arm_{motion}",
                                  trntype=mujoco.mjtTrn.mjTRN_JOINT)
        drive.gaintype, drive.biastype = mujoco.mjtGain.mjGAIN_FIXED, mujoco.mjtBias.mjBIAS_AFFINE
        drive.gainprm[0] = stiffness
        drive.biasprm[:3] = [0.0, -stiffness, -damping]


def drive_angles(start: Array, wanted: Array, before: Array) -> Array:
    """Angles (3,), rad, of the hinges that turn the forearm from `start` to `wanted`, (4,), to global.

    Of the whole turns that an angle leaves open, those next to the angles `before`. The middle hinge reaches
    90 deg to either side: there the other two are not apart. Raises RunError where `wanted` has length 0.
    """
    if not np.linalg.norm(wanted) > 0.0:
        raise RunError(f"hand.forearm: {wanted} is no orientation; a quaternion (w, x, y, z) is expected")
    turn = quaternion.to_matrix(quaternion.normalized(quaternion.relative(start, wanted)))
    angles = np.array([math.atan2(-turn[0, 1], turn[1, 1]), math.asin(min(1.0, max(-1.0, turn[2, 1]))),
                       math.atan2(-turn[2, 0], turn[2, 2])])
    return before + np.remainder(angles - before + math.pi, 2.0 * math.pi) - math.pi
