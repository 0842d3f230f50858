"""The forearm's skin unrolled: where on it elements of arrays and motor points lie."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
CUT_DEG = -90.0
"""Where the skin is cut open: on the ulnar side, so that the back and the front each stay whole."""


def unrolled(places: Array, radius_mm: float) -> Array:
    """Places (n, 2 or more): around and along, mm, the former brought to one turn from the cut on."""
    turn = 2.0 * np.pi * radius_mm
    first = np.deg2rad(CUT_DEG) * radius_mm
    found = np.array(places, dtype=np.float64)
    found[:, 0] = first + np.mod(found[:, 0] - first, turn)
    return found


def motor_points(electrodes: Any) -> dict[str, Array]:
    """Place (2,) of each muscle's motor point on the unrolled skin, mm; none where the block has none."""
    points = getattr(electrodes, "motor_points", ())
    if not points:
        return {}
    found = unrolled(np.array([[np.deg2rad(point.around_deg) * electrodes.radius_mm, point.along_mm]
                               for point in points]), electrodes.radius_mm)
    return {point.muscle: place for point, place in zip(points, found, strict=True)}
