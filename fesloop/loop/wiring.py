"""A wiring: nodes and wires, checked as a whole before anything runs."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from copy import copy

import numpy as np

from fesloop.errors import InputError, InputErrors
from fesloop.loop.abilities import Ignores, offers
from fesloop.loop.nodes import Connection, Node
from fesloop.loop.order import firing_order
from fesloop.loop.wire import Wire
from fesloop.loop.wiring_checks import (
    doubled_inputs,
    end_faults,
    fit_faults,
    guard_faults,
    interlock_faults,
    link_faults,
    open_inputs,
    resolved,
)


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
        faults += link_faults(self.connections)
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
    """The value as an integer, such as a seed; raises InputError unless it is one from 0 to below 2^63."""
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
                         f"zero latency into plant {target_name!r}, with feedthrough",
                         "above 0, so that the plants exchange simultaneously")
    heard = not (target.is_plant and offers(target.part, Ignores) and given in target.part.ignores)
    return Connection(wire, source, target, source_port, target_port, wire.clock or target.clock, heard)
