"""Zones of the forearm where anatomy suggests a movement."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Zone:
    """Zone on the forearm's skin.

    Attributes
    ----------
    around_deg: angle from the dorsal mid-line towards the radial side.
    along_mm: distance from the elbow.
    radius_mm: distance at which the expectation has fallen to exp(-1/2).
    """

    around_deg: float
    along_mm: float
    radius_mm: float = 25.0

    def __post_init__(self) -> None:
        if not (isfinite(self.around_deg) and isfinite(self.along_mm)):
            raise InputError("zone", f"{self.around_deg} deg, {self.along_mm} mm", "finite numbers")
        if not (isfinite(self.radius_mm) and self.radius_mm > 0.0):
            raise InputError("zone.radius_mm", f"{self.radius_mm}", "a finite radius above 0")


# Middles of the motor points of each movement's muscles, for an adult's forearm; the radius is
# chosen to cover their variation between patients and days.
ZONES: dict[str, tuple[Zone, ...]] = {
    "wrist_extension": (Zone(around_deg=46.0, along_mm=68.0),),  # ECRL, ECRB
    "finger_opening": (Zone(around_deg=3.0, along_mm=95.0),),  # EDC
    "pinch": (Zone(around_deg=164.0, along_mm=138.0),),  # FDS2, FDP2, FPL
    "key_pinch": (Zone(around_deg=164.0, along_mm=138.0),),  # FDS2, FDP2, FPL
    "power_grasp": (Zone(around_deg=-173.0, along_mm=105.0, radius_mm=30.0),),  # FDS3, FDS4, FDP3, FDP4
}


def expectation(zones: tuple[Zone, ...], positions: Array, radius_mm: float) -> Array:
    """Expectation, from 0 far from all zones to 1 in the middle of one, at positions (n, 3), mm."""
    expected = np.zeros(len(positions))
    for zone in zones:
        turn = np.radians(zone.around_deg)
        middle = np.array([radius_mm * np.cos(turn), radius_mm * np.sin(turn), zone.along_mm])
        squared = np.square(positions - middle).sum(axis=1)
        np.maximum(expected, np.exp(-0.5 * squared / zone.radius_mm**2), out=expected)
    return expected
