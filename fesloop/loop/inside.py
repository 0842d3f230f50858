"""A block on the way of a sample: which of its steps put out what a message brought, and what that took."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from fesloop.loop.block import Context
from fesloop.loop.clock import FOREVER, NS_PER_S
from fesloop.loop.instants import LOST_AFTER_NS, Traffic
from fesloop.loop.passages import Passage, passage
from fesloop.loop.wiring import Connection

Run = tuple[int, int]
"""First and last number of messages that carry the same sample over a wire."""
_AT_ONCE = Passage(inputs=())


class BlockOnWay:
    """A block between two wires.

    Attributes
    ----------
    reader: when it steps.
    lanes: names of what it serves in turn; empty where it serves all at once.
    slots: ticks after which it serves the same again; 1 where it serves all at once.
    waiting: all that decides, beside wires and clocks, on what it puts out when.
    stages: what takes time in it, in order.
    later: that it acts on what it reads only later, in words; empty where it does not.
    """

    def __init__(self, incoming: Connection, outgoing: Connection, traffic: Traffic,
                 before: Sequence[BlockOnWay]) -> None:
        node, self._transit = incoming.target, traffic.transit(incoming)
        self.reader = traffic.timeline(node)
        port = node.part.inputs[incoming.target_port]
        declared = passage(node, port.name, node.part.outputs[outgoing.source_port].name,
                           Context(node.name, clock=node.clock))
        self._passage = declared or _AT_ONCE
        self._waits = self._passage.delay_ns > 0 or bool(self._passage.lanes)
        self.lanes = self._passage.lanes
        self.slots = max(1, self._passage.slots)
        self.later = f"{node.name} acts on it {self._passage.later}" if self._passage.later else ""
        self._round_ns = self._passage.slots * self.reader.clock.period_s * NS_PER_S
        half_a_tick = 0.5 * self.reader.clock.period_s * NS_PER_S
        # Who must read every pulse remembers it until the next of its train.
        self._remembers_ns = round(before[0]._round_ns - half_a_tick) if before and port.every else 0
        self.waiting = self._passage, self._remembers_ns
        self.stages = (*self._waiting_stages(node.name), f"{node.name} executes")

    def _waiting_stages(self, name: str) -> tuple[str, ...]:
        way = self._passage
        if self._waits and way.since == "read":
            return f"{name} waits for its tick", f"{name}: {way.delay}"
        last = f"{name}: {way.turn}" if way.lanes else f"{name} waits for its tick"
        return (f"{name}: {way.delay}", last) if way.delay_ns else (last,)

    def runs(self, run: Run, lane: int) -> Iterator[Run]:
        """The runs of its messages that carry what a run of messages brought, earliest first."""
        steps = self._steps(run)
        if steps is None:
            return
        first, last = steps
        if not self.lanes:
            yield steps
            return
        slots = self._passage.slots
        for turn in range(first + (lane - first) % slots, last + 1, slots):
            if self.reader.left_ns(turn) is not None:
                yield turn, self._next_turn(turn) - 1 if self._passage.holds else turn

    def _next_turn(self, turn: int) -> int:
        """The step that serves the same lane after step `turn`; one that never comes where none does."""
        clock, following = self.reader.clock, turn + self._passage.slots
        until = min(clock.tick(turn) + LOST_AFTER_NS, FOREVER)
        while clock.tick(following) < until and self.reader.left_ns(following) is None:
            following += self._passage.slots
        return following

    def _steps(self, run: Run) -> tuple[int, int] | None:
        """First and last step whose outputs follow one of the messages; None where none does."""
        span = self._transit.held_span(*run)
        read = None if span is None else self.reader.steps_within(*span)
        if span is None or read is None:
            return None
        if self._remembers_ns > 0:
            begun = self.reader.clock.tick(read[0])
            return self.reader.steps_within(begun, max(begun + self._remembers_ns, begun + 1))
        if not self._waits:
            return read
        tick = self.reader.clock.tick
        begins = self._in_force_ns(tick(read[0]), self._transit.held_at(tick(read[0]), *run)[0])
        ends, after = FOREVER, self.reader.first_step(span[1])
        if after is not None:
            ends = self._in_force_ns(tick(after), self._transit.newest_at(tick(after), run[1] + 1)[0])
        return self.reader.steps_within(begins, ends)

    def _in_force_ns(self, read_ns: int, arrived_ns: int) -> int:
        """From when on what arrived and was then read is in force."""
        way = self._passage
        return read_ns + way.delay_ns if way.since == "read" else arrived_ns + way.delay_ns

    def traced_back(self, number: int, left_ns: int, run: Run) -> tuple[list[int], int, int]:
        """Time spent in each stage of the step `number`, last first; arrival and number of what it read."""
        stepped_ns = self.reader.clock.tick(number)
        read_ns, (arrived_ns, message) = self._read(number, run)
        stages = [left_ns - stepped_ns]
        if self._waits and self._passage.since == "read":
            stages += [stepped_ns - read_ns, read_ns - arrived_ns]
        else:
            delay_ns = self._passage.delay_ns
            stages += [stepped_ns - arrived_ns - delay_ns, *([delay_ns] if delay_ns else [])]
        return stages, arrived_ns, message

    def _read(self, number: int, run: Run) -> tuple[int, tuple[int, int]]:
        """When step `number`, or one before it, read the newest message of a run that it follows; the message
        with its arrival."""
        tick = self.reader.clock.tick
        for step in range(number, -1, -1):
            if self.reader.left_ns(step) is not None:
                held = self._transit.held_at(tick(step), *run)
                if self._in_force_ns(tick(step), held[0]) <= tick(number):
                    return tick(step), held
        raise AssertionError("a step follows what it or one before it has read")
