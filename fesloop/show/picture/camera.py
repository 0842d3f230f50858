"""Where a picture is taken from, and what of the scene it frames."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
_ELEVATIONS_DEG = np.array([12.0, 22.0, 32.0, 45.0])
_AZIMUTHS_DEG = np.arange(0.0, 360.0, 10.0)


@dataclass(frozen=True, slots=True, eq=False)
class Camera:
    """Parallel projection.

    Attributes
    ----------
    along: (3,), unit vector of the view, from the camera into the scene.
    right, up: (3,), unit vectors of the picture.
    """

    along: Array
    right: Array
    up: Array

    @classmethod
    def towards(cls, along: ArrayLike) -> Camera:
        """The view along a direction that is not vertical, the picture's sides upright."""
        way = np.asarray(along, dtype=np.float64) / np.linalg.norm(along)
        right = np.cross(way, [0.0, 0.0, 1.0])
        right /= np.linalg.norm(right)
        return cls(way, right, np.cross(right, way))

    def seen(self, points: Array) -> Array:
        """Where points (..., 3) appear: right, up, away from the camera, m; (..., 3)."""
        return points @ np.stack([self.right, self.up, self.along], axis=-1)


def _directions() -> Array:
    """Views from above the horizon, (n, 3)."""
    elevation, azimuth = (each.ravel() for each in np.meshgrid(
        np.deg2rad(_ELEVATIONS_DEG), np.deg2rad(_AZIMUTHS_DEG), indexing="ij"))
    flat = np.cos(elevation)
    return -np.stack([flat * np.cos(azimuth), flat * np.sin(azimuth), np.sin(elevation)], axis=-1)


def best_view(points: Array, moving: Array, liked: Array) -> Camera:
    """The view that shows the most of a hand's postures and of its motion.

    Parameters
    ----------
    points: (instants, n, 3), of the hand at each instant, m. moving: (instants, m, 3), those of them whose
        motion is to be seen, such as fingertips.
    liked: (3,), direction, from the hand, that a view prefers to come from; of a length of about 1.
    """
    ways = _directions()
    spread = _seen_spread(points - points.mean(axis=1, keepdims=True), ways)
    travel = _seen_spread(moving - moving.mean(axis=0), ways)
    return Camera.towards(ways[int(np.argmax(spread + 0.6 * travel - 0.25 * ways @ liked))])


def _seen_spread(centred: Array, ways: Array) -> Array:
    """Share of points' mean square distance that each view shows, (n,); 1 where there is none."""
    square = np.square(centred).sum(axis=-1).mean()
    if square < 1e-8:
        return np.ones(len(ways))
    hidden = np.square(centred @ ways.T).mean(axis=(0, 1))
    return np.asarray(1.0 - hidden / square)
