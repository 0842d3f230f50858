"""Assembly of a wiring for a run: a link for each wire, a station for each plant and block."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import repeat
from math import isfinite
from time import perf_counter_ns
from typing import Any

import numpy as np

from fesloop.errors import RunError
from fesloop.loop.abilities import StepsThrough, offers
from fesloop.loop.block import Tick
from fesloop.loop.clock import NS_PER_MS, ticks_from
from fesloop.loop.nodes import Connection, Node
from fesloop.loop.noise import NoiseStream, stream_key
from fesloop.loop.order import Sampling, upstream_first
from fesloop.loop.plants import (
    ExactStation,
    GridStation,
    PlantInputs,
    PlantRecord,
    PlantStation,
    Publisher,
    Sampler,
)
from fesloop.loop.record import BlockRow, EventRow, Recorder
from fesloop.loop.signals import (
    NEVER,
    Outputs,
    Port,
    Sample,
    Value,
    finite_check,
    is_finite,
    is_ours,
    read_only,
    require_stacks,
)
from fesloop.loop.wire import Link
from fesloop.loop.wiring import Wiring

_new_tuple = tuple.__new__
"""Makes a Sample of a message without the cost of its argument handling."""
Outgoing = tuple[tuple[int, Link], ...]
"""(port number, link) of the values that links carry."""


def empty_sample(port: Port) -> Sample:
    """Sample of an input before its first message."""
    return Sample(port.initial_value(), NEVER, NEVER, NEVER)


class BlockStation:
    """Steps a block: inputs read, outputs stamped, checked, sent, recorded.

    Outputs are sent as the block steps; with an execution time they leave that much later, which a link
    treats as part of the way. A tick that falls due before then is skipped and recorded.

    An output is as old as the oldest of what the block has read. A wired input that nothing has reached yet
    counts as captured when the trial began, so that outputs that a block derives from the initial value do
    not look fresh. A block without wired inputs is a source: its outputs are of the instant of its step. A
    step that puts out nothing sends no message and leaves no row: its readers keep their last sample.
    """

    __slots__ = ("_checks", "_draws", "_executed", "_execution", "_guarded", "_incoming", "_next_tick",
                 "_outputs", "_plain", "_publishers", "_random", "_recorded", "_singles", "_step", "_take",
                 "block", "busy_until", "clock", "due", "events", "held", "index", "name", "plain_links",
                 "rows", "sent", "state", "tick")

    def __init__(self, node: Node, state: Any, seed: int, trial: int, incoming: Outgoing,
                 outgoing: Outgoing, publishers: tuple[Publisher, ...], rows: list[BlockRow] | None,
                 events: list[EventRow]) -> None:
        clock = node.clock
        assert clock is not None
        self.name, self.block, self.state = node.name, node.block, state
        self.clock = clock
        self._next_tick = ticks_from(clock, 0)
        self.due = self._next_tick()
        self.rows, self.events = rows, events
        self.plain_links = [link for _, link in outgoing if link.plain]
        self._plain = tuple((port, link.queue, link.latency_ns)
                            for port, link in outgoing if link.plain)
        self._random = tuple((port, link.send) for port, link in outgoing if not link.plain)
        self._checks = tuple(finite_check(port) for port in self.block.outputs)
        self._outputs = Outputs(node.name, self.block.outputs)
        self._take = self._outputs.take
        self.sent = 0
        self.held = [empty_sample(port) for port in self.block.inputs]
        self.tick = Tick()
        self.index = self.busy_until = self._executed = 0
        self._incoming = tuple((port, link, link.queue) for port, link in incoming)
        self._guarded = () if is_ours(self.block) else tuple(port for port, _ in incoming)
        self._singles = tuple(port for port, _ in incoming if self.block.inputs[port].shape == (1,))
        self._publishers = publishers
        self._step = self.block.step
        self._execution = None if node.execution.kind == "zero" else node.execution
        self._draws = NoiseStream(stream_key(seed, f"{node.name}/execution", trial), 1, "uniform")
        recorded = node.execution.recorded_ns
        self._recorded = recorded[trial] if recorded is not None and trial < len(recorded) else ()

    def fire(self, time_ns: int) -> int:
        """Run one tick; return the next instant to fire."""
        index = self.index
        self.index = index + 1
        self.due = due = self._next_tick()
        if time_ns < self.busy_until:
            self.events.append((time_ns, self.name, "skipped",
                                f"tick {index}: busy until {self.busy_until / NS_PER_MS:.6f} ms"))
            return due
        oldest, newest = self.read(time_ns)
        tick = self.tick
        tick.index, tick.time_ns = index, time_ns
        left = time_ns
        if self._execution is None:
            values = self._step(self.state, self.held, tick)
        else:
            started = perf_counter_ns()
            values = self._step(self.state, self.held, tick)
            left += self._duration_ns(index, perf_counter_ns() - started)
            self.busy_until = left
        if tick.captured_ns != NEVER:
            oldest = newest = self._captured_ns(time_ns)
        values = self._take(values)
        for finite, value in zip(self._checks, values, strict=False):
            if not finite(value):
                values = self._made_safe(values)
                break
        if tick.reports:
            self._record_reports(time_ns)
        if self._checks and not values:
            return due
        for port, queue, latency in self._plain:
            queue.append((values[port], oldest, newest, left + latency))
        for port, send in self._random:
            send(index, values[port], oldest, newest, left)
        self.sent += 1
        if self.rows is not None:
            self.rows.append((index, time_ns, left, oldest, newest, values))
        return due

    def read(self, time_ns: int) -> tuple[int, int]:
        """Take into `held` what has arrived by `time_ns`; return the oldest and the newest capture of all."""
        for publisher in self._publishers:
            if publisher.due <= time_ns:
                publisher.until(time_ns)
        held = self.held
        oldest = newest = NEVER
        for port, link, queue in self._incoming:
            if queue and queue[0][3] <= time_ns:
                if link.plain:
                    message = queue.popleft()
                    while queue and queue[0][3] <= time_ns:
                        message = queue.popleft()
                    held[port] = _new_tuple(Sample, message)
                else:
                    held[port] = link.take_due(time_ns, held[port])
            _, old, new, arrived = held[port]
            if arrived >= 0:
                if old < oldest or oldest < 0:
                    oldest = old
                if new > newest:
                    newest = new
            else:
                oldest = 0  # an initial value is as old as the trial
        for port in self._guarded:
            held[port] = held[port]._replace(value=read_only(held[port].value))
        for port in self._singles:
            if isinstance(held[port][0], float):  # a number is read as a vector of one
                held[port] = held[port]._replace(value=np.array([held[port][0]]))
        if newest < 0:
            oldest = newest = 0 if self._incoming else time_ns
        return oldest, newest

    @property
    def newest(self) -> Sequence[Value | None]:
        """Newest value of each output; None before the first."""
        return self._outputs.newest

    def skip(self, why: str) -> None:
        """Skip the tick that is due, and record that."""
        self.events.append((self.due, self.name, "skipped", f"tick {self.index}: {why}"))
        self.index += 1
        self.due = self._next_tick()

    def _captured_ns(self, time_ns: int) -> int:
        """Capture time that the block has set, moved into the trial and not after now."""
        given_ns, self.tick.captured_ns = self.tick.captured_ns, NEVER
        possible_ns = min(max(given_ns, 0), time_ns)
        if possible_ns != given_ns:
            self.tick.report("impossible_capture", f"at {given_ns / NS_PER_MS:g} ms, which is "
                             + ("yet to come" if given_ns > time_ns else "before the trial"))
        return possible_ns

    def _duration_ns(self, index: int, wall_ns: int) -> int:
        """Duration of this step on the loop's clock."""
        execution = self._execution
        assert execution is not None
        executed = self._executed
        self._executed += 1
        if execution.kind == "measured":
            return round(wall_ns * execution.scale)
        if execution.kind == "recorded":
            if executed >= len(self._recorded):
                raise RunError(f"{self.name}: no execution time is recorded for its step {executed}")
            return self._recorded[executed]
        return execution.draw_ns(float(self._draws.row(index)[0]) if execution.random else 0.0)

    def _made_safe(self, values: Sequence[Value]) -> tuple[Value, ...]:
        """The outputs with every non-finite value replaced by its port's safe one, and that reported."""
        safe = list(values)
        for i, port in enumerate(self.block.outputs):
            if not self._checks[i](values[i]):
                safe[i] = port.initial_value()
                self.tick.report("non_finite", f"output {port.name}: its safe value takes its place")
        return tuple(safe)

    def _record_reports(self, time_ns: int) -> None:
        """Move what the step reported into the event record."""
        for status, detail in self.tick.reports:
            self.events.append((time_ns, self.name, status, detail))
        self.tick.reports.clear()

    def save(self) -> Any:
        """Return everything that changes, for a snapshot."""
        return self.index, self.busy_until, self._executed, self.sent, self.state, list(self.held), \
            self._outputs.save()

    def restore(self, saved: Any) -> None:
        """Restore what `save` returned."""
        self.index, self.busy_until, self._executed, self.sent, self.state, held, outputs = saved
        self._outputs.restore(outputs)
        self.held[:] = held
        self._next_tick = ticks_from(self.clock, self.index)
        self.due = self._next_tick()


