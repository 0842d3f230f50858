"""Surroundings of a block: facts about the loop around it that are known before a run.

The member `faults(context, surroundings)` of a block is called when an experiment is made, so that
`fesloop check`, and not a run, names what cannot work in its place, such as a horizon that ends before the
loop's delay does. The member `cautions_in_place(context, surroundings)` yields warnings about its place.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.loop.abilities import (
    AgeLimit,
    Attaches,
    Captures,
    ChecksPlace,
    Closes,
    Delays,
    LimitsAge,
    Surroundings,
    WarnsInPlace,
    offers,
)
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import FOREVER, NS_PER_MS, NS_PER_S, Clock, RateClock, waits_for_arrivals
from fesloop.loop.duration import ZERO
from fesloop.loop.latency import LatencyReport
from fesloop.loop.nodes import Connection, Node
from fesloop.loop.run import Loop
from fesloop.loop.signals import Port, Sample, Value
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
    return Surroundings(loop_ns=loop_ns, way=way, coming=coming, followers=_followers(wiring, node))


def _followers(wiring: Wiring, node: Node) -> dict[str, str]:
    """Readers of a node that follow it in no fixed time, by its output port."""
    found: dict[str, str] = {}
    for each in wiring.connections:
        reader = each.target
        if each.source is not node or not offers(reader.part, Delays):
            continue
        read = each.target.part.inputs[each.target_port].name
        for passage in reader.part.passages(reader.context(wiring.seed, 0)):
            if passage.later and read in passage.inputs:
                port = node.part.outputs[each.source_port].name
                found[port] = f"{reader.name!r} follows it {passage.later}"
    return found


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


STATUS, OFTEN = "always_too_old", "often_too_old"
_SHARE = 0.01
"""Share of ticks at which an input is too old, above which it is reported (chosen)."""
_HORIZON_NS = 10 * NS_PER_S
"""Horizon of the search (chosen: a wire takes some seconds at the most)."""
_MOST_STEPS = 200_000
"""Greatest number of ticks of all substitutes together (chosen: about a second of wall time)."""


def always_too_old(wiring: Wiring, duration_ns: int) -> list[tuple[str, str, str]]:
    """(node, status, detail) of each input that is older than its block allows whenever it is read."""
    return [each for each in too_old(wiring, duration_ns) if each[1] == STATUS]


def too_old(wiring: Wiring, duration_ns: int) -> list[tuple[str, str, str]]:
    """(node, status, detail) of each input that is older than its block allows, always or often.

    Ticks before `limit_ms` has passed do not count: nothing is old then.
    """
    connections = {(c.target.name, c.target.part.inputs[c.target_port].name): c for c in wiring.connections}
    watched = [(node, limit, connections[node.name, limit.port]) for node in wiring.nodes
               if offers(node.part, LimitsAge)
               for limit in node.part.age_limits() if (node.name, limit.port) in connections]
    if not watched:
        return []
    kept = _upstream(wiring, [node for node, *_ in watched])
    horizon_ns = min(duration_ns, _HORIZON_NS, round(_MOST_STEPS / _ticks_per_s(wiring, kept) * NS_PER_S))
    looks = [_Look(connection.target_port, limit) for _, limit, connection in watched]
    ages: _Ages = {}
    replaced = [_substitute(node, [look for look, (of, *_) in zip(looks, watched, strict=True) if of is node],
                            ages) for node in wiring.nodes if node.name in kept]
    wires = [each.wire for name in kept for each in _into(wiring, name)]
    Loop(Wiring(replaced, wires, wiring.seed)).run_until(max(horizon_ns - 1, 0))
    found = []
    for look, (node, _, connection) in zip(looks, watched, strict=True):
        if look.old and not look.sound:
            found.append((node.name, STATUS, _in_words(wiring, node, look, horizon_ns)))
        elif look.old > _SHARE * (look.old + look.sound):
            origin = _origin(wiring, connection, look.limit, ages)
            found.append((node.name, OFTEN, _often_in_words(node, look, origin)))
    return found


_Ages = dict[tuple[str, int, str], tuple[float, int]]
"""By node, number of an input, and "oldest" or "newest": the sum of its ages, ns, and number of ticks."""


@dataclass(slots=True)
class _Look:
    """Ages of an input: numbers of ticks at which it is too old, and at which it is not.

    Attributes
    ----------
    least_ns, most_ns: of the age of what was captured after the trial began.
    """

    port: int
    limit: AgeLimit
    old: int = 0
    sound: int = 0
    least_ns: int = FOREVER
    most_ns: int = 0

    def take(self, sample: Sample, now_ns: int) -> None:
        """Note the age at one tick."""
        limit_ns = self.limit.limit_ms * NS_PER_MS
        if now_ns <= limit_ns:
            return
        stamp_ns = sample.oldest_ns if self.limit.since == "oldest" else sample.newest_ns
        if sample.present and now_ns - stamp_ns <= limit_ns:
            self.sound += 1
            return
        self.old += 1
        if stamp_ns > 0:
            self.least_ns = min(self.least_ns, now_ns - stamp_ns)
            self.most_ns = max(self.most_ns, now_ns - stamp_ns)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Block:
    """Substitute of a block: steps at its ticks, computes nothing, and notes ages."""

    inputs: tuple[Port, ...]
    outputs: tuple[Port, ...]
    looks: Sequence[_Look]
    name: str
    ages: _Ages
    captures: bool

    def init(self, context: Context) -> None:
        return None

    def step(self, state: None, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        for look in self.looks:
            look.take(inputs[look.port], tick.time_ns)
        for port, sample in enumerate(inputs):
            for since, stamp_ns in (("oldest", sample.oldest_ns), ("newest", sample.newest_ns)):
                if sample.present:
                    total, ticks = self.ages.get((self.name, port, since), (0.0, 0))
                    self.ages[self.name, port, since] = total + (tick.time_ns - stamp_ns), ticks + 1
        if self.captures:
            tick.captured_ns = tick.time_ns
        return (0.0,) * len(self.outputs)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Plant:
    """Substitute of a plant, without inputs: captures are new, whatever reached the plant."""

    outputs: tuple[Port, ...]
    grid: RateClock | None
    inputs: tuple[Port, ...] = ()
    feedthrough: bool = False

    def init(self, context: Context) -> None:
        return None

    def advance(self, state: None, inputs: Sequence[Value], start_ns: int, stop_ns: int) -> None:
        return None

    def read(self, state: None, inputs: Sequence[Value]) -> tuple[Value, ...]:
        return (0.0,) * len(self.outputs)


def _substitute(node: Node, looks: Sequence[_Look], ages: _Ages) -> Node:
    inputs, outputs = (tuple(Port(port.name, optional=True) for port in ports)
                       for ports in (node.part.inputs, node.part.outputs))
    if node.is_plant:
        return Node(node.name, _Plant(outputs=outputs, grid=node.plant.grid))
    clock: Any = node.clock
    if waits_for_arrivals(clock):
        clock = replace(clock, arrivals="")
    # A measured execution time is not known beforehand; zero makes nothing younger.
    execution = ZERO if node.execution.kind == "measured" else node.execution
    return Node(node.name, _Block(inputs=inputs, outputs=outputs, looks=looks, name=node.name,
                                  ages=ages, captures=_captures(node)), clock, execution=execution)


def _upstream(wiring: Wiring, nodes: Sequence[Node]) -> set[str]:
    """Names of nodes and of all that the stamps of their inputs derive from, back to plants and sources."""
    found, ends = set(), [node.name for node in nodes]
    while ends:
        name = ends.pop()
        if name not in found:
            found.add(name)
            ends += [c.source.name for c in _into(wiring, name)]
    return found


def _into(wiring: Wiring, name: str) -> Iterator[Connection]:
    """Connections to a block; inputs of a plant, or of a block that captures, decide on no stamp."""
    return (c for c in wiring.connections
            if c.target.name == name and not c.target.is_plant and not _captures(c.target))


def _captures(node: Node) -> bool:
    """True for a block whose outputs are captured when it steps."""
    return offers(node.part, Captures) and node.part.captures


def _ticks_per_s(wiring: Wiring, kept: set[str]) -> float:
    clocks: list[Clock | None] = [node.plant.grid if node.is_plant else node.clock
                                  for node in wiring.nodes if node.name in kept]
    clocks += [c.clock for c in wiring.connections if c.source.name in kept]
    return max(1.0, sum(1.0 / clock.period_s for clock in clocks if isinstance(clock, RateClock)))


def _in_words(wiring: Wiring, node: Node, look: _Look, horizon_ns: int) -> str:
    """Message: the input that is too old, the consequence, and the remedy."""
    limit = look.limit
    text = f"{limit.key} is {limit.limit_ms:g} ms, and `{limit.port}` "
    if look.least_ns == FOREVER:
        return (f"{text}derives, up to {horizon_ns / NS_PER_S:g} s, from nothing that was captured after the "
                f"trial began: {limit.then}; look at latency and loss of the wires that lead to it")
    text += f"is at least {look.least_ns / NS_PER_MS:.9g} ms old whenever it is read"
    nodes = _upstream(wiring, [node])
    behind = [each for name in sorted(nodes) for each in _into(wiring, name)]
    slowest = max(behind, key=lambda c: c.wire.latency_ns)
    wire = f" (wire {slowest.wire.name}: {slowest.wire.latency_ns / NS_PER_MS:g} ms)" \
        if slowest.wire.latency_ns else ""
    return (f"{text}: {limit.then}; lower the latency of what leads to it{wire} or raise blocks.{node.name}."
            f"{limit.key} to {-(-look.most_ns // NS_PER_MS)} or more")


def _origin(wiring: Wiring, connection: Connection, limit: AgeLimit, ages: _Ages) -> Connection:
    """Wire from the source or plant with the oldest (or newest) captures behind an input."""
    passed = set()
    while connection.source.name not in passed:
        passed.add(connection.source.name)
        behind = [(total / ticks, each) for each in _into(wiring, connection.source.name)
                  for total, ticks in [ages.get((each.target.name, each.target_port, limit.since), (0.0, 0))]
                  if ticks]
        if connection.source.is_plant or not behind:
            break
        pick = max if limit.since == "oldest" else min
        connection = pick(behind, key=lambda each: each[0])[1]
    return connection


def _often_in_words(node: Node, look: _Look, origin: Connection) -> str:
    """Message: the source that is too old, how often, the consequence, and the remedy."""
    limit, name = look.limit, origin.wire.source
    behind = "" if origin.target is node else f", from which `{limit.port}` derives,"
    share = 100.0 * look.old / (look.old + look.sound)
    remedy = f"raise blocks.{node.name}.{limit.key} to {-(-look.most_ns // NS_PER_MS)} or more"
    if not origin.source.is_plant and isinstance(origin.source.clock, RateClock):
        remedy += f", or the rate of {origin.source.name} ({1.0 / origin.source.clock.period_s:g} Hz)"
    return (f"{name}{behind} is older than {limit.limit_ms:g} ms ({limit.key}) at {share:.2g} % of the "
            f"ticks: {limit.then} then; {remedy}")
