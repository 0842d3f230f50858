"""Equations of the index finger: three phalanges as a planar chain, four muscles, one linear system.

Conventions: joints MCP, PIP, DIP, positive in flexion; muscles FDP, FDS, EDC, INT.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
JOINTS = ("mcp", "pip", "dip")
MUSCLES = ("fdp", "fds", "edc", "int")
OUTPUTS = {"angles": slice(0, 3), "rates": slice(3, 6),
           "accelerations": slice(6, 9), "activation": slice(9, 13)}
"""Rows of the stacked output y by port, in rad, rad/s, rad/s^2, 1."""

INDEX_LENGTHS_MM = (46.6, 27.2, 18.4)
"""Lengths of the proximal, middle, distal phalanx of the index finger: .245, .143, .097 of a hand 190 mm long
(proportions of Buchholz 1992 as usually quoted; the hand length is chosen)."""


@dataclass(frozen=True, slots=True, eq=False)
class FingerEquations:
    """Complete equations of the finger: x' = a x + b v(t - delay), y = c x + offset.

    x (14,), zero at the start of a trial: activation of the four muscles (4), its time derivative (4),
    joint angles less their rest (3), joint rates (3). v (4,): recruited fraction of each muscle. y (13,):
    angles (3), rates (3), accelerations (3) and activation (4), in the rows of `OUTPUTS`.

    Attributes
    ----------
    a, b, c: (14, 14), (14, 4), (13, 14); time in s.
    offset: (13,), y at rest.
    delay_ns: pure delay between recruitment and activation.
    threshold_ma, spread, chronaxie_us: v_i = Phi(ln(I_eff / threshold_i) / spread_i), with the normal
        distribution function Phi and I_eff = I / (1 + chronaxie / pulse width) in mA; 0 if the current or the
        width is 0 or less. Empty tuples for linear recruitment.
    full_scale_us: linear recruitment: v_i = pulse width / full scale, unlimited, for any current; 0 for
        lognormal recruitment.
    """

    a: Array
    b: Array
    c: Array
    offset: Array
    delay_ns: int
    threshold_ma: tuple[float, ...]
    spread: tuple[float, ...]
    chronaxie_us: float
    full_scale_us: float


def chain_mass_matrix(lengths: Array, radii: Array, density: float, angles: Array) -> Array:
    """Mass matrix of three cylinders hinged end to end in a plane, (3, 3), kg m^2.

    `lengths`, `radii` in m, `density` in kg/m^3, relative joint `angles` in rad. From the velocities of
    the centres of mass: M = sum of m J'J + I w'w over the segments.
    """
    masses = density * math.pi * radii**2 * lengths
    inertias = masses * (3.0 * radii**2 + lengths**2) / 12.0
    headings = np.cumsum(angles)
    directions = np.stack([np.cos(headings), np.sin(headings)])
    mass_matrix = np.zeros((3, 3))
    for segment in range(3):
        reach = np.append(lengths[:segment], 0.5 * lengths[segment])
        jacobian = np.zeros((2, 3))
        for link in range(segment + 1):
            jacobian[:, : link + 1] += (reach[link] * directions[:, link])[:, None]
        turning = np.where(np.arange(3) <= segment, 1.0, 0.0)
        mass_matrix += masses[segment] * jacobian.T @ jacobian
        mass_matrix += inertias[segment] * np.outer(turning, turning)
    return mass_matrix


def state_matrices(
    natural_rad_s: Array, joint_torque: Array, mass_matrix: Array, damping: Array, stiffness: Array
) -> tuple[Array, Array, Array]:
    """Matrices a (14, 14), b (14, 4), c (13, 14) of the finger.

    Parameters
    ----------
    natural_rad_s: (4,), natural frequency of each muscle's critically damped activation, rad/s.
    joint_torque: (3, 4), joint torque of each fully activated muscle, N m.
    mass_matrix: (3, 3), kg m^2.
    damping, stiffness: (3,), N m s/rad and N m/rad.
    """
    activation, activation_rate = slice(0, 4), slice(4, 8)
    deflection, rate = slice(8, 11), slice(11, 14)
    inverse = np.linalg.inv(mass_matrix)
    a = np.zeros((14, 14))
    a[activation, activation_rate] = np.eye(4)
    a[activation_rate, activation] = -np.diag(natural_rad_s**2)
    a[activation_rate, activation_rate] = -2.0 * np.diag(natural_rad_s)
    a[deflection, rate] = np.eye(3)
    a[rate, activation] = inverse @ joint_torque
    a[rate, deflection] = -inverse * stiffness
    a[rate, rate] = -inverse * damping
    b = np.zeros((14, 4))
    b[activation_rate] = np.diag(natural_rad_s**2)
    c = np.zeros((13, 14))
    c[OUTPUTS["angles"], deflection] = np.eye(3)
    c[OUTPUTS["rates"], rate] = np.eye(3)
    c[OUTPUTS["accelerations"]] = a[rate]
    c[OUTPUTS["activation"], activation] = np.eye(4)
    return a, b, c
