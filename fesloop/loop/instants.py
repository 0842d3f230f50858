"""Instants of steps and arrivals, in whole ns, computed from a wiring without running it."""

from __future__ import annotations

from bisect import bisect_left

from fesloop.loop.clock import FOREVER, NS_PER_S, Clock
from fesloop.loop.nodes import Connection, Node
from fesloop.loop.noise import NoiseStream, stream_key

LOST_AFTER_NS = 60 * NS_PER_S
"""A sample that has not acted within a minute counts as lost."""


class Timeline:
    """Instants of a block's steps and outputs, without the ticks that it skips while busy.

    Attributes
    ----------
    never_busy: True if it skips none.
    """

    def __init__(self, node: Node, seed: int, trial: int) -> None:
        clock = node.clock
        assert clock is not None
        self.clock: Clock = clock
        self._execution = node.execution
        self._draws = NoiseStream(stream_key(seed, f"{node.name}/execution", trial), 1, "uniform")
        recorded = node.execution.recorded_ns
        self._recorded = recorded[trial] if recorded is not None and trial < len(recorded) else ()
        most, shortest = node.execution.most_ns, getattr(clock, "shortest_ns", 0)
        fixed = recorded is None and not self._execution.random
        self._fixed_ns = self._execution.draw_ns(0.0) if fixed else None
        self.never_busy = node.execution.kind == "measured" or (most is not None and most <= shortest)
        self._executed: list[int] = []  # ticks, and when the outputs of each leave
        self._left: list[int] = []
        self._steps: dict[tuple[int, int], tuple[int, int] | None] = {}

    @property
    def drawn(self) -> bool:
        """True if steps take different times."""
        return self._fixed_ns is None

    def left_ns(self, index: int) -> int | None:
        """Instant at which the outputs of tick `index` leave; None if that tick is skipped or never comes."""
        if self.never_busy:
            instant = self.clock.tick(index)
            return None if instant >= FOREVER else instant + self._duration_ns(index, 0)
        while not self._executed or self._executed[-1] < index:
            # Ticks that pass while the block is busy are not counted one by one: at 1 GHz there are many.
            busy = self._left[-1] if self._left else 0
            tick = max(self._executed[-1] + 1 if self._executed else 0, self.clock.first_at_or_after(busy))
            instant = self.clock.tick(tick)
            if instant >= FOREVER:
                break
            self._left.append(instant + self._duration_ns(tick, len(self._left)))
            self._executed.append(tick)
        at = bisect_left(self._executed, index)
        return self._left[at] if at < len(self._executed) and self._executed[at] == index else None

    def _duration_ns(self, index: int, executed: int) -> int:
        if self._fixed_ns is not None:
            return self._fixed_ns
        if self._execution.kind == "recorded":
            return self._recorded[executed] if executed < len(self._recorded) else 0
        return self._execution.draw_ns(float(self._draws.row(index)[0]))

    def steps_within(self, start_ns: int, stop_ns: int) -> tuple[int, int] | None:
        """First and last executed tick at or after `start_ns` and before `stop_ns`; None if there is none.

        A span without an end counts as one of 60 s.
        """
        span = start_ns, stop_ns
        if span not in self._steps:
            self._steps[span] = self._found_within(start_ns, stop_ns)
        return self._steps[span]

    def first_step(self, time_ns: int) -> int | None:
        """First executed tick at or after `time_ns`; None if there is none within 60 s."""
        index = self.clock.first_at_or_after(time_ns)
        while self.clock.tick(index) < min(time_ns + LOST_AFTER_NS, FOREVER):
            if self.left_ns(index) is not None:
                return index
            index += 1
        return None

    def _found_within(self, start_ns: int, stop_ns: int) -> tuple[int, int] | None:
        first = last = None
        index = self.clock.first_at_or_after(start_ns)
        stop = min(stop_ns, start_ns + LOST_AFTER_NS)
        if self.never_busy:
            last = self.clock.first_at_or_after(stop) - 1
            return (index, last) if index <= last else None
        while self.clock.tick(index) < stop:
            if self.left_ns(index) is not None:
                first, last = index if first is None else first, index
            index += 1
        return None if first is None or last is None else (first, last)


class Samplings:
    """Instants at which a plant is sampled into a wire."""

    def __init__(self, clock: Clock) -> None:
        self.clock = clock

    def left_ns(self, index: int) -> int | None:
        """Instant at which sample `index` is sent."""
        instant = self.clock.tick(index)
        return None if instant >= FOREVER else instant


