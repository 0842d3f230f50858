"""Several signals as one, such as a wireless sensor's beside those of a cable."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from fesloop.errors import InputError
from fesloop.hand.skeleton import pairs_of_names
from fesloop.loop.block import Context, Tick
from fesloop.loop.record import StatusLatch
from fesloop.loop.signals import Port, Sample, Sensors, Value

_NAMES = ("first", "second", "third", "fourth", "fifth")


@dataclass(frozen=True, slots=True, kw_only=True)
class Join:
    """Puts the rows of several inputs under each other.

    Inputs `first`, `second`, ... (k_i, columns), output `joined` (sum of k_i, columns), all in `unit`; with
    `columns` 0 they are vectors (k_i,). Each input holds its newest message, so that late rows are beside
    fresh ones; the output carries the oldest and the newest capture of all. Rows of an input that nothing
    has reached yet are NaN, and the status "waiting" names it.

    Attributes
    ----------
    unit: of all ports.
    sources: number of inputs, 2 to 5.
    columns: of each input, as of vectors in space; 0: the inputs are vectors.
    rows: k_i of each input; empty takes them from the wires.

    The output states the sensors of all inputs, and their pairs, where every input states its own. Sensors of
    one name in two inputs are called "first.NAME" and "second.NAME". Where all are segments of the hand, they
    are paired as the hand has them, also from one input to another.
    """

    unit: str
    sources: int = 2
    columns: int = 3
    rows: tuple[int, ...] = ()
    _stated: Sensors | None = field(init=False, repr=False, compare=False, default=None)

    def __post_init__(self) -> None:
        if not 2 <= self.sources <= len(_NAMES):
            raise InputError("sources", f"{self.sources}", f"2 to {len(_NAMES)}")
        if self.columns < 0:
            raise InputError("columns", f"{self.columns}", "1 or more, or 0 for vectors")
        if self.rows and (len(self.rows) != self.sources or min(self.rows) < 1):
            raise InputError("rows", f"{self.rows}", f"{self.sources} numbers, 1 or more each")

    @property
    def inputs(self) -> tuple[Port, ...]:
        """`first`, `second` and so on."""
        sizes = self.rows or (None,) * self.sources
        return tuple(Port(name, (size, *self._width), self.unit)
                     for name, size in zip(_NAMES, sizes, strict=False))

    @property
    def outputs(self) -> tuple[Port, ...]:
        """`joined`."""
        return (Port("joined", (sum(self.rows) or None, *self._width), self.unit, gaps=True,
                     sensors=self._stated),)

    @property
    def _width(self) -> tuple[int, ...]:
        return (self.columns,) if self.columns else ()

    def resolve(self, shapes: Mapping[str, tuple[int, ...]]) -> Join:
        """The block for the wired rows; raises InputError for a signal without rows of `columns` numbers."""
        names = _NAMES[:self.sources]
        for name in names:
            if not shapes[name] or shapes[name][1:] != self._width:
                allowed = f"rows of {self.columns} numbers: shape (k, {self.columns})"
                raise InputError(name, f"a signal of shape {shapes[name]} is wired in",
                                 allowed if self.columns else "a vector: shape (k,)")
        return replace(self, rows=tuple(shapes[name][0] for name in names))

    def with_sensors(self, sources: Mapping[str, Sensors]) -> Join:
        """The block with the sensors of all its inputs."""
        joined = replace(self)
        if len(sources) == self.sources:
            object.__setattr__(joined, "_stated", _together({name: sources[name] for name in
                                                             _NAMES[:self.sources]}))
        return joined

    def init(self, context: Context) -> StatusLatch:
        """State without a current status."""
        return StatusLatch()

    def step(self, state: StatusLatch, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """The newest rows."""
        joined = np.empty((sum(self.rows), *self._width))
        first, absent = 0, []
        for name, count, sample in zip(_NAMES, self.rows, inputs, strict=False):
            joined[first:first + count] = sample.value if sample.present else np.nan
            if not sample.present:
                absent.append(name)
            first += count
        if absent or state.holding:
            state.put(tick, "waiting", bool(absent), "nothing has arrived at " + ", ".join(absent))
        return (joined,)


def _together(sources: Mapping[str, Sensors]) -> Sensors:
    """The sensors of several inputs, one after another."""
    every = [name for stated in sources.values() for name in stated.names]
    names: list[str] = []
    pairs: list[tuple[int, int]] = []
    for source, stated in sources.items():
        first = len(names)
        names += [name if every.count(name) == 1 else f"{source}.{name}" for name in stated.names]
        pairs += [(first + parent, first + child) for parent, child in stated.pairs]
    return Sensors(tuple(names), pairs_of_names(names) or tuple(pairs))