def _passes(check: Callable[[Any], bool], value: Value) -> bool:
    return check(value)


class AheadStation(BlockStation):
    """Steps a block through all ticks up to the next at which one of its inputs may change, in one call.

    Outputs are sent and recorded with the stamps of their ticks; messages that are under way early are read
    when they are due. Reports are kept until the instant of their tick, so that events stay in order.

    Attributes
    ----------
    until_ns: no tick beyond this instant is run ahead.
    """

    __slots__ = ("_ahead", "_ports", "_reported", "_sources", "_steps_through", "until_ns")

    def __init__(self, *given: Any) -> None:
        super().__init__(*given)
        self._ports = tuple(self.block.outputs)
        assert offers(self.block, StepsThrough)
        self._steps_through = self.block.steps_through
        self._sources: tuple[tuple[BlockStation, int], ...] = ()
        self._reported: list[EventRow] = []
        self._ahead: list[Tick] = []
        self.until_ns = -1

    def follow(self, sources: Iterable[tuple[BlockStation, int]]) -> None:
        """Set the stations that feed the inputs, with the latency of the wire, ns."""
        self._sources = tuple(sources)

    def fire(self, time_ns: int) -> int:
        """Run the ticks that are due, and those whose inputs are known; return the next instant to fire."""
        if time_ns < self.due:
            return self._report_due(time_ns)
        last = min(self.until_ns, *[source.due + latency - 1 for source, latency in self._sources])
        if last <= time_ns:
            return super().fire(time_ns)
        dues, due, next_tick = [time_ns], self._next_tick(), self._next_tick
        while due <= last:
            dues.append(due)
            due = next_tick()
        if len(dues) == 1:
            self._next_tick = ticks_from(self.clock, self.index + 1)
            return super().fire(time_ns)
        self.due = due
        self._run(dues)
        return self._report_due(time_ns)

    def _run(self, dues: Sequence[int]) -> None:
        """Run the ticks at these instants."""
        index, count = self.index, len(dues)
        self.index = index + count
        while len(self._ahead) < count:
            self._ahead.append(Tick())
        ticks, read = self._ahead[:count], []
        columns: list[list[Sample]] = [[] for _ in self.held]
        for k, (tick, instant) in enumerate(zip(ticks, dues, strict=True)):
            tick.index, tick.time_ns = index + k, instant
            read.append(self.read(instant))
            for column, sample in zip(columns, self.held, strict=True):
                column.append(sample)
        stacks = self._steps_through(self.state, columns, ticks)
        require_stacks(self.name, self._ports, stacks, count)
        outputs = [list(stack) for stack in stacks]
        if not all(is_finite(stack) if isinstance(stack, np.ndarray) else all(map(isfinite, stack))
                   for stack in stacks):
            self._make_safe(ticks, outputs)
        for tick, instant in zip(ticks, dues, strict=True):
            if tick.reports:
                self._reported += [(instant, self.name, *report) for report in tick.reports]
                tick.reports.clear()
        oldest, newest = [stamps[0] for stamps in read], [stamps[1] for stamps in read]
        for port, queue, latency in self._plain:
            arrivals = [instant + latency for instant in dues] if latency else dues
            queue.extend(zip(outputs[port], oldest, newest, arrivals, strict=True))
        for port, send in self._random:
            for k, instant in enumerate(dues):
                send(index + k, outputs[port][k], oldest[k], newest[k], instant)
        if self.rows is not None:
            values = zip(*outputs, strict=True) if outputs else repeat((), count)
            numbers = range(index, index + count)
            self.rows.extend(zip(numbers, dues, dues, oldest, newest, values, strict=True))
        self.sent += count

    def _make_safe(self, ticks: Sequence[Tick], outputs: Sequence[list[Value]]) -> None:
        """Replace outputs of ticks that are not finite by safe ones, and have that reported."""
        for k, tick in enumerate(ticks):
            values = [output[k] for output in outputs]
            if not all(map(_passes, self._checks, values)):
                self.tick = tick
                for output, value in zip(outputs, self._made_safe(values), strict=True):
                    output[k] = value

    def _report_due(self, time_ns: int) -> int:
        """Move reports of ticks up to an instant into the event record; return the next instant to fire."""
        reported = self._reported
        while reported and reported[0][0] <= time_ns:
            self.events.append(reported.pop(0))
        return reported[0][0] if reported else self.due

    def restore(self, saved: Any) -> None:
        """Restore what `save` returned."""
        super().restore(saved)
        self._reported.clear()

    def forget_after(self, time_ns: int) -> None:
        """Remove the rows of ticks after an instant, which a run that failed there did not reach."""
        while self.rows and self.rows[-1][1] > time_ns:
            self.rows.pop()


