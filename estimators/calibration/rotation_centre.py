"""The centre about which a marker turns, such as the wrist's, from the arcs that it draws.

The centre is where the marker's distance deviates least from its mean (Salchow-Hoemmen et al. 2019,
doi 10.3390/s19010208, eq. 28): the sum of absolute deviations, which a few misplaced samples hardly move.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fesloop.errors import InputError

Array = NDArray[np.float64]
_LEAST = 10
_STEPS = 200
_HALVINGS = 12
_FLOOR = 1e-7
"""Smallest deviation, as a share of the radius, that a weight distinguishes from none."""
_NOISE_RATIO = 4.0
"""By how much the arcs must leave a plane, over the scatter of the distances (chosen)."""
LEAST_SPREAD = math.sin(math.radians(2.0))
"""Rms by which directions to the centre must vary in every direction (chosen: arcs of 2 deg rms)."""


class RotationCentre(NamedTuple):
    """Where a marker's arcs have their centre.

    Attributes
    ----------
    centre: (3,), in the frame and unit of the positions.
    radius: mean distance.
    deviation: mean absolute deviation from it (eq. 28 over the number of samples).
    spread: rms by which the directions from the centre vary along `weakest`; 0: arcs in one plane.
    weakest: (3,), unit vector along which the centre is known worst.
    sd: of the centre along `weakest`, were the deviations independent of each other.
    """

    centre: Array
    radius: float
    deviation: float
    spread: float
    weakest: Array
    sd: float


def rotation_centre(positions: ArrayLike, least_spread: float = LEAST_SPREAD) -> RotationCentre:
    """The centre of rotation of a marker.

    From the algebraic least-squares sphere on, least squares with weights of one over the deviation, which
    ends where the sum of absolute deviations is least.

    Parameters
    ----------
    positions: (m, 3), in any unit, in a frame that the centre does not move in; NaN where unknown. They
        should come from movements about more than one axis (S19: flexion and extension, then ulnar and
        radial deviation).
    least_spread: of the directions to the centre, as of `RotationCentre.spread`.

    Raises InputError for too few positions, and where they lie on one arc, whose centre may be anywhere
    along the normal of its plane.
    """
    points = np.asarray(positions, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 3:
        raise InputError("positions", f"shape {points.shape}", "(samples, 3)")
    points = points[np.isfinite(points).all(axis=1)]
    if len(points) < _LEAST:
        raise InputError("positions", f"{len(points)} are known", f"{_LEAST} or more",
                         "record a longer motion")
    if not np.ptp(points, axis=0).any():
        raise InputError("positions", "are all the same", "arcs about two axes", "move the marker")
    centre = _least_deviation(points, _algebraic_centre(points))
    away = points - centre
    distances = np.linalg.norm(away, axis=1)
    radius = float(distances.mean())
    deviations = np.abs(distances - radius)
    deviation = float(deviations.mean())
    # The median holds out against outliers; 1.4826 makes it the sd of normal deviations.
    scatter = 1.4826 * float(np.median(deviations))
    slopes = _slopes(away, distances)
    _, strengths, axes = np.linalg.svd(slopes, full_matrices=False)
    spread = float(strengths[2]) / math.sqrt(len(points))
    needed = max(least_spread, _NOISE_RATIO * scatter / radius)
    if not spread > needed:
        raise InputError(
            "positions", f"lie on one arc: directions to the centre vary by {spread:.4f} rad along "
                         f"{np.round(axes[2], 2).tolist()}, along which it may be anywhere",
            f"more than {needed:.4f} rad",
            "move about another axis as well: flexion and extension, then ulnar and radial deviation")
    return RotationCentre(centre, radius, deviation, spread, axes[2], scatter / float(strengths[2]))


def _algebraic_centre(points: Array) -> Array:
    """Centre of the sphere that fits squared distances best: linear in the centre, so it needs no start."""
    middle = points.mean(axis=0)
    size = max(float(np.abs(points - middle).max()), np.finfo(np.float64).tiny)
    scaled = (points - middle) / size
    rows = np.hstack([2.0 * scaled, np.ones((len(points), 1))])
    # A cut-off keeps the centre of a plane arc in its plane.
    solution = np.linalg.lstsq(rows, np.sum(scaled * scaled, axis=1), rcond=1e-6)[0]
    return np.asarray(middle + size * solution[:3])


def deviation_sum(points: Array, centre: Array) -> float:
    """What eq. 28 of doi 10.3390/s19010208 minimises, for positions (m, 3) and a centre (3,)."""
    distances = np.linalg.norm(points - centre, axis=1)
    return float(np.abs(distances - distances.mean()).sum())


def _least_deviation(points: Array, start: Array) -> Array:
    """Minimum of `deviation_sum` by reweighted least squares, each step shortened until it gains."""
    centre, cost = start, deviation_sum(points, start)
    for _ in range(_STEPS):
        away = points - centre
        distances = np.linalg.norm(away, axis=1)
        residuals = distances - distances.mean()
        root = 1.0 / np.sqrt(np.maximum(np.abs(residuals), _FLOOR * distances.mean()))
        slopes = root[:, np.newaxis] * _slopes(away, distances)
        step = np.linalg.lstsq(slopes, root * residuals, rcond=1e-6)[0]
        for _ in range(_HALVINGS):
            after = deviation_sum(points, centre + step)
            if after < cost:
                break
            step = 0.5 * step
        else:
            break
        centre, cost = centre + step, after
    return centre


def _slopes(away: Array, distances: Array) -> Array:
    """Of the deviations, by a shift of all points against the centre, (m, 3)."""
    units = away / np.maximum(distances, np.finfo(np.float64).tiny)[:, np.newaxis]
    return np.asarray(units - units.mean(axis=0))
