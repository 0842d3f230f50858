"""Lengths and moment arms of muscles that cross elbow, forearm and wrist, by posture.

Lengths are polynomials of the four joint angles, fitted to the muscle paths of MyoArm (myo-sim 0.2.4, Apache
2.0 licence), which are those of MoBL-ARMS (Saul 2015, doi 10.1080/10255842.2014.916698), in 1,500 postures.
Moment arms are their derivatives, so that force times moment arm conserves energy.
"""

from __future__ import annotations

import csv
from functools import cache
from importlib.resources import files
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
JOINTS = ("elbow_flexion", "forearm_pronation", "wrist_flexion", "wrist_radial_deviation")
"""Joints by their positive direction. Angles are 0 with the elbow straight, the forearm neutral, and the hand
in line with it."""
MIDDLE_RAD = np.deg2rad([75.0, 0.0, 0.0, 0.0])
HALF_RANGE_RAD = np.deg2rad([60.0, 80.0, 45.0, 25.0])
"""The polynomials' variables are angles less the first over the second; they are fitted to elbow flexion of
10 to 130 deg, 80 deg of pronation and supination, 45 of wrist flexion and extension, and radial deviation of
-10 to 25 deg."""


class MusclePaths(NamedTuple):
    """Polynomials of muscle-tendon lengths.

    Attributes
    ----------
    muscles: names (m,).
    exponents: (terms, 4), of each joint's variable.
    coefficients: (terms, m), m.
    """

    muscles: tuple[str, ...]
    exponents: NDArray[np.int64]
    coefficients: Array

    def lengths(self, angles: Array) -> Array:
        """Lengths (n, m), m, at angles (n, 4), rad, of `JOINTS`."""
        scaled = (angles - MIDDLE_RAD) / HALF_RANGE_RAD
        return np.asarray(np.prod(scaled[:, np.newaxis] ** self.exponents, axis=2) @ self.coefficients)

    def moment_arms(self, angles: Array) -> Array:
        """Moment arms (n, m, 4), m, at angles (n, 4), rad: positive where tension increases the angle."""
        scaled = (angles - MIDDLE_RAD) / HALF_RANGE_RAD
        arms = []
        for joint in range(len(JOINTS)):
            lowered = np.maximum(self.exponents - np.eye(len(JOINTS), dtype=int)[joint], 0)
            slopes = np.prod(scaled[:, np.newaxis] ** lowered, axis=2) * self.exponents[:, joint]
            arms.append(-slopes @ self.coefficients / HALF_RANGE_RAD[joint])
        return np.stack(arms, axis=2)


@cache
def muscle_paths() -> MusclePaths:
    """Read the polynomials from `muscle_lengths.csv`, which has mm."""
    text = (files(__package__) / "muscle_lengths.csv").read_text("utf-8")
    heading, *rows = csv.reader(text.splitlines())
    table = np.array(rows, dtype=float)
    joints = len(JOINTS)
    return MusclePaths(tuple(heading[joints:]), table[:, :joints].astype(np.int64), 1e-3 * table[:, joints:])
