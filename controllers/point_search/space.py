"""Search space: elements of arrays on a forearm, virtual electrodes of them, and currents."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import combinations, pairwise
from math import isfinite

import numpy as np
from numpy.typing import NDArray

from controllers.point_search.earlier import EarlierSearch
from controllers.point_search.prior_zones import Zone
from fesloop.errors import InputError
from fesloop.models.electrode_arrays import USUAL, USUAL_RADIUS_MM, ArrayLayout

Array = NDArray[np.float64]
Electrode = tuple[int, ...]
"""Elements of a virtual electrode, ascending."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SearchSpace:
    """Candidates of a search: elements alone or together, up to the tolerated current.

    The nominal positions of the arrays on a forearm of about this radius are known; their displacement on the
    day, and the positions of the patient's nerves, are not.

    Attributes
    ----------
    layouts: layouts of the arrays; elements are numbered consecutively in this order.
    radius_mm: radius of the forearm.
    currents_ma: levels of a query's total current for strategies that choose among levels, strictly
        increasing; the last is the limit of all strategies.
    width_us: pulse width of every query.
    pairs: whether two adjacent elements form a virtual electrode, besides each element alone.
    most_elements: greatest number of elements of a virtual electrode.
    elements: numbers of the elements that may be used; empty: all.
    zones: zones where anatomy suggests the movement; empty: those of `point_search`'s movement.
    earlier: what a search of another day found out, as `point_search` has it.
    """

    layouts: tuple[ArrayLayout, ...] = tuple(array.layout for array in USUAL)
    radius_mm: float = USUAL_RADIUS_MM
    currents_ma: tuple[float, ...] = (8.0, 12.0, 16.0, 20.0, 25.0, 30.0)
    width_us: float = 300.0
    pairs: bool = True
    most_elements: int = 4
    elements: tuple[int, ...] = ()
    zones: tuple[Zone, ...] = ()
    earlier: EarlierSearch = field(default_factory=EarlierSearch)
    electrodes: tuple[Electrode, ...] = field(init=False, repr=False, compare=False)
    _positions: Array = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        if not self.layouts:
            raise InputError("space.layouts", "none", "one or more")
        if not (isfinite(self.radius_mm) and self.radius_mm > 0.0):
            raise InputError("space.radius_mm", f"{self.radius_mm}", "a finite radius above 0")
        levels = (0.0, *self.currents_ma)
        if len(levels) < 2 or not all(map(isfinite, levels)) or any(b <= a for a, b in pairwise(levels)):
            raise InputError("space.currents_ma", f"{self.currents_ma}",
                             "one or more finite currents above 0, strictly increasing")
        if not (isfinite(self.width_us) and self.width_us > 0.0):
            raise InputError("space.width_us", f"{self.width_us}", "a finite width above 0")
        if self.most_elements < 1:
            raise InputError("space.most_elements", f"{self.most_elements}", "1 or more")
        for element in self.elements:
            if not 0 <= element < self.count:
                raise InputError("space.elements", f"element {element} does not exist",
                                 f"0 to {self.count - 1}")
        object.__setattr__(self, "_positions", self._on_the_cylinder())
        object.__setattr__(self, "electrodes", tuple(self._virtual_electrodes()))

    @property
    def count(self) -> int:
        """Number of elements of all arrays, used or not."""
        return sum(layout.elements for layout in self.layouts)

    @property
    def usable(self) -> tuple[int, ...]:
        """Elements that may be used, ascending."""
        return tuple(sorted(set(self.elements))) or tuple(range(self.count))

    @property
    def current_max_ma(self) -> float:
        """Greatest current of a query."""
        return self.currents_ma[-1]

    def neighbours(self) -> list[tuple[int, int]]:
        """Pairs of usable elements side by side."""
        usable, first, pairs = set(self.usable), 0, []
        for layout in self.layouts:
            pairs += [(first + one, first + other) for one, other in layout.neighbours(self.radius_mm)]
            first += layout.elements
        return [pair for pair in pairs if usable.issuperset(pair)]

    def position(self, electrode: Electrode) -> Array:
        """Middle of a virtual electrode, mm, (3,): two coordinates across the forearm, one along it."""
        middle: Array = self._positions[list(electrode)].mean(axis=0)
        return middle

    def _on_the_cylinder(self) -> Array:
        """Positions of all elements on the forearm's surface, (elements, 3), mm."""
        places = np.concatenate([layout.places(self.radius_mm) for layout in self.layouts])
        turn = places[:, 0] / self.radius_mm
        return np.stack([self.radius_mm * np.cos(turn), self.radius_mm * np.sin(turn), places[:, 1]], axis=-1)

    def _virtual_electrodes(self) -> list[Electrode]:
        """Each element, then each adjacent pair."""
        single: list[Electrode] = [(element,) for element in self.usable]
        return single + (list(self.neighbours()) if self.pairs and self.most_elements > 1 else [])


def joined(electrodes: tuple[Electrode, ...], most: int) -> list[Electrode]:
    """Unions of two virtual electrodes, each once, with at most `most` elements."""
    unions = [tuple(sorted({*one, *other})) for one, other in combinations(electrodes, 2)]
    return [union for union in dict.fromkeys(unions) if len(union) <= most and union not in electrodes]
