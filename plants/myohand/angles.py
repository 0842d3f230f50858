"""A hand's joint angles, rates and accelerations from how its segments are turned and turn."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from fesloop.compiled import compiled

Array = NDArray[np.float64]


@compiled
def joint_rotations(parents: NDArray[np.int64], axes: Array, rates: Array, accelerations: Array) -> Array:
    """Angles, rates and accelerations (n, 3, 3) of flexion, abduction and pronation between segments.

    `parents` (n,), -1 for the root; `axes` (n, 3, 3), each segment's in the columns, global; `rates` and
    `accelerations` (n, 3), rad/s and rad/s^2, angular, global. Intrinsic about z, x, y
    (doi 10.3390/s19010208, eq. 20-22): R = Rz(a) Rx(b) Ry(c), so that in the parent's frame the child turns
    at w = z a' + Rz x b' + Rz Rx y c', solved for a', b', c', and its derivative for a'', b'', c''.
    The pole is at an abduction of +-90 deg.
    """
    found = np.zeros((parents.size, 3, 3))
    for k in range(parents.size):
        i = parents[k]
        if i < 0:
            continue
        turn = axes[i].T @ axes[k]
        flexion = math.atan2(-turn[0, 1], turn[1, 1])
        abduction = math.asin(min(1.0, max(-1.0, turn[2, 1])))
        pronation = math.atan2(-turn[2, 0], turn[2, 2])
        sf, cf, sa, ca = math.sin(flexion), math.cos(flexion), turn[2, 1], math.cos(abduction)
        w = axes[i].T @ (rates[k] - rates[i])
        about_y = (cf * w[1] - sf * w[0]) / ca
        about_x = cf * w[0] + sf * w[1]
        about_z = w[2] - sa * about_y
        # As seen from the turning parent; then without what the turning of the axes themselves adds.
        past = axes[i].T @ rates[i]
        seen = axes[i].T @ (accelerations[k] - accelerations[i]) - np.cross(past, w)
        x_axis = np.array([cf, sf, 0.0])
        y_axis = np.array([-sf * ca, cf * ca, sa])
        z_axis = np.array([0.0, 0.0, 1.0])
        spin = z_axis * about_z
        seen -= np.cross(spin, x_axis) * about_x + np.cross(spin + x_axis * about_x, y_axis) * about_y
        twist = (cf * seen[1] - sf * seen[0]) / ca
        found[k, 0] = flexion, abduction, pronation
        found[k, 1] = about_z, about_x, about_y
        found[k, 2] = seen[2] - sa * twist, cf * seen[0] + sf * seen[1], twist
    return found
