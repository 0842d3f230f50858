"""Latency from plant outputs to plant inputs: by stage, exactly, for any tick.

Everything is computed from the wiring in whole ns, without running it, so that a run can be compared with
it. The numbers of jitter, loss and execution times are those of the run: functions of seed, name, trial and
tick. A block's wall time ("measured") is not known beforehand and counts as zero. Waits inside a block count
where the block declares them (`Delays.passages`).

Where nothing on a path is random, the latencies of its samples repeat with the least common multiple of the
periods of its clocks. One such round, each of its samples counted as often as it occurs, is the whole run.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise, product
from operator import mul
from typing import TYPE_CHECKING, Any, NamedTuple

from fesloop.loop.abilities import Delays, KeepsOwnTime, Passage, offers
from fesloop.loop.block import Context
from fesloop.loop.clock import FOREVER, NS_PER_MS, NS_PER_S, Clock, RateClock
from fesloop.loop.nodes import Connection, Node
from fesloop.loop.noise import NoiseStream, stream_key
from fesloop.loop.wire import Wire
from fesloop.loop.wiring import Wiring

if TYPE_CHECKING:
    from fesloop.tables import Table

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
        most, shortest = node.execution.most_ns, clock.shortest_ns
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
        """Start and end of the span in which the port holds one of the messages; None if it never does."""
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


Run = tuple[int, int]
"""First and last number of messages that carry the same sample over a wire."""
_AT_ONCE = Passage(inputs=())


class BlockOnWay:
    """A block of a path, between two wires.

    Attributes
    ----------
    reader: when it steps.
    lanes: names of what it serves in turn; empty where it serves all at once.
    slots: ticks after which it serves the same again; 1 where it serves all at once.
    waiting: everything beside wires and clocks that decides when its outputs follow.
    stages: names of what takes time in it, in order.
    later: sentence that it acts on what it reads only later; empty where it does not.
    """

    def __init__(self, incoming: Connection, outgoing: Connection, traffic: Traffic,
                 before: Sequence[BlockOnWay]) -> None:
        node, self._transit = incoming.target, traffic.transit(incoming)
        self.reader = traffic.timeline(node)
        port = node.part.inputs[incoming.target_port]
        self._passage = _passage(node, port.name, node.part.outputs[outgoing.source_port].name)
        self._waits = self._passage.delay_ns > 0 or bool(self._passage.lanes)
        self.lanes = self._passage.lanes
        self.slots = max(1, self._passage.slots)
        self.later = f"{node.name} acts on it {self._passage.later}" if self._passage.later else ""
        self._round_ns = self._passage.slots * self.reader.clock.period_s * NS_PER_S
        half_a_tick = 0.5 * self.reader.clock.period_s * NS_PER_S
        # A reader of every pulse remembers it until the next of its train.
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
        """Runs of its messages that carry the content of a run of messages, earliest first."""
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
        """Step that serves the same lane after step `turn`; one beyond the clock's last where none does."""
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
        begins = self._takes_effect_ns(tick(read[0]), self._transit.held_at(tick(read[0]), *run)[0])
        ends, after = FOREVER, self.reader.first_step(span[1])
        if after is not None:
            ends = self._takes_effect_ns(tick(after), self._transit.newest_at(tick(after), run[1] + 1)[0])
        return self.reader.steps_within(begins, ends)

    def _takes_effect_ns(self, read_ns: int, arrived_ns: int) -> int:
        """Instant at which a message takes effect that arrived and was then read."""
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
        """Instant at which step `number`, or one before it, read the newest message of the run that it
        follows, and that message with its arrival."""
        tick = self.reader.clock.tick
        for step in range(number, -1, -1):
            if self.reader.left_ns(step) is not None:
                held = self._transit.held_at(tick(step), *run)
                if self._takes_effect_ns(tick(step), held[0]) <= tick(number):
                    return tick(step), held
        raise AssertionError("a step follows what it or one before it has read")


