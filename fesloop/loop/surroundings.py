"""Surroundings of a block: facts about the loop around it that are known before a run.

The member `faults(context, surroundings)` of a block is called when an experiment is made, so that
`fesloop check`, and not a run, names what cannot work in its place, such as a horizon that ends before the
loop's delay does. The member `cautions_in_place(context, surroundings)` yields warnings about its place.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.loop.abilities import Attaches, ChecksPlace, Closes, Surroundings, WarnsInPlace, offers
from fesloop.loop.block import Tick
from fesloop.loop.clock import FOREVER, NS_PER_S
from fesloop.loop.latency import LatencyReport
from fesloop.loop.nodes import Node
from fesloop.loop.wiring import Wiring

_MOST_TICKS = 20_000
"""Greatest number of ticks of a source that are computed, as in the latency report."""
_LATENCY_HORIZON_NS = NS_PER_S // 5
"""Horizon for tracing loop latency (chosen: rates of tens of hertz have met by then)."""


def faults_in_place(wiring: Wiring, duration_ns: int) -> list[InputError]:
    """Faults that blocks find in their own parameters for their place, named as in an experiment file."""
    found: list[InputError] = []
    for node in wiring.nodes:
        if offers(node.part, ChecksPlace):
            faults = node.part.faults(node.context(wiring.seed, 0), _of(wiring, node, duration_ns))
            found += [InputError(f"blocks.{node.name}.{fault.where}", fault.found, fault.allowed,
                                 fault.remedy) for fault in faults]
    return found


def cautions_in_place(wiring: Wiring, duration_ns: int) -> list[tuple[str, str, str]]:
    """(node, status, detail) of warnings of blocks about their parameters for their place."""
    found: list[tuple[str, str, str]] = []
    for node in wiring.nodes:
        part = node.part
        if not offers(part, WarnsInPlace):
            continue
        report = _report(wiring, node, duration_ns)
        ways = [(path, around) for path in report.paths if (around := path.around(node)) is not None]
        age_ns: dict[str, float] = {}
        for path, (before_ns, _) in ways:
            into = next(c for c in path.connections if c.target is node)
            port = node.part.inputs[into.target_port].name
            age_ns[port] = max(before_ns, age_ns.get(port, 0.0))
        place = replace(_of(wiring, node, duration_ns), age_ns=age_ns,
                        actuation_ns=max((after_ns for _, (_, after_ns) in ways), default=None))
        found += [(node.name, *each)
                  for each in part.cautions_in_place(node.context(wiring.seed, 0), place)]
    return found


def _report(wiring: Wiring, node: Node, duration_ns: int) -> LatencyReport:
    return LatencyReport(wiring, horizon_ns=min(duration_ns, _LATENCY_HORIZON_NS), through=node)


def _of(wiring: Wiring, node: Node, duration_ns: int) -> Surroundings:
    report = _report(wiring, node, duration_ns)
    ways = [(least_ns, f"{path.name}, {name}" if name else path.name) for path in report.paths
            for lane, name in enumerate(path.lanes) if (least_ns := path.least_ns(lane)) is not None]
    loop_ns, way = max(ways, default=(0, ""))
    coming = {node.part.inputs[connection.target_port].name: put_out(wiring, connection.source,
                                                                       connection.source_port, duration_ns)
              for connection in wiring.connections
              if connection.target is node and is_source(connection.source)}
    return Surroundings(loop_ns=loop_ns, way=way, coming=coming)


def is_source(node: Node) -> bool:
    """True for a block that can be stepped beforehand: no inputs, and no device behind it."""
    outside = offers(node.part, Closes) or offers(node.part, Attaches)
    return not node.is_plant and not node.part.inputs and not outside


def put_out(wiring: Wiring, node: Node, port: int, duration_ns: int) -> NDArray[np.float64]:
    """Outputs of a source on a port in the first trial, stacked."""
    clock = node.clock
    assert clock is not None
    state, tick, values = node.block.init(node.context(wiring.seed, 0)), Tick(), []
    for index in range(_MOST_TICKS):
        tick.index, tick.time_ns = index, clock.tick(index)
        if tick.time_ns >= min(duration_ns, FOREVER):
            break
        if put := node.block.step(state, (), tick):
            values.append(put[port])
    return np.array(values, dtype=np.float64)