def sampled_in_order(wiring: Wiring) -> frozenset[str]:
    """Names of the plants that are sampled by events in the wiring's order.

    The outputs of a plant with feedthrough depend on what blocks send at the same instant: it, and any plant
    that exchanges with it, waits for them. All others are sampled when their outputs are read.
    """
    direct = {node.name for node in wiring.nodes if node.is_plant and node.plant.feedthrough}
    return frozenset(name for name, members in _groups(wiring).items() if members & direct)


def publishers(wiring: Wiring, samplers: Sequence[Sampler]) -> dict[str, Publisher]:
    """Publishers, by plant that needs no events; plants that exchange share one."""
    ordered = sampled_in_order(wiring)
    made: dict[int, Publisher] = {}
    found = {}
    for name, members in _groups(wiring).items():
        if name not in ordered:
            own = [_of(together, samplers) for together in upstream_first(members, wiring.connections)]
            found[name] = made.setdefault(id(members), Publisher(own))
    return found


def _groups(wiring: Wiring) -> dict[str, set[str]]:
    """Names of all plants that a plant exchanges with, by plant; one set per group."""
    group = {node.name: {node.name} for node in wiring.nodes if node.is_plant}
    for connection in wiring.connections:
        if connection.source.is_plant and connection.target.is_plant and connection.heard:
            joined = group[connection.source.name] | group[connection.target.name]
            for name in joined:
                group[name] = joined
    return group


