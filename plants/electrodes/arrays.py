"""Electrode arrays on a forearm that is a cylinder: where their elements sit and how large they are.

A place on the skin is an angle around the forearm, from the dorsal mid-line towards the radial side, so that
it means the same on both arms, and a distance along it from the elbow.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from plants.checks import MOST_ELEMENTS, require_not_negative, require_positive, require_shape

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class ElectrodeArray:
    """A grid of equal elements, or elements at positions of their own.

    Elements are numbered along the forearm first: element r * columns + c of an array is in row r, counted
    towards the radial side, and column c, counted from the elbow.

    Attributes
    ----------
    rows, columns: around the forearm and along it.
    pitch_mm: from row to row and from column to column, on the skin.
    centre_deg, centre_mm: of the grid, around and along.
    pad_mm: size of an element, the radius of a round one (chosen: calibrated with the field of `electrodes`).
    positions: (deg, mm) of each element around and along, in place of the grid.
    """

    rows: int = 0
    columns: int = 0
    pitch_mm: tuple[float, float] = (16.0, 16.0)
    centre_deg: float = 0.0
    centre_mm: float = 106.0
    pad_mm: float = 7.0
    positions: tuple[tuple[float, float], ...] = ()

    def __post_init__(self) -> None:
        require_positive("array", self, "pad_mm", "pitch_mm")
        require_shape("array", self, (2,), "around, along", "pitch_mm")
        require_shape("array", self, (), "a number", "centre_deg", "centre_mm")
        require_not_negative("array", self, "rows", "columns")
        if self.positions:
            require_shape("array", self, (len(self.positions), 2), "deg, mm of each element", "positions")
        if bool(self.positions) == bool(self.rows * self.columns):
            found = f"{self.rows} rows, {self.columns} columns and {len(self.positions)} positions"
            raise InputError("array", found, "rows and columns, or positions in their place")
        if self.elements > MOST_ELEMENTS:
            raise InputError("array", f"{self.elements} elements", f"at most {MOST_ELEMENTS}")

    @property
    def elements(self) -> int:
        """Number of elements."""
        return len(self.positions) or self.rows * self.columns

    def places(self, radius_mm: float) -> Array:
        """Of each element: around the forearm, along it, size, mm, (elements, 3)."""
        per_deg = np.pi / 180.0 * radius_mm
        if self.positions:
            around, along = np.array(self.positions, dtype=np.float64).T * np.array([[per_deg], [1.0]])
        else:
            row, column = np.divmod(np.arange(self.elements), self.columns)
            around = self.centre_deg * per_deg + (row - 0.5 * (self.rows - 1)) * self.pitch_mm[0]
            along = self.centre_mm + (column - 0.5 * (self.columns - 1)) * self.pitch_mm[1]
        return np.stack([around, along, np.full(self.elements, self.pad_mm)], axis=-1)


# S19's group used 59 elements in two arrays (doi 10.3390/s19010208); how they are divided and where they lie
# is chosen, the latter such that the overlap of neighbouring muscles is that of the literature.
DORSAL = ElectrodeArray(rows=5, columns=7)
VOLAR = ElectrodeArray(rows=4, columns=6, centre_deg=175.0)