class Transit:
    """Arrivals of a connection's messages by number."""

    def __init__(self, connection: Connection, sender: Timeline | Samplings, seed: int, trial: int) -> None:
        self._wire, self._sender = connection.wire, sender
        self._noise = self._wire.noise(seed, trial)
        self._losses = self._wire.losses(self._noise)
        self._most_jitter = self._wire.jitter.most_ns or 0
        self._latency_ns, self._least_ns = self._wire.latency_ns, self._wire.least_ns
        self._spans: dict[tuple[int, int], tuple[int, int] | None] = {}
        self._jitter_ns: dict[int, int | None] = {}  # None for what is lost
        self._latest: dict[int, int] = {}  # when all up to one are there, of messages in order

    def arrival_ns(self, index: int) -> int | None:
        """Instant at which message `index` is delivered; None if it is lost or never sent."""
        arrival = self._raw_arrival_ns(index)
        if arrival is None or self._wire.late != "in-order" or not self._wire.jitter.random:
            return arrival
        slowest = self._latency_ns + self._most_jitter
        for before in range(index - 1, -1, -1):
            if before in self._latest:
                arrival = max(arrival, self._latest[before])
                break
            left = self._sender.left_ns(before)
            if left is None:
                continue
            if left + slowest <= arrival:
                break
            earlier = self._raw_arrival_ns(before)
            if earlier is not None:
                arrival = max(arrival, earlier)
        self._latest[index] = arrival
        return arrival

    def _raw_arrival_ns(self, index: int) -> int | None:
        """Arrival before any waiting for predecessors."""
        left = self._sender.left_ns(index)
        if left is None:
            return None
        wire = self._wire
        if not wire.random:
            return left + self._least_ns
        if index not in self._jitter_ns:
            chance, shape = self._noise.row(index)
            lost = self._losses.lost(index, float(chance))
            self._jitter_ns[index] = None if lost else wire.jitter.draw_ns(float(shape))
        jitter_ns = self._jitter_ns[index]
        return None if jitter_ns is None else left + self._latency_ns + jitter_ns

    def first_arrival(self, first: int, last: int | None = None) -> tuple[int, int] | None:
        """(arrival, number) of the earliest to be delivered of messages `first` to `last` (or all later)."""
        best: tuple[int, int] | None = None
        index, silent_from = first, self._sender.clock.tick(first) + LOST_AFTER_NS
        while last is None or index <= last:
            sent = self._sender.clock.tick(index)
            if sent >= FOREVER or sent > silent_from or (best and sent + self._least_ns >= best[0]):
                break
            arrival = self.arrival_ns(index)
            if arrival is not None and (best is None or arrival < best[0]):
                best = arrival, index
            index += 1
        return best

    def held_span(self, first: int, last: int) -> tuple[int, int] | None:
        """From when to before when the port holds one of the messages; None if it never does."""
        messages = first, last
        if messages not in self._spans:
            arrival = self.first_arrival(first, last)
            # Behind a lost message, as most may be, the next that is not lost makes no difference.
            later = None if arrival is None else self.first_arrival(last + 1)
            until = FOREVER if later is None else later[0]
            self._spans[messages] = None if arrival is None or arrival[0] >= until else (arrival[0], until)
        return self._spans[messages]

    def held_at(self, time_ns: int, first: int, last: int) -> tuple[int, int]:
        """(arrival, number) of the newest of messages `first` to `last` that has arrived by `time_ns`."""
        # No later one has been sent long enough ago.
        last = min(last, self._sender.clock.first_at_or_after(time_ns - self._least_ns + 1) - 1)
        for index in range(last, first - 1, -1):
            arrival = self.arrival_ns(index)
            if arrival is not None and arrival <= time_ns:
                return arrival, index
        raise AssertionError("a message that was read must have arrived")

    def newest_at(self, time_ns: int, first: int) -> tuple[int, int]:
        """(arrival, number) of the newest of messages `first` and later that has arrived by `time_ns`."""
        last = first
        while self._sender.clock.tick(last + 1) <= time_ns:
            last += 1
        return self.held_at(time_ns, first, last)


class Traffic:
    """Steps and messages of one trial, computed once for all paths."""

    def __init__(self, seed: int, trial: int) -> None:
        self._seed, self._trial = seed, trial
        self._timelines: dict[str, Timeline] = {}
        self._transits: dict[str, Transit] = {}

    def timeline(self, node: Node) -> Timeline:
        """Timeline of a block."""
        if node.name not in self._timelines:
            self._timelines[node.name] = Timeline(node, self._seed, self._trial)
        return self._timelines[node.name]

    def transit(self, connection: Connection) -> Transit:
        """Arrivals of a connection's messages."""
        name = connection.wire.name
        if name not in self._transits:
            sender = self.timeline(connection.source) if connection.clock is None else Samplings(
                connection.clock)
            self._transits[name] = Transit(connection, sender, self._seed, self._trial)
        return self._transits[name]