def _of(plants: Iterable[str], samplers: Sequence[Sampler]) -> list[Sampler]:
    names = set(plants)
    return [sampler for sampler in samplers if sampler.plant.name in names]


_Ends = Sequence[tuple[Connection, Link]]


@dataclass(frozen=True, slots=True, eq=False)
class Assembly:
    """Everything at t = 0 of a trial.

    Attributes
    ----------
    links: of the wiring's connections, in their order.
    plants, blocks: stations; plants by name, blocks in the order of their steps.
    samplers: of plant outputs, in the wiring's order.
    publishers: by plant that is sampled when its outputs are read.
    """

    links: list[Link]
    plants: dict[str, PlantStation]
    samplers: list[Sampler]
    publishers: dict[str, Publisher]
    blocks: list[BlockStation]


def assembled(wiring: Wiring, trial: int, states: Mapping[str, Any], recorder: Recorder | None,
              events: list[EventRow]) -> Assembly:
    """A wiring with the state of each node; the recorder, if any, gets a list of rows for each stream."""
    links = [Link(connection.wire, wiring.seed, trial) for connection in wiring.connections]
    ends = list(zip(wiring.connections, links, strict=True))
    plants = {node.name: _plant_station(node, states[node.name], ends, recorder, events)
              for node in wiring.nodes if node.is_plant}
    samplers = [_sampler(each, plants, ends) for each in wiring.order if isinstance(each, Sampling)]
    published = publishers(wiring, samplers)
    blocks = [_block_station(each, states[each.name], ends, wiring.seed, trial, published, recorder, events)
              for each in wiring.order if isinstance(each, Node)]
    stations = {block.name: block for block in blocks}
    for block in blocks:
        if isinstance(block, AheadStation):
            block.follow((stations[connection.source.name], link.latency_ns)
                         for connection, link in ends if connection.target.name == block.name)
    return Assembly(links, plants, samplers, published, blocks)


