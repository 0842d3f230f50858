"""Electrode arrays on a forearm: the geometry that electrodes, stimulator and point search share.

A place on the skin is an angle around the forearm, from the dorsal mid-line towards the radial side, so that
it means the same on both arms, and a distance along it from the elbow.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any, Literal, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.forms.schema import (
    build,
    plain,
    require_not_negative,
    require_positive,
    require_shape,
)

Array = NDArray[np.float64]
Place = tuple[float, float]
MOST_ELEMENTS = 4096
"""Most elements of an electrode array (chosen: fifty times the largest array in use; tables fit in
memory)."""
_TOLERANCE = 1e-6
_ROUNDING_MM = 1e-6


@dataclass(frozen=True, slots=True, kw_only=True)
class ArrayLayout:
    """Places of an array's elements: a grid, or given positions.

    Elements are numbered along the forearm first: element r * columns + c of a grid is in row r, counted
    towards the radial side, and column c, counted from the elbow.

    Attributes
    ----------
    rows, columns: numbers of rows around the forearm and columns along it.
    pitch_mm: distance from row to row and from column to column, on the skin.
    centre_deg, centre_mm: centre of the grid, around and along.
    positions: (deg, mm) of each element around and along, in place of the grid.
    """

    rows: int = 0
    columns: int = 0
    pitch_mm: Place = (16.0, 16.0)
    centre_deg: float = 0.0
    centre_mm: float = 106.0
    positions: tuple[Place, ...] | None = None

    def __post_init__(self) -> None:
        require_positive("array", self, "pitch_mm")
        require_shape("array", self, (2,), "around, along", "pitch_mm")
        require_shape("array", self, (), "a number", "centre_deg", "centre_mm")
        require_not_negative("array", self, "rows", "columns")
        if self.positions:
            require_shape("array", self, (len(self.positions), 2), "deg, mm of each element", "positions")
        if bool(self.positions) == bool(self.rows * self.columns):
            found = f"{self.rows} rows, {self.columns} columns and {len(self.positions or ())} positions"
            raise InputError("array", found, "either rows and columns, or positions")
        if self.elements > MOST_ELEMENTS:
            raise InputError("array", f"{self.elements} elements", f"at most {MOST_ELEMENTS}")

    @property
    def elements(self) -> int:
        """Number of elements."""
        return len(self.positions or ()) or self.rows * self.columns

    def places(self, radius_mm: float) -> Array:
        """Place of each element around the forearm and along it, mm, (elements, 2)."""
        per_deg = np.pi / 180.0 * radius_mm
        if self.positions:
            around, along = np.array(self.positions, dtype=np.float64).T * np.array([[per_deg], [1.0]])
        else:
            row, column = np.divmod(np.arange(self.elements), self.columns)
            around = self.centre_deg * per_deg + (row - 0.5 * (self.rows - 1)) * self.pitch_mm[0]
            along = self.centre_mm + (column - 0.5 * (self.columns - 1)) * self.pitch_mm[1]
        return np.stack([around, along], axis=-1)

    def neighbours(self, radius_mm: float) -> list[tuple[int, int]]:
        """Pairs of elements side by side.

        In a grid, along and around. Of given positions, pairs with no third element in or on the circle
        whose diameter joins them (Gabriel and Sokal 1969), which are the same pairs where the positions are a
        grid of equal pitches.
        """
        if not self.positions:
            return [(one, one + step) for one in range(self.elements) for step, beside in
                    ((1, (one + 1) % self.columns > 0), (self.columns, one + self.columns < self.elements))
                    if beside]
        from scipy.spatial import KDTree  # which a run on grids does without

        girth = 2.0 * math.pi * radius_mm
        places = self.places(radius_mm)
        places[:, 0] %= girth
        places[:, 1] -= places[:, 1].min()
        around = np.array([girth, np.inf])
        tree = KDTree(places % around, boxsize=np.array([girth, 2.0 * places[:, 1].max() + girth]))
        pairs = []
        for one, place in enumerate(places[:-1]):
            apart = places[one + 1:] - place
            apart[:, 0] -= girth * np.round(apart[:, 0] / girth)
            third = np.asarray(tree.query((place + 0.5 * apart) % around, k=3)[0])[:, 2]
            beside = np.flatnonzero(third > 0.5 * np.hypot(*apart.T) + _ROUNDING_MM)
            pairs += [(one, one + 1 + int(other)) for other in beside]
        return pairs

    def in_words(self) -> str:
        """Its form: `5 x 7 at 16 x 16 mm`, or `12 positions`."""
        if self.positions:
            return f"{self.elements} positions"
        around, along = self.pitch_mm
        return f"{self.rows} x {self.columns} at {around:g} x {along:g} mm"


@dataclass(frozen=True, slots=True, kw_only=True)
class ElectrodeArray(ArrayLayout):
    """A grid of equal elements, or elements at given positions, with the size of their pads.

    Attributes
    ----------
    pad_mm: size of an element, the radius of a round one (chosen: calibrated with the field of `electrodes`).
    """

    positions: tuple[Place, ...] = ()
    pad_mm: float = 7.0

    def __post_init__(self) -> None:
        require_positive("array", self, "pad_mm")
        ArrayLayout.__post_init__(self)

    @property
    def layout(self) -> ArrayLayout:
        """The places alone."""
        return ArrayLayout(rows=self.rows, columns=self.columns, pitch_mm=self.pitch_mm,
                           centre_deg=self.centre_deg, centre_mm=self.centre_mm,
                           positions=self.positions or None)

    def pads(self, radius_mm: float) -> Array:
        """Elements (elements, 3): place around the forearm, along it, and size, mm."""
        return np.column_stack([self.places(radius_mm), np.full(self.elements, self.pad_mm)])


# S19's group used 59 elements in two arrays (doi 10.3390/s19010208). Their division and positions are chosen,
# the latter so that the overlap of neighbouring muscles is that of the literature.
DORSAL = ElectrodeArray(rows=5, columns=7)
VOLAR = ElectrodeArray(rows=4, columns=6, centre_deg=175.0)
USUAL = (DORSAL, VOLAR)
"""Arrays of an experiment that states none."""
USUAL_RADIUS_MM = 40.0
"""Radius of the forearm on which places are compared where no patient is known (chosen)."""
FARTHEST_MM = 20.0
"""Greatest distance of an element in place of one of other arrays (chosen: a little more than the pitch of
the usual ones)."""


def distances_mm(places: Array, others: Array, radius_mm: float) -> Array:
    """Distances on the skin of a forearm, (n, m), of places (n, 2 or more) and others (m, 2 or more), mm."""
    girth = 2.0 * math.pi * radius_mm
    around = np.abs(places[:, np.newaxis, 0] - others[:, 0]) % girth
    apart: Array = np.hypot(np.minimum(around, girth - around), places[:, np.newaxis, 1] - others[:, 1])
    return apart


@dataclass(frozen=True, slots=True, kw_only=True)
class VirtualElectrode:
    """Elements that share a channel's current.

    Attributes
    ----------
    elements: numbers of the elements.
    shares: fractions of the current, adding up to 1; empty: equal ones.
    """

    elements: tuple[int, ...]
    shares: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        if not self.elements or len(set(self.elements)) < len(self.elements) or min(self.elements) < 0:
            raise InputError("virtual_electrode.elements", f"{self.elements}",
                             "one or more numbers, each once")
        if self.shares:
            require_positive("virtual_electrode", self, "shares")
            if len(self.shares) != len(self.elements) or abs(sum(self.shares) - 1.0) > _TOLERANCE:
                raise InputError("virtual_electrode.shares", f"{self.shares}",
                                 f"{len(self.elements)} numbers, one an element, that add up to 1")


@dataclass(frozen=True, slots=True, kw_only=True)
class ElectrodeArrays:
    """All electrode arrays on a forearm, as a file of arrays states them.

    Attributes
    ----------
    arrays: the arrays; their elements are numbered consecutively in this order.
    channels: virtual electrode of each channel of the stimulator, where nothing chooses elements during the
        run; "nearest": for each element that the experiment names of the usual arrays, the nearest one of
        these.
    name: for people.
    """

    arrays: tuple[ElectrodeArray, ...]
    channels: Literal["nearest"] | tuple[VirtualElectrode, ...] = ()
    name: str = ""

    def __post_init__(self) -> None:
        if not self.arrays:
            raise InputError("arrays", "none", "one or more")
        if isinstance(self.channels, tuple):
            for number, electrode in enumerate(self.channels):
                if max(electrode.elements) >= self.elements:
                    raise InputError(f"channels[{number}].elements",
                                     f"element {max(electrode.elements)} does not exist",
                                     f"0 to {self.elements - 1}")

    def require_apart(self, radius_mm: float) -> None:
        """Raise InputError for pads that overlap on a forearm of this radius."""
        pads = self.pads(radius_mm)
        apart = distances_mm(pads, pads, radius_mm)
        overlap = pads[:, 2] + pads[:, np.newaxis, 2] - apart
        np.fill_diagonal(overlap, 0.0)
        one, other = map(int, np.unravel_index(int(overlap.argmax()), overlap.shape))
        if overlap[one, other] > _ROUNDING_MM:
            raise InputError("arrays", f"elements {one} and {other} overlap: {apart[one, other]:.3g} mm "
                             f"apart on a forearm of {radius_mm:.3g} mm radius, with pads of "
                             f"{pads[one, 2]:g} and {pads[other, 2]:g} mm",
                             "pads that lie beside each other", "enlarge pitch_mm, or reduce pad_mm")

    @property
    def elements(self) -> int:
        """Number of elements of all arrays."""
        return sum(array.elements for array in self.arrays)

    @property
    def areas_cm2(self) -> float | tuple[float, ...]:
        """Area of an element as a disc; one for each element where they differ."""
        areas = [math.pi * array.pad_mm**2 / 100.0 for array in self.arrays for _ in range(array.elements)]
        return areas[0] if len(set(areas)) == 1 else tuple(areas)

    def pads(self, radius_mm: float) -> Array:
        """Elements (elements, 3): place around the forearm, along it, and size, mm."""
        return np.concatenate([array.pads(radius_mm) for array in self.arrays])

    def in_place_of(self, electrodes: Sequence[VirtualElectrode]) -> tuple[VirtualElectrode, ...]:
        """Virtual electrodes of the elements nearest to those of virtual electrodes of the usual arrays.

        Elements that have the same nearest one are one element, with both shares. Raises InputError where no
        element is near enough, and where two channels would be one.
        """
        theirs = ElectrodeArrays(arrays=USUAL).pads(USUAL_RADIUS_MM)
        apart = distances_mm(theirs, self.pads(USUAL_RADIUS_MM), USUAL_RADIUS_MM)
        made: list[VirtualElectrode] = []
        for channel, electrode in enumerate(electrodes):
            shares: dict[int, float] = {}
            equal = (1.0 / len(electrode.elements),) * len(electrode.elements)
            for element, share in zip(electrode.elements, electrode.shares or equal, strict=True):
                if element >= len(theirs):
                    raise InputError("channels", f'"nearest": element {element} of channel {channel} is none '
                                     "of the usual arrays", f"0 to {len(theirs) - 1}",
                                     "list the channels' elements of these arrays")
                near = int(apart[element].argmin())
                if apart[element, near] > FARTHEST_MM:
                    raise InputError("channels", f'"nearest": channel {channel} has element {element} of the '
                                     f"usual arrays, and the nearest of these, {near}, lies "
                                     f"{apart[element, near]:.0f} mm from it", f"at most {FARTHEST_MM:g} mm",
                                     "add elements there, or list the channels' elements")
                shares[near] = shares.get(near, 0.0) + share
            unequal = len(set(shares.values())) > 1
            made.append(VirtualElectrode(elements=tuple(shares),
                                         shares=tuple(shares.values()) if unequal else ()))
        for (one, first), (other, second) in combinations(enumerate(made), 2):
            if set(first.elements) == set(second.elements):
                raise InputError("channels", f'"nearest": channels {one} and {other} would both have element '
                                 f"{'+'.join(map(str, first.elements))}", "different ones",
                                 "arrays with a smaller pitch, or list the channels' elements")
        return tuple(made)


@runtime_checkable
class FitsArrays(Protocol):
    """A class of blocks whose parameters follow in part from the arrays."""

    @classmethod
    def for_arrays(cls, arrays: ElectrodeArrays, own: Mapping[str, Any], wired: Collection[str]
                   ) -> dict[str, Any]:
        """Parameters that follow, as plain tables.

        `own` is the block's own table in an experiment file, of the right form; `wired` are the inputs that
        have a wire. Raises InputError, its place a key of the arrays' file.
        """

    def of_arrays(self) -> list[tuple[str, str]]:
        """Parameters that the arrays determine, as (name, value), for `fesloop check`."""


def arrays_in_words(electrodes: Mapping[str, Any] | None) -> str:
    """The arrays of a table of `electrodes`, in words and with a checksum; empty for the usual ones.

    The same text for the same geometry, by which a model knows the arrays that it was identified with.
    """
    given = (electrodes or {}).get("arrays")
    if given is None:
        return ""
    arrays: tuple[ElectrodeArray, ...] = build(tuple[ElectrodeArray, ...], given, {}, "arrays")
    if arrays == USUAL:
        return ""
    checksum = hashlib.sha256(json.dumps(plain(arrays), sort_keys=True).encode()).hexdigest()
    return f"{' and '.join(each.in_words() for each in arrays)} ({checksum[:8]})"
