"""Compiled search for the posture whose fingertips are nearest to where they should be.

`layout`, `geometry`, `root` and `poses` as in `kinematics_kernels`. The t tips are points `places` (t, 3) of
`segments` (t,). Angles (d,) are an affine function of c coordinates z: angles = offset + basis z. Arrays that
are filled come last.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.compiled import compiled
from fesloop.hand.kinematics_kernels import forward, joint_lines, point_jacobian, turned

Array = NDArray[np.float64]
Layout = NDArray[np.int64]

STILL_RAD = 1e-9
"""A step below this is none."""
_FIRST_DAMPING, _LEAST_DAMPING, _MOST_DAMPING = 1e-6, 1e-14, 1e4
"""m^2/rad^2. Chosen: squared lever arms of a hand's joints are 1e-4 to 1e-2 m^2."""


@compiled
def place_tips(
    layout: Layout, geometry: Array, root: Array, angles: Array, segments: NDArray[np.int64], places: Array,
    poses: Array, tips: Array,
) -> None:
    """Fill `poses` (n, 7), and `tips` (t, 3), m, in the reference frame."""
    forward(layout, geometry, angles, root, poses)
    for i in range(segments.shape[0]):
        pose, place = poses[segments[i]], places[i]
        arm = turned((pose[0], pose[1], pose[2], pose[3]), place[0], place[1], place[2])
        for j in range(3):
            tips[i, j] = pose[4 + j] + arm[j]


@compiled
def slopes_of_tips(
    layout: Layout, geometry: Array, moves: NDArray[np.bool_], angles: Array, poses: Array,
    segments: NDArray[np.int64], tips: Array, basis: Array, lines: Array, each: Array, slopes: Array,
) -> None:
    """Fill `slopes` (3 t, c), m/rad: the tips' Jacobian in z. `lines` (d, 6), `each` (6, d) are scratch."""
    joint_lines(layout, geometry, angles, poses, lines)
    for i in range(segments.shape[0]):
        point_jacobian(lines, moves[segments[i]], tips[i], each)
        slopes[3 * i:3 * i + 3] = each[:3] @ basis


@compiled
def damp_step(
    slopes: Array, gradient: Array, held: NDArray[np.bool_], damping: float, step: Array
) -> None:
    """Fill `step` (c,) with -(J'J + damping I)^-1 g in the coordinates that are not held, else 0."""
    matrix = slopes.T @ slopes
    right = -gradient
    for i in range(held.size):
        matrix[i, i] += damping
        if held[i]:
            matrix[i, :] = 0.0
            matrix[:, i] = 0.0
            matrix[i, i], right[i] = 1.0, 0.0
    step[:] = np.linalg.solve(matrix, right)


@compiled
def seek(
    layout: Layout, geometry: Array, moves: NDArray[np.bool_], root: Array, segments: NDArray[np.int64],
    places: Array, targets: Array, basis: Array, offset: Array, low: Array, high: Array, preferred: Array,
    weight: float, iterations: int, z: Array,
) -> Any:
    """Move z (c,), within [low, high], to a least of |tips - targets|^2 + weight |z - preferred|^2.

    Gives that least, and the greatest distance of a tip from its target, m; floats.

    Levenberg-Marquardt on the coordinates that no bound holds, projected onto the bounds (Bertsekas 1982, doi
    10.1137/0320018: two-metric projection): a step is taken if it lessens the cost, else damped more.
    """
    freedoms, tip_count = offset.size, segments.shape[0]
    poses, lines, each = np.empty((layout.shape[0], 7)), np.empty((freedoms, 6)), np.empty((6, freedoms))
    tips, slopes, step = np.empty((tip_count, 3)), np.empty((3 * tip_count, z.size)), np.empty(z.size)
    angles = offset + basis @ z
    place_tips(layout, geometry, root, angles, segments, places, poses, tips)
    away, damping = tips - targets, _FIRST_DAMPING
    cost = np.sum(away**2) + weight * np.sum((z - preferred) ** 2)
    for _ in range(iterations):
        slopes_of_tips(layout, geometry, moves, angles, poses, segments, tips, basis, lines, each, slopes)
        gradient = slopes.T @ away.ravel() + weight * (z - preferred)
        held = ((z <= low) & (gradient > 0.0)) | ((z >= high) & (gradient < 0.0))
        least, trial = cost, z
        while least >= cost and damping < _MOST_DAMPING:
            damp_step(slopes, gradient, held, weight + damping, step)
            trial = np.minimum(np.maximum(z + step, low), high)
            angles = offset + basis @ trial
            place_tips(layout, geometry, root, angles, segments, places, poses, tips)
            least = np.sum((tips - targets) ** 2) + weight * np.sum((trial - preferred) ** 2)
            damping = max(0.1 * damping, _LEAST_DAMPING) if least < cost else 10.0 * damping
        if least >= cost:
            break
        moved = np.abs(trial - z).max()
        z[:], cost, away = trial, least, tips - targets
        if moved < STILL_RAD:
            break
    return cost, np.sqrt(np.sum(away**2, axis=1)).max()
