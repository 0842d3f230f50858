"""Posture in a grasp: aperture between thumb and fingers, wrist, and motion that nobody asked for."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from fesloop.experiment.metrics.grasp_score import FREEDOMS
from fesloop.hand.anthropometry import FINGERS

Array = NDArray[np.float64]
_WRIST = FREEDOMS.index("wrist_flexion")


def aperture(fingertips: Array, opposed: Sequence[str]) -> Array:
    """Mean distance (n,), m, of the thumb's tip from those of the `opposed` fingers; `fingertips` (n, 5, 3).

    Values (n,) are apertures already.
    """
    if fingertips.ndim == 1:
        return fingertips
    fingers = [FINGERS.index(name) for name in opposed]
    distances = np.linalg.norm(fingertips[:, fingers] - fingertips[:, :1], axis=2)
    return np.asarray(distances.mean(axis=1))


def rms_known(errors: Array) -> float:
    """Root mean square of those that are finite; NaN where none is."""
    known = errors[np.isfinite(errors)]
    return float(np.sqrt(np.mean(known**2))) if known.size else float("nan")


def wrist_extension_deg(angles: Array) -> float:
    """Mean extension of the wrist over (n, 23), rad, in deg."""
    return float(-np.degrees(angles[:, _WRIST].mean()))


def unwanted_motion_deg(angles: Array, asked: Sequence[str]) -> float:
    """RMS over time and freedoms, deg, of how far those that are not `asked` for are from the first row.

    `angles` (n, 23), rad. NaN where every freedom is asked for.
    """
    others = [column for column, name in enumerate(FREEDOMS) if not name.startswith(tuple(asked))]
    return float(np.degrees(np.sqrt(np.mean((angles[:, others] - angles[0, others]) ** 2)))) if others \
        else float("nan")
