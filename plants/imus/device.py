"""The sensors of a device as they were made and stuck on: drawn once for a run."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from fesloop.loop.noise import NoiseStream, stream_key
from plants.imus.errors import TriadErrors

Array = NDArray[np.float64]
KINDS = ("gyr", "acc", "mag")


class Device:
    """Numbers of a device's sensors: a function of the run's seed, the device's name and the site's number.

    Which of its sites and kinds are read changes nothing.

    Parameters
    ----------
    seed: of the run.
    name: of the device.
    sites: how many there are to sit on.
    """

    __slots__ = ("name", "seed", "sites")

    def __init__(self, seed: int, name: str, sites: int) -> None:
        self.seed, self.name, self.sites = seed, name, sites

    def _drawn(self, purpose: str, width: int, kind: str = "normal") -> Array:
        """Numbers (sites, width) that stay the same from trial to trial."""
        key = stream_key(self.seed, f"{self.name}/{purpose}", 0)
        return NoiseStream(key, self.sites * width, kind).row(0).reshape(self.sites, width)

    def mountings(self, sd_deg: float, angle_deg: tuple[float, float]) -> Array:
        """Matrices (sites, 3, 3) from the segments' frames to the sensors'.

        A rotation of `sd_deg` about each axis, after one about an axis of any direction by an angle that is
        uniform between the two of `angle_deg`.
        """
        axis = self._drawn("mounting_axis", 3)
        axis = axis / np.linalg.norm(axis, axis=1, keepdims=True)
        low, high = np.radians(angle_deg)
        angle = low + (high - low) * self._drawn("mounting_angle", 1, "uniform")
        scatter = math.radians(sd_deg) * self._drawn("mounting", 3)
        return rotations(scatter) @ rotations(angle * axis)

    def triads(self, kind: str, errors: TriadErrors, soft_iron: float = 0.0) -> tuple[Array, Array]:
        """Matrices (sites, 3, 3) from the sensors' frames to what the axes read, and biases (sites, 3).

        The rows of a matrix are the directions in which the axes feel, times their scale; `soft_iron` is the
        sd of the entries of the symmetric matrix that iron adds to the identity.
        """
        numbers = dict(zip(errors.__slots__, errors.numbers(), strict=True))
        iron = np.eye(3) + soft_iron * _symmetric(self._drawn(f"{kind}/iron", 6))
        turned = rotations(math.radians(numbers["turn_deg"]) * self._drawn(f"{kind}/turn", 3))
        tilts = math.radians(numbers["axes_deg"]) * self._drawn(f"{kind}/axes", 6)
        feeling = np.tile(np.eye(3), (self.sites, 1, 1))
        feeling[:, ~np.eye(3, dtype=np.bool_)] = tilts
        feeling /= np.linalg.norm(feeling, axis=-1, keepdims=True)
        scale = 1.0 + numbers["scale_sd"] * self._drawn(f"{kind}/scale", 3)
        matrices = scale[:, :, np.newaxis] * (feeling @ turned @ iron)
        return matrices, numbers["bias_sd"] * self._drawn(f"{kind}/bias", 3)


def rotations(turns: Array) -> Array:
    """Matrices (n, 3, 3) that give a vector's coordinates after a turn by rotation vectors (n, 3), rad."""
    angle = np.linalg.norm(turns, axis=-1)[:, np.newaxis, np.newaxis]
    x, y, z = turns.T
    zero = np.zeros_like(x)
    cross = np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=-1).reshape(-1, 3, 3)
    # sin a / a and (1 - cos a) / a^2, without division by zero
    first, half = np.sinc(angle / math.pi), np.sinc(angle / (2.0 * math.pi))
    return np.asarray(np.eye(3) + first * cross + 0.5 * half * half * (cross @ cross))


def _symmetric(entries: Array) -> Array:
    """Symmetric matrices (n, 3, 3) of their six entries (n, 6)."""
    return entries[:, [[0, 1, 2], [1, 3, 4], [2, 4, 5]]]
