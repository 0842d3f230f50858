"""Labels beside points, where they hide the least."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
_LETTER_MM, _HEIGHT_MM = 1.62, 3.4
"""Room that a letter and a line of a label take on the picture of the arrays, mm of skin."""
_WAYS = ((1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (-1, 1), (1, -1), (-1, -1))
"""Right, left, below, above, and between."""


def placed_labels(
    points: Mapping[str, Array], texts: Mapping[str, str], radius_mm: float
) -> dict[str, Array]:
    """Middle (2,) of each point's label, mm, chosen one after the other against points and earlier labels."""
    obstacles = [_box(place, 2.0 * radius_mm, 2.0 * radius_mm) for place in points.values()]
    spots: dict[str, Array] = {}
    for name, place in points.items():
        wide = _LETTER_MM * len(texts[name])
        options = [place + np.array([x * (radius_mm + 0.5 * wide + 0.6 if not y else 0.42 * wide + radius_mm),
                                     y * (radius_mm + 0.5 * _HEIGHT_MM)]) for x, y in _WAYS]
        hidden = [sum(_overlap(_box(spot, wide, _HEIGHT_MM), box) for box in obstacles) for spot in options]
        best = int(np.argmin(hidden))
        spots[name] = options[best]
        obstacles.append(_box(options[best], wide, _HEIGHT_MM))
    return spots


def _box(middle: Array, wide: float, high: float) -> Array:
    """Low and high corner, (2, 2)."""
    half = 0.5 * np.array([wide, high])
    return np.stack([middle - half, middle + half])


def _overlap(a: Array, b: Array) -> float:
    """Area that two boxes share."""
    return float(np.prod(np.clip(np.minimum(a[1], b[1]) - np.maximum(a[0], b[0]), 0.0, None)))