def _incoming(node: Node, ends: _Ends) -> tuple[tuple[int, Link], ...]:
    return tuple((connection.target_port, link) for connection, link in ends if connection.target is node)


def _plant_station(node: Node, state: Any, ends: _Ends, recorder: Recorder | None,
                   events: list[EventRow]) -> PlantStation:
    plant = node.plant
    input_rows = rows = clock = None
    if recorder is not None:
        input_rows = recorder.inputs.setdefault(node.name, [])
        rows = recorder.plants.setdefault(node.name, [])
        clock = recorder.plant_clock
    inputs = PlantInputs(plant, _incoming(node, ends), input_rows)
    sampled = {connection.source_port for connection, _ in ends
               if connection.source is node and connection.heard}
    record = PlantRecord(node.name, plant, rows, clock, sampled)
    if plant.grid is None:
        return ExactStation(node.name, plant, state, inputs, record)
    return GridStation(node.name, plant, state, inputs, record, plant.grid, events)


def _sampler(sampling: Sampling, plants: Mapping[str, PlantStation], ends: _Ends) -> Sampler:
    members = {id(connection) for connection in sampling.connections}
    outgoing = tuple((connection.source_port, link) for connection, link in ends if id(connection) in members)
    return Sampler(plants[sampling.plant.name], sampling.clock, outgoing, sampling.observing)


def _block_station(node: Node, state: Any, ends: _Ends, seed: int, trial: int,
                   published: Mapping[str, Publisher], recorder: Recorder | None,
                   events: list[EventRow]) -> BlockStation:
    outgoing = tuple((connection.source_port, link) for connection, link in ends if connection.source is node)
    read = {connection.source.name for connection, _ in ends if connection.target is node}
    sampled = {id(publisher): publisher for name, publisher in published.items() if name in read}
    rows = None if recorder is None else recorder.blocks.setdefault(node.name, [])
    feeding = [(connection, link) for connection, link in ends if connection.target is node]
    # What a plant will put out depends on what reaches it until then, and jitter may bring a message early.
    ahead = (offers(node.part, StepsThrough) and node.execution.kind == "zero" and bool(feeding)
             and all(link.plain and not connection.source.is_plant for connection, link in feeding))
    return (AheadStation if ahead else BlockStation)(
        node, state, seed, trial, _incoming(node, ends), outgoing, tuple(sampled.values()),
                        rows, events)
