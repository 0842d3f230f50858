"""A sampled block in operation: what happens at its ticks."""

from __future__ import annotations

from collections.abc import Sequence
from time import perf_counter_ns
from typing import Any

import numpy as np

from fesloop.errors import RunError
from fesloop.loop.block import Tick
from fesloop.loop.clock import NS_PER_MS, ticks_from
from fesloop.loop.guard import Outputs, finite_check
from fesloop.loop.nodes import Node
from fesloop.loop.noise import NoiseStream, stream_key
from fesloop.loop.publish import Publisher
from fesloop.loop.record import BlockRow, EventRow
from fesloop.loop.signals import NEVER, Port, Sample, Value
from fesloop.loop.wire import Link

_new_tuple = tuple.__new__
"""Makes a Sample of a message without the cost of its argument handling."""
Outgoing = tuple[tuple[int, Link], ...]
"""Links with the number of the port whose value they carry."""


def empty_sample(port: Port) -> Sample:
    """What an input holds before its first message."""
    return Sample(port.initial_value(), NEVER, NEVER, NEVER)


class BlockStation:
    """Steps a block: inputs read, outputs stamped, checked, sent, recorded.

    Outputs are sent as the block steps; with an execution time they leave that much later, which a link
    treats as part of the way. A tick that falls due before then is skipped and recorded.

    An output is as old as the oldest of what the block has read. A wired input that nothing has reached yet
    counts as captured when the trial began, so that what a block makes of an assumption in its place is not
    taken for fresh. A block without wired inputs is a source: its outputs are of the instant of its step.
    A step that puts out nothing sends no message and leaves no row: who reads it goes on with what it has.
    """

    __slots__ = ("_checks", "_draws", "_executed", "_execution", "_incoming", "_next_tick",
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
        self._plain = tuple((port, link.queue.append, link.latency_ns)
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
        self._singles = tuple(port for port, _ in incoming if self.block.inputs[port].shape == (1,))
        self._publishers = publishers
        self._step = self.block.step
        self._execution = None if node.execution.kind == "zero" else node.execution
        self._draws = NoiseStream(stream_key(seed, f"{node.name}/execution", trial), 1, "uniform")
        recorded = node.execution.recorded_ns
        self._recorded = recorded[trial] if recorded is not None and trial < len(recorded) else ()

    def fire(self, time_ns: int) -> int:
        """One tick; when to fire next."""
        index = self.index
        self.index = index + 1
        self.due = due = self._next_tick()
        if time_ns < self.busy_until:
            self.events.append((time_ns, self.name, "skipped",
                                f"tick {index}: busy until {self.busy_until / NS_PER_MS:.6f} ms"))
            return due
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
                oldest = 0  # what stands in for it is as old as the trial
        for port in self._singles:
            if isinstance(held[port][0], float):  # a number is read as a vector of one
                held[port] = held[port]._replace(value=np.array([held[port][0]]))
        if newest < 0:
            oldest = newest = 0 if self._incoming else time_ns
        tick = self.tick
        tick.index, tick.time_ns = index, time_ns
        left = time_ns
        if self._execution is None:
            values = self._step(self.state, held, tick)
        else:
            started = perf_counter_ns()
            values = self._step(self.state, held, tick)
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
        for port, append, latency in self._plain:
            append((values[port], oldest, newest, left + latency))
        for port, send in self._random:
            send(index, values[port], oldest, newest, left)
        self.sent += 1
        if self.rows is not None:
            self.rows.append((index, time_ns, left, oldest, newest, values))
        return due

    def skip(self, why: str) -> None:
        """Let the tick that is due pass without a step, and record that."""
        self.events.append((self.due, self.name, "skipped", f"tick {self.index}: {why}"))
        self.index += 1
        self.due = self._next_tick()

    def _captured_ns(self, time_ns: int) -> int:
        """When the block says that its values were captured, within the trial and no later than now."""
        said_ns, self.tick.captured_ns = self.tick.captured_ns, NEVER
        possible_ns = min(max(said_ns, 0), time_ns)
        if possible_ns != said_ns:
            self.tick.report("impossible_capture", f"at {said_ns / NS_PER_MS:g} ms, which is "
                             + ("yet to come" if said_ns > time_ns else "before the trial"))
        return possible_ns

    def _duration_ns(self, index: int, wall_ns: int) -> int:
        """How long this step took on the loop's clock."""
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
                self.tick.report("non_finite", f"output {port.name}: its safe value stands in")
        return tuple(safe)

    def _record_reports(self, time_ns: int) -> None:
        """Move what the step reported into the event record."""
        for status, detail in self.tick.reports:
            self.events.append((time_ns, self.name, status, detail))
        self.tick.reports.clear()

    def save(self) -> Any:
        """All that changes, for a snapshot."""
        return self.index, self.busy_until, self._executed, self.sent, self.state, list(self.held), \
            self._outputs.save()

    def restore(self, saved: Any) -> None:
        """Back to what `save` gave."""
        self.index, self.busy_until, self._executed, self.sent, self.state, held, outputs = saved
        self._outputs.restore(outputs)
        self.held[:] = held
        self._next_tick = ticks_from(self.clock, self.index)
        self.due = self._next_tick()