def _passage(node: Node, source: str, target: str) -> Passage:
    """Passage that a block declares from its input `source` to its output `target`."""
    declared = node.part.passages(Context(node.name, clock=node.clock)) if offers(node.part, Delays) else ()
    return next((each for each in declared
                 if source in each.inputs and (not each.outputs or target in each.outputs)), _AT_ONCE)


MEANING = ("From the instant that a sensor captures to the instant that the patient is acted on: behind a "
           "stimulator, a channel's pulse. Least, mean and greatest are over samples and over channels.")
"""Explanation of a budget's numbers, printed below it."""
_MOST_TICKS = 20_000
"""Greatest number of samples of a path that are traced."""
_MOST_IN_ALL, _LEAST_EACH = 50_000, 1000
"""Samples of all paths of a report together, and the fewest of each (chosen: a report of eight channels takes
seconds)."""
_FASTEST_TICKS = 100_000


@dataclass(frozen=True, slots=True)
class TickLatency:
    """Latency of one sampled value along a path.

    Attributes
    ----------
    tick: number of the sampling.
    captured_ns: physical instant of the value.
    acts_ns: when it starts to act on the plant input.
    stages_ns: time spent in each stage, in the order of the path's `stages`; they add up to the total.
    lane: the one of the path's `lanes` that it took.
    """

    tick: int
    captured_ns: int
    acts_ns: int
    stages_ns: tuple[int, ...]
    lane: str = ""

    @property
    def total_ns(self) -> int:
        """Time from capture to effect."""
        return self.acts_ns - self.captured_ns


@dataclass(frozen=True, slots=True)
class StageSummary:
    """Latency of one stage over many ticks, ns; the last of a path is the total."""

    name: str
    least_ns: int
    mean_ns: float
    most_ns: int


class _Known(NamedTuple):
    """Results that hold for all paths of equal timing: tallies, and the least latency of a lane."""

    tallies: dict[Any, list[_Tally]]
    least_ns: dict[Any, int | None]


