"""Centre of rotation of a marker, such as the wrist's, from its arcs.

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
"""Smallest deviation, as a share of the radius, for the weights."""
_NOISE_RATIO = 4.0
"""Least departure of the arcs from a plane, relative to the scatter of the distances (chosen)."""
LEAST_SPREAD = math.sin(math.radians(2.0))
"""Least rms variation of the directions to the centre along any axis (chosen: arcs of 2 deg rms)."""


class RotationCentre(NamedTuple):
    """Centre of a marker's arcs.

    Attributes
    ----------
    centre: (3,), in the frame and unit of the positions.
    radius: mean distance from it.
    deviation: mean absolute deviation from the radius (eq. 28 over the number of samples).
    spread: rms variation of the directions from the centre along `weakest`; 0: arcs in one plane.
    weakest: (3,), unit vector along which the centre is known worst.
    sd: sd of the centre along `weakest`, if the deviations are independent of each other.
    """

    centre: Array
    radius: float
    deviation: float
    spread: float
    weakest: Array
    sd: float


def rotation_centre(positions: ArrayLike, least_spread: float = LEAST_SPREAD) -> RotationCentre:
    """Centre of rotation of a marker.

    Least squares with weights of one over the deviation, from the algebraic least-squares sphere, converges
    to the least sum of absolute deviations.

    Parameters
    ----------
    positions: (m, 3), in any unit, in a frame in which the centre is fixed; NaN where unknown. They
        should come from movements about more than one axis (S19: flexion and extension, then ulnar and
        radial deviation).
    least_spread: least `RotationCentre.spread`.

    Raises InputError for too few positions, and for a single arc, whose centre may be anywhere along the
    normal of its plane.
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
    # The median is robust to outliers; the factor 1.4826 gives the sd of normal deviations.
    scatter = 1.4826 * float(np.median(deviations))
    slopes = _slopes(away, distances)
    _, strengths, axes = np.linalg.svd(slopes, full_matrices=False)
    spread = float(strengths[2]) / math.sqrt(len(points))
    needed = max(least_spread, _NOISE_RATIO * scatter / radius)
    if not spread > needed:
        raise InputError(
            "positions", f"lie on one arc: directions to the centre vary by {spread:.4f} rad along "
                         f"{np.round(axes[2], 2).tolist()}, along which the centre is unknown",
            f"more than {needed:.4f} rad",
            "move about another axis as well: flexion and extension, then ulnar and radial deviation")
    return RotationCentre(centre, radius, deviation, spread, axes[2], scatter / float(strengths[2]))


def _algebraic_centre(points: Array) -> Array:
    """Centre of the sphere that fits squared distances best: linear in the centre, without a start."""
    middle = points.mean(axis=0)
    size = max(float(np.abs(points - middle).max()), np.finfo(np.float64).tiny)
    scaled = (points - middle) / size
    rows = np.hstack([2.0 * scaled, np.ones((len(points), 1))])
    # A cut-off keeps the centre of a plane arc in its plane.
    solution = np.linalg.lstsq(rows, np.sum(scaled * scaled, axis=1), rcond=1e-6)[0]
    return np.asarray(middle + size * solution[:3])


def deviation_sum(points: Array, centre: Array) -> float:
    """Objective of eq. 28 of doi 10.3390/s19010208, for positions (m, 3) and a centre (3,)."""
    distances = np.linalg.norm(points - centre, axis=1)
    return float(np.abs(distances - distances.mean()).sum())


def _least_deviation(points: Array, start: Array) -> Array:
    """Minimum of `deviation_sum` by reweighted least squares, each step shortened until the sum falls."""
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
    """Derivatives of the deviations by a shift of all points, (m, 3)."""
    units = away / np.maximum(distances, np.finfo(np.float64).tiny)[:, np.newaxis]
    return np.asarray(units - units.mean(axis=0))
