"""Ports, and the samples with stamps that travel between them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.loop.clock import FOREVER

Value = float | NDArray[np.float64]
"""A float on a scalar port, on any other a float64 array that is never written to again."""

NEVER = -1
"""Stamp of the initial value of a port, before any message has arrived."""


@dataclass(frozen=True, slots=True)
class Sensors:
    """The sensors that the rows of a signal belong to.

    Attributes
    ----------
    names: one a row, all different.
    pairs: (parent, child) rows of sensors on neighbouring segments; empty where it is not known.
    """

    names: tuple[str, ...]
    pairs: tuple[tuple[int, int], ...] = ()

    def __post_init__(self) -> None:
        for name in self.names:
            if self.names.count(name) > 1:
                raise InputError("sensors", f"{self.names.count(name)} sensors are named {name!r}",
                                 "different names")
        require_pairs(self.pairs, self.names, "pairs")

    def pair_name(self, pair: tuple[int, int]) -> str:
        """"parent-child"."""
        return f"{self.names[pair[0]]}-{self.names[pair[1]]}"


def require_pairs(pairs: Sequence[tuple[int, int]], names: Sequence[str], where: str) -> None:
    """Raise InputError for (parent, child) numbers of sensors that do not exist, listed twice, or in a loop.

    A child may have several parents: the nearest, and others further towards the root.
    """
    parents: dict[int, set[int]] = {}
    for parent, child in pairs:
        if not (0 <= parent < len(names) and 0 <= child < len(names)):
            raise InputError(where, f"[{parent}, {child}] names a sensor that does not exist",
                             f"0 to {len(names) - 1}")
        named = f"{names[parent]!r} and {names[child]!r}"
        if parent == child:
            raise InputError(where, f"{names[parent]!r} is paired with itself", "two different sensors")
        if parent in parents.get(child, ()):
            raise InputError(where, f"{named} are listed twice", "each pair once")
        above, seen = [parent], {parent}
        while above:
            further = parents.get(above.pop(), set()) - seen
            seen |= further
            above += further
        if child in seen:
            raise InputError(where, f"{named} close a loop", "(parent, child), parents towards the root",
                             "remove a pair, or swap its two names")
        parents.setdefault(child, set()).add(parent)


@dataclass(frozen=True, slots=True)
class Port:
    """One input or output of a block or plant.

    Attributes
    ----------
    name: as wires name it.
    shape: () for a float; None is a size that the source of the wire decides.
    unit: SI, as text ("rad", "m/s^2"; "1" for a ratio); a wire joins equal units only.
    initial: what an input reads before its first message, and what an output gives in place of a
        non-finite value (its safe output); a float fills the shape.
    optional: an input that may be left without a wire; it then reads `initial` for ever.
    gaps: an output that may contain NaN, where the sample of one sensor of several was lost. Infinite values
        are replaced as everywhere.
    every: an input of which no message may go unread, such as pulses: its block must step as often as its
        source puts them out, and what a pulse does lasts until the next of its train.
    sensors: of an output, the sensors that its rows are samples of; blocks that are wired to it receive
        them (`with_sensors`).
    rows: of an output, names of its rows, such as joints; empty: those of `sensors`, or numbers.
    """

    name: str
    shape: tuple[int | None, ...] = ()
    unit: str = "1"
    initial: float | tuple[float, ...] = 0.0
    optional: bool = False
    gaps: bool = False
    every: bool = False
    sensors: Sensors | None = None
    rows: tuple[str, ...] = ()

    @property
    def row_names(self) -> tuple[str, ...]:
        """Names of the rows, as far as they are stated; empty where they are not."""
        return self.rows or (self.sensors.names if self.sensors is not None else ())

    @property
    def resolved(self) -> bool:
        """True if every size is known."""
        return None not in self.shape

    def initial_value(self) -> Value:
        """The initial value in the port's shape."""
        if self.shape == ():
            return float(np.asarray(self.initial).reshape(()))
        sizes = tuple(size for size in self.shape if size is not None)
        value = np.broadcast_to(np.asarray(self.initial, dtype=np.float64), sizes).copy()
        value.flags.writeable = False
        return value


class Sample(NamedTuple):
    """A value on a wire with its stamps, all ns.

    `oldest_ns` and `newest_ns` are the physical instants of the oldest and the newest capture that the
    value derives from, through any number of blocks; `arrived_ns` is when it reached this port.
    Before the first message all three are NEVER.
    """

    value: Value
    oldest_ns: int
    newest_ns: int
    arrived_ns: int

    @property
    def present(self) -> bool:
        """True once a message has arrived."""
        return self.arrived_ns >= 0

    def age_ns(self, now_ns: int) -> int:
        """Time since the oldest capture behind this value; FOREVER before the first message.

        A value without a capture is older than any limit.
        """
        return now_ns - self.oldest_ns if self.arrived_ns >= 0 else FOREVER