class PathLatency:
    """A path from a plant output through blocks to a plant input.

    Attributes
    ----------
    connections: along the path.
    stages: names of what takes time, in order; `TickLatency.stages_ns` and `summary` follow it.
    lanes: names of what a block on the way serves in turn, such as a stimulator's channels, where a sample
        reaches each at another time; one lane without a name where there is no such block.
    later: text that names a block that acts on a sample only later, and when; empty where none does. The
        stages of such a path are those of its blocks and wires alone.
    drawn: True where jitter, losses or execution times on the path vary.
    covered_ns: the summaries are of all samples captured before this instant: the horizon, or earlier where
        that would take too long.
    """

    def __init__(self, connections: tuple[Connection, ...], traffic: Traffic, limits: _Limits,
                 known: _Known) -> None:
        self.connections = connections
        self._known = known
        first, last = connections[0], connections[-1]
        assert first.clock is not None
        self._sampling: Clock = first.clock
        self._source_grid = first.source.plant.grid
        self._target_grid = last.target.plant.grid
        self._transit = traffic.transit(last)
        self._blocks: list[BlockOnWay] = []
        for incoming, outgoing in pairwise(connections):
            self._blocks.append(BlockOnWay(incoming, outgoing, traffic, self._blocks[-1:]))
        self._timing = (tuple((c.source.name, c.target.name, c.clock, _timing(c.wire)) for c in connections),
                        tuple(block.waiting for block in self._blocks))
        self.stages = self._stage_names()
        self._turns = tuple(product(*(range(max(1, len(block.lanes))) for block in self._blocks)))
        self.lanes = tuple(
            ", ".join(block.lanes[turn]
                      for block, turn in zip(self._blocks, turns, strict=True) if block.lanes)
            for turns in self._turns)
        self.later = "; ".join(block.later for block in self._blocks if block.later)
        self.drawn = any(c.wire.loss or c.wire.jitter.random for c in connections) or \
            any(block.reader.drawn for block in self._blocks)
        self._samples, self._looks, self._round = self._rounds(limits)
        self.covered_ns = limits.horizon_ns
        if not self._round and self._looks < self._samples:
            self.covered_ns = self._sampling.tick(self._looks)

    def _rounds(self, limits: _Limits) -> tuple[int, int, int]:
        """Number of samples before the horizon, of those traced, and of those after which latencies repeat (0
        where all that count are traced one by one)."""
        samples = self._sampling.first_at_or_after(limits.horizon_ns)
        most = min(samples, limits.samples, self._sampling.first_at_or_after(limits.looks_ns))
        given = [(clock, 1) for clock in (self._sampling, self._source_grid, self._target_grid) if clock]
        given += [(block.reader.clock, block.slots) for block in self._blocks]
        clocks = [(clock, slots) for clock, slots in given if isinstance(clock, RateClock)]
        skips = any(not block.reader.never_busy for block in self._blocks)
        if self.drawn or skips or len(clocks) < len(given):
            return samples, most, 0
        assert isinstance(self._sampling, RateClock)
        round_ns = math.lcm(*(clock.period_num * slots for clock, slots in clocks))
        every = round_ns // self._sampling.period_num * self._sampling.period_den
        looks = every + self._sampling.first_at_or_after(max(clock.offset_ns for clock, _ in clocks))
        return (samples, looks, every) if looks <= most and looks < samples else (samples, most, 0)

    def _times(self, index: int) -> int:
        """Number of samples before the horizon with the latency of sample `index`, which is traced."""
        if not self._round or index < self._looks - self._round:
            return 1
        return -((index - self._samples) // self._round)

    def _stage_names(self) -> tuple[str, ...]:
        names = [f"{self.connections[0].source.name} holds its last step"] if self._source_grid else []
        for connection, block in zip(self.connections, self._blocks, strict=False):
            names += [f"wire {connection.wire.name}", *block.stages]
        names.append(f"wire {self.connections[-1].wire.name}")
        if self._target_grid:
            names.append(f"{self.connections[-1].target.name} waits for its step")
        return tuple(names)

    @property
    def name(self) -> str:
        """Ports and nodes of the path."""
        through = [c.target.name for c in self.connections[:-1]]
        return " -> ".join([self.connections[0].wire.source, *through, self.connections[-1].wire.target])

    def of_tick(self, index: int, lane: int = 0) -> TickLatency | None:
        """Latency of sample `index` by a lane; None if it is lost or overwritten before it acts.

        A block that steps again before the next sample reaches it sends the same sample again, so from the
        second wire on a sample travels in a run of messages, and the first of them that arrives counts.
        """
        carried = self._carried(index, lane)
        return None if carried is None else self._traced_back(index, lane, carried)

    def _carried(self, index: int, lane: int) -> _Carried | None:
        """Messages that carry sample `index` by a lane, and the instant at which it acts."""
        if self._sampling.tick(index) >= FOREVER:
            return None
        return self._onward(0, (index, index), self._turns[lane])

    def _onward(self, number: int, run: Run, turns: tuple[int, ...]) -> _Carried | None:
        """Continuation from block `number` on of what a run of messages carries to it."""
        if number == len(self._blocks):
            return self._at_plant(run)
        block, best = self._blocks[number], None
        for onward in block.runs(run, turns[number]):
            if best is not None and block.reader.clock.tick(onward[0]) >= best.acts_ns:
                break
            found = self._onward(number + 1, onward, turns)
            if found is not None and (best is None or found.acts_ns < best.acts_ns):
                best = found
        return None if best is None else replace(best, runs=(run, *best.runs))

    def _at_plant(self, run: Run) -> _Carried | None:
        span = self._transit.held_span(*run)
        if span is None:
            return None
        acts = span[0]
        if self._target_grid:
            acts = self._target_grid.tick(self._target_grid.first_at_or_after(acts))
        return _Carried((run,), span[0], acts) if acts < span[1] else None

    def _traced_back(self, index: int, lane: int, carried: _Carried) -> TickLatency:
        """Stages of the path that ended with an arrival at the plant, found from its end."""
        stages = [carried.acts_ns - carried.arrival_ns] if self._target_grid else []
        arrived, number = self._transit.held_at(carried.arrival_ns, *carried.runs[-1])
        for block, run in zip(reversed(self._blocks), carried.runs[-2::-1], strict=True):
            left = block.reader.left_ns(number)
            assert left is not None
            stages.append(arrived - left)
            inside, arrived, number = block.traced_back(number, left, run)
            stages += inside
        sent, captured = self._sampling.tick(index), self._captured_ns(index)
        stages.append(arrived - sent)
        if self._source_grid:
            stages.append(sent - captured)
        return TickLatency(index, captured, carried.acts_ns, tuple(reversed(stages)), self.lanes[lane])

    def _captured_ns(self, index: int) -> int:
        """The physical instant of sample `index`: of a fixed-step plant, its last step."""
        sent, grid = self._sampling.tick(index), self._source_grid
        return grid.tick(grid.last_at_or_before(sent)) if grid else sent

    def ticks(self, lane: int | None = None) -> Iterator[TickLatency]:
        """Yield every sample before the horizon (20,000 at most) that acts, by one lane or by each."""
        lanes = range(len(self.lanes)) if lane is None else (lane,)
        found = (self.of_tick(index, each) for index in range(min(self._samples, _MOST_TICKS))
                 for each in lanes)
        return (latency for latency in found if latency is not None)

    def least_ns(self, lane: int = 0) -> int | None:
        """The least time from capture to effect of the samples before `covered_ns`; None if none acts."""
        key = (self._timing, lane)
        if key not in self._known.least_ns:
            totals = (carried.acts_ns - self._captured_ns(index) for index in range(self._looks)
                      if (carried := self._carried(index, lane)) is not None)
            self._known.least_ns[key] = min(totals, default=None)
        return self._known.least_ns[key]

    def summary(self, lane: int | None = None) -> tuple[StageSummary, ...]:
        """Each stage, then the total, over the samples before `covered_ns` that act; empty if none does.

        Least, mean and greatest are over samples and lanes alike, unless one lane is named.
        """
        of_lanes = self._tallies if lane is None else self._tallies[lane:lane + 1]
        tallies = [tally for tally in of_lanes if tally.samples]
        if not tallies:
            return ()
        count = sum(tally.samples for tally in tallies)
        return tuple(
            StageSummary(name, min(tally.least[i] for tally in tallies),
                         sum(tally.sums[i] for tally in tallies) / count,
                         max(tally.most[i] for tally in tallies))
            for i, name in enumerate((*self.stages, "total")))

    def by_lane(self) -> tuple[StageSummary, ...]:
        """Total of each lane on which a sample acts, under the lane's name; empty for a single lane."""
        if len(self.lanes) == 1:
            return ()
        return tuple(replace(summary[-1], name=name) for lane, name in enumerate(self.lanes)
                     if (summary := self.summary(lane)))

    @property
    def _tallies(self) -> list[_Tally]:
        """Tallies of the samples that act, by lane; counted once for all paths with equal timing."""
        if self._timing not in self._known.tallies:
            self._known.tallies[self._timing] = self._counted()
        return self._known.tallies[self._timing]

    def _counted(self) -> list[_Tally]:
        tallies = []
        for lane in range(len(self.lanes)):
            found = [(latency, self._times(index)) for index in range(self._looks)
                     if (latency := self.of_tick(index, lane)) is not None]
            times = [count for _, count in found]
            rows = ((*latency.stages_ns, latency.total_ns) for latency, _ in found)
            columns = list(zip(*rows, strict=True))
            tallies.append(_Tally(sum(times), [min(column) for column in columns],
                                  [sum(map(mul, column, times)) for column in columns],
                                  [max(column) for column in columns]))
        return tallies

    def around(self, node: Node) -> tuple[float, float] | None:
        """Mean time from capture to the tick of a block of the path, and from that tick to effect, ns.

        None if no sample acts.
        """
        tick = 1 if self._source_grid else 0
        for connection, block in zip(self.connections, self._blocks, strict=False):
            tick += 1 + len(block.stages)
            if connection.target is node:
                break
        means = [stage.mean_ns for stage in self.summary()]
        # The last stage of a block is its execution, after its tick.
        return (sum(means[:tick - 1]), sum(means[tick - 1:-1])) if means else None

    @property
    def hold_ns(self) -> float:
        """Mean age that holding adds between two values that act: half the sampling period, ns."""
        return _period_s(self._sampling) * NS_PER_S / 2


class _Tally(NamedTuple):
    """Number of samples that act, and the least, sum and greatest of each stage and the total, ns."""

    samples: int
    least: list[int]
    sums: list[int]
    most: list[int]


class _Limits(NamedTuple):
    """Instant before which samples count, and bounds of those that are traced: an instant and a number."""

    horizon_ns: int
    looks_ns: int
    samples: int


@dataclass(frozen=True, slots=True)
class _Carried:
    """A sample that acts: runs of messages that carry it, a wire each, its arrival and when it acts."""

    runs: tuple[Run, ...]
    arrival_ns: int
    acts_ns: int


class LatencyReport:
    """Every path from a plant output back to a plant input.

    Parameters
    ----------
    wiring: what runs.
    trial: the trial whose random numbers count.
    horizon_ns: end of the samples in the summaries, such as the end of the run; 10 s by default. Each path is
        traced sample by sample up to the 20,000th at most, and the 100,000th tick of the fastest block (fewer
        where there are many paths); where that is not all of it, its `covered_ns` is earlier.
    through: a node that every path leads to or through; None for all paths.

    Attributes
    ----------
    paths: each with its stages.
    not_counted: sentence on the plants between two others whose own time is in no path; empty without any.
    """

    def __init__(self, wiring: Wiring, trial: int = 0, horizon_ns: int | None = None,
                 through: Node | None = None) -> None:
        self.horizon_ns = 10 * NS_PER_S if horizon_ns is None else horizon_ns
        looks_ns = min((_FASTEST_TICKS * node.clock.shortest_ns for node in wiring.nodes
                        if isinstance(node.clock, RateClock)), default=FOREVER)
        traffic = Traffic(wiring.seed, trial)
        known = _Known({}, {})
        ways = [path for path in _paths(wiring.connections)
                if through is None or any(connection.target is through for connection in path)]
        samples = min(_MOST_TICKS, max(_LEAST_EACH, _MOST_IN_ALL // max(1, len(ways))))
        limits = _Limits(self.horizon_ns, looks_ns, samples)
        self.paths = tuple(PathLatency(path, traffic, limits, known) for path in ways)
        self.not_counted = _not_counted(ways)

    def coverage(self, trials: int = 1) -> str:
        """Sentences on what is not counted, and on the samples that count; `trials`: of the run."""
        covered_ns = min((path.covered_ns for path in self.paths), default=self.horizon_ns)
        covered, horizon = (f"{time_ns / NS_PER_S:.9g} s" for time_ns in (covered_ns, self.horizon_ns))
        covers = f"Every sample in the {horizon} of a trial counts."
        if covered_ns < self.horizon_ns:
            covers = (f"Only samples in the first {covered} of a trial of {horizon} count: later ones can "
                      "take longer.")
        drawn = trials > 1 and any(path.drawn for path in self.paths)
        drawn_as = f"What is random is as in the first of {trials} trials." if drawn else ""
        return " ".join(filter(None, (self.not_counted, covers, drawn_as)))

    def budgets(self) -> list[tuple[str, list[tuple[str, ...]]]]:
        """Title and rows (stage; least, mean, greatest ms) of each path; paths of equal time are merged."""
        onward: dict[tuple[Any, ...], list[str]] = {}
        for path in self.paths:
            source, *through, target = path.name.split(" -> ")
            targets = onward.setdefault((source, *through, path.later, tuple(_stage_rows(path))), [])
            targets += [] if target in targets else [target]
        budgets: dict[tuple[Any, ...], list[str]] = {}
        for (source, *way), targets in onward.items():
            budgets.setdefault((*way, tuple(targets)), []).append(source)
        return [(" -> ".join([", ".join(sources), *through, ", ".join(targets)])
                 + (f"; {later}" if later else ""), list(rows))
                for (*through, later, rows, targets), sources in budgets.items()]

    def _tables(self) -> list[Table]:
        from fesloop.tables import Table

        budgets = self.budgets()
        slowest = max(budgets, key=lambda each: max((float(row[2]) for row in each[1]), default=0.0),
                      default=None)
        return [Table(f"Latency, {len(self.paths)} path{'s' * (len(self.paths) != 1)}. {self.coverage()}"),
                *(Table(each[0], ("stage, ms", "min", "mean", "max"), each[1], folded=each is not slowest)
                  for each in budgets)]

    def __repr__(self) -> str:
        return f"LatencyReport({len(self.paths)} paths)"

    def __str__(self) -> str:
        from fesloop.tables import as_text

        return as_text(self._tables())

    def _repr_html_(self) -> str:
        from fesloop.tables import as_html

        return as_html(self._tables())

    def path(self, source: str, target: str) -> PathLatency:
        """The only path from a plant output ("node.port") to a plant input; KeyError if none or several."""
        found = [p for p in self.paths
                 if (p.connections[0].wire.source, p.connections[-1].wire.target) == (source, target)]
        if len(found) != 1:
            raise KeyError(f"{len(found)} paths from {source} to {target}: "
                           f"{', '.join(p.name for p in found or self.paths)}")
        return found[0]


def _not_counted(ways: Sequence[tuple[Connection, ...]]) -> str:
    """Sentence on plants that pass on what they read in a time of their own, such as a controller's FMU."""
    ends = [(way[0].source, way[-1].target) for way in ways if way[0].source is not way[-1].target]
    passing = {node.name: node.part.own_step_s for _, node in ends
               if offers(node.part, KeepsOwnTime) and any(source is node for source, _ in ends)}
    if not passing:
        return ""
    steps = ", ".join(f"{name} {1e3 * step_s:.6g} ms" for name, step_s in passing.items() if step_s)
    return (f"Not counted is the time inside {' and '.join(passing)}: a path ends at a plant's input, and a "
            "loop through several plants takes longer than its paths together."
            + (f" Steps that they declare: {steps}." if steps else ""))


def _stage_rows(path: PathLatency) -> list[tuple[str, ...]]:
    """Rows of the stages that take time, of the total, and of each lane's total where there are several."""
    stages = [stage for stage in path.summary() if stage.most_ns or stage.name == "total"]
    stages += [replace(lane, name=f"total, {lane.name}") for lane in path.by_lane()]
    return [(stage.name, *(f"{ns / NS_PER_MS:.3f}" for ns in (stage.least_ns, stage.mean_ns, stage.most_ns)))
            for stage in stages]


def _paths(connections: Sequence[Connection]) -> Iterator[tuple[Connection, ...]]:
    """Paths from a plant to a plant that pass no block twice."""
    ways: list[tuple[Connection, ...]] = [(c,) for c in connections if c.source.is_plant]
    while ways:
        way = ways.pop(0)
        end = way[-1].target
        if end.is_plant:
            yield way
            continue
        passed = {id(c.target) for c in way}
        ways += [(*way, c) for c in connections if c.source is end and
                 (c.target.is_plant or id(c.target) not in passed)]


def _timing(wire: Wire) -> Wire:
    """The wire without fields that do not affect arrivals: its ends, unless they are random."""
    return wire if wire.random else replace(wire, source="a.wire", target="a.wire", link=None)


def _period_s(clock: Clock) -> float:
    """Seconds between two ticks."""
    if isinstance(clock, RateClock):
        return clock.period_s
    return (clock.tick(1) - clock.tick(0)) / NS_PER_S if clock.tick(1) < FOREVER else 0.0
