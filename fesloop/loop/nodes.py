"""Nodes of a wiring, and connections: wires with the nodes and ports at their ends."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import cast

from fesloop.errors import InputError
from fesloop.loop.abilities import HasClock, offers
from fesloop.loop.block import Block, Context, Plant, is_plant
from fesloop.loop.clock import NS_PER_MS, Clock, RateClock, duration_ns
from fesloop.loop.duration import ZERO, Duration
from fesloop.loop.wire import Wire


@dataclass(frozen=True, slots=True, eq=False)
class Node:
    """A block or plant with its name and its place in time.

    Attributes
    ----------
    name: unique; wires and recordings use it.
    part: the block or plant.
    rate, offset_ms: when a sampled block steps, Hz and ms; or in place of a rate a Clock, such as that of
        a block that plays a recording, or a stimulator's: Node("electrodes", Electrodes(), stimulator.clock).
        A plant has none, nor has a block with a clock of its own.
    execution: how long a step takes; outputs leave at its end.
    """

    name: str
    part: Block | Plant
    rate: str | int | float | Fraction | Clock | None = None
    offset_ms: float = 0.0
    execution: Duration = ZERO

    def __post_init__(self) -> None:
        where = self.name if isinstance(self.name, str) else repr(self.name)
        if not (where == self.name and where.isascii() and where.replace("_", "a").isalnum()):
            raise InputError(f"node {where}", "is not a name", "letters, digits and underscores")
        if isinstance(self.part, type) or not all(hasattr(type(self.part), each) or hasattr(self.part, each)
                                                  for each in ("inputs", "outputs", "init")):
            raise InputError(f"{where}.part", f"{self.part!r} is {_not_a_part(self.part)}",
                             "an object of a block's or plant's class (fesloop.loop.block)")
        own_clock = self.part.clock if offers(self.part, HasClock) else None
        if self.is_plant:
            if self.rate is not None or self.offset_ms or self.execution.kind != "zero":
                raise InputError(f"{where}.rate", "a plant is continuous: no rate, offset or execution",
                                 "none of them", "give the wire that samples it a rate")
            grid = self.plant.grid
            if grid is not None and grid.offset_ns:
                raise InputError(f"{where}.grid", "does not start at t = 0", "no offset")
        elif own_clock is not None and (self.rate is not None or self.offset_ms):
            raise InputError(f"{where}.rate", "this block has a clock of its own", "no rate and no offset")
        elif own_clock is None and self.rate is None:
            raise InputError(f"{where}.rate", "is missing", 'a positive rate in hertz such as "100"',
                             "or give it the clock of another block, such as the stimulator's")
        elif self.given_clock is not None and self.offset_ms:
            raise InputError(f"{where}.offset_ms", "given beside a clock", "no offset")
        _ = self.clock
        if self.execution.least_ns < 0:
            raise InputError(f"{where}.execution", "can be negative", "zero or more")

    @property
    def is_plant(self) -> bool:
        """True for a plant."""
        return is_plant(self.part)

    @property
    def plant(self) -> Plant:
        """The part, a plant."""
        return cast(Plant, self.part)

    @property
    def block(self) -> Block:
        """The part, a block."""
        return cast(Block, self.part)

    @property
    def given_clock(self) -> Clock | None:
        """Clock given in place of a rate."""
        return None if isinstance(self.rate, str | int | float | Fraction) else self.rate

    @property
    def clock(self) -> Clock | None:
        """Clock of the block's steps; None for a plant."""
        if self.is_plant:
            return None
        own = (self.part.clock if offers(self.part, HasClock) else None) or self.given_clock
        if own is not None:
            return own
        offset = duration_ns(self.offset_ms, NS_PER_MS, f"{self.name}.offset_ms")
        return RateClock.from_rate(cast(str, self.rate), offset, f"{self.name}.rate")

    def context(self, seed: int, trial: int) -> Context:
        """Place of the part in a run, for its state."""
        clock = self.plant.grid if self.is_plant else self.clock
        return Context(self.name, seed, trial, clock)


def _not_a_part(value: object) -> str:
    return f"a class: give an object of it, {value.__name__}(...)" if isinstance(value, type) else "no block"


@dataclass(frozen=True, slots=True, eq=False)
class Connection:
    """A wire with the nodes and ports at its ends.

    Attributes
    ----------
    wire: as declared.
    source, target: the nodes.
    source_port, target_port: numbers of the ports.
    clock: when a plant's output is sampled into it; None where the source is a block.
    heard: False where the target is a plant that ignores the input; the source is then not sampled for it.
    """

    wire: Wire
    source: Node
    target: Node
    source_port: int
    target_port: int
    clock: Clock | None
    heard: bool = True
