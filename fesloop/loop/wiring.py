"""A wiring: nodes and wires, checked as a whole before anything runs."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from copy import copy
from dataclasses import dataclass
from fractions import Fraction
from typing import cast

import numpy as np

from fesloop.errors import InputError, InputErrors
from fesloop.loop.block import Block, Context, Plant
from fesloop.loop.clock import NS_PER_MS, Clock, RateClock, duration_ns
from fesloop.loop.duration import ZERO, Duration
from fesloop.loop.order import firing_order
from fesloop.loop.wire import Wire
from fesloop.loop.wiring_checks import (
    doubled_inputs,
    end_faults,
    fit_faults,
    guard_faults,
    interlock_faults,
    open_inputs,
    resolved,
)


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
        own_clock = getattr(self.part, "clock", None)
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
                             "or let it go by the clock of another block, such as the stimulator's")
        elif self.given_clock is not None and self.offset_ms:
            raise InputError(f"{where}.offset_ms", "given beside a clock", "no offset")
        _ = self.clock
        if self.execution.least_ns < 0:
            raise InputError(f"{where}.execution", "can be negative", "zero or more")

    @property
    def is_plant(self) -> bool:
        """Whether the part is a plant."""
        return hasattr(self.part, "advance")

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
        """The clock that stands in place of a rate."""
        return cast(Clock, self.rate) if hasattr(self.rate, "tick") else None

    @property
    def clock(self) -> Clock | None:
        """When the block steps; None for a plant."""
        if self.is_plant:
            return None
        own: Clock | None = getattr(self.part, "clock", None) or self.given_clock
        if own is not None:
            return own
        offset = duration_ns(self.offset_ms, NS_PER_MS, f"{self.name}.offset_ms")
        return RateClock.from_rate(cast(str, self.rate), offset, f"{self.name}.rate")

    def context(self, seed: int, trial: int) -> Context:
        """What the part may know when it makes its state."""
        clock = self.plant.grid if self.is_plant else self.clock
        return Context(self.name, seed, trial, clock)


@dataclass(frozen=True, slots=True, eq=False)
class Connection:
    """A wire whose ends have been found.

    Attributes
    ----------
    wire: as declared.
    source, target: the nodes.
    source_port, target_port: numbers of the ports.
    clock: when a plant's output is sampled into it; None where the source is a block.
    heard: whether the target takes note of it; what a plant ignores is not sampled for it.
    """

    wire: Wire
    source: Node
    target: Node
    source_port: int
    target_port: int
    clock: Clock | None
    heard: bool = True


class Wiring:
    """Nodes and wires that fit together: names, shapes, units, rates, and no algebraic loop.

    Parameters
    ----------
    nodes, wires: in the order of declaration, which settles ties.
    seed: of everything random.

    Raises
    ------
    InputErrors: every fault found, one line each.
    """

    def __init__(self, nodes: Iterable[Node], wires: Iterable[Wire], seed: int = 0) -> None:
        self.seed = require_count("seed", seed)
        declared = list(nodes)
        wires = list(wires)
        names = [node.name for node in declared]
        for name in names:
            if names.count(name) > 1:
                raise InputError(f"node {name}", "there are two of this name", "unique names")
        by_name = {node.name: node for node in declared}
        faults: list[InputError] = []
        for wire in wires:
            faults += end_faults(wire, by_name)
        faults += doubled_inputs(wires)
        _raise(faults)
        _raise(open_inputs(declared, wires))
        self.nodes = resolved(declared, wires)
        by_name = {node.name: node for node in self.nodes}
        self.connections = tuple(_connect(wire, by_name) for wire in wires)
        for end in self.connections:
            faults += fit_faults(
                end.wire, end.source.part.outputs[end.source_port], end.target.part.inputs[end.target_port],
                end.source.clock or end.clock, end.target.clock)
        _raise(faults + guard_faults(self.connections) + interlock_faults(self.nodes, self.connections))
        self.order = firing_order(self.nodes, self.connections)

    def with_seed(self, seed: int) -> Wiring:
        """The same nodes and wires with another seed, on which nothing that is checked here depends."""
        made = copy(self)
        made.seed = require_count("seed", seed)
        return made

    def node(self, name: str) -> Node:
        """The node of that name; KeyError if there is none."""
        return next(node for node in self.nodes if node.name == name)


def require_count(name: str, value: object) -> int:
    """A number such as a seed's; raises InputError for what is no integer from 0 to below 2^63."""
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or not 0 <= value < 2**63:
        raise InputError(name, f"{value!r}", "an integer from 0 to below 2^63")
    return int(value)


def _raise(faults: Sequence[InputError]) -> None:
    if len(faults) == 1:
        raise faults[0]
    if faults:
        raise InputErrors(list(faults))


def _connect(wire: Wire, nodes: dict[str, Node]) -> Connection:
    """The wire with its ends."""
    source_name, output = wire.source.split(".")
    target_name, given = wire.target.split(".")
    source, target = nodes[source_name], nodes[target_name]
    source_port = [p.name for p in source.part.outputs].index(output)
    target_port = [p.name for p in target.part.inputs].index(given)
    where = f"wire {wire.name}"
    if not source.is_plant:
        if wire.rate is not None:
            raise InputError(f"{where}: rate", f"{source_name!r} is a block and sends when it steps",
                             "no rate on this wire", f"set {source_name}.rate")
        return Connection(wire, source, target, source_port, target_port, None)
    if target.is_plant and wire.rate is None:
        raise InputError(f"{where}: rate", "couples two plants without a communication rate (zero latency)",
                         "a rate in hertz at which they exchange", 'add rate = "1000", say')
    if target.is_plant and target.plant.feedthrough and wire.least_ns == 0:
        raise InputError(f"{where}: latency_ms",
                         f"zero latency into plant {target_name!r}, whose output follows its input at once",
                         "above 0, so that the plants exchange simultaneously")
    heard = not target.is_plant or given not in getattr(target.part, "ignores", ())
    return Connection(wire, source, target, source_port, target_port, wire.clock or target.clock, heard)
