"""How long a plant output takes to act on a plant input: by stage, exactly, for any tick.

Everything is computed from the wiring in whole ns, without running it, so that a run can be held against
it. The numbers of jitter, loss and execution times are those that the run draws: functions of seed, name,
trial and tick. A block's wall time ("measured") is not known beforehand and counts as nothing here. What
an input waits for inside a block counts where the block declares it (`passages`).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise, product, takewhile
from typing import Any, NamedTuple

from fesloop.loop.clock import FOREVER, NS_PER_S, Clock, RateClock
from fesloop.loop.inside import BlockOnWay, Run
from fesloop.loop.instants import Traffic
from fesloop.loop.wire import Wire
from fesloop.loop.wiring import Connection, Node, Wiring

MEANING = ("From the instant that a sensor captures to the instant that the patient is acted on: behind a "
           "stimulator, a channel's pulse. Least, mean and greatest are over samples and over channels.")
"""What a budget's numbers are, for whoever prints them."""
_MOST_TICKS = 20_000
_FASTEST_TICKS = 100_000


@dataclass(frozen=True, slots=True)
class TickLatency:
    """The way of one sampled value.

    Attributes
    ----------
    tick: number of the sampling.
    captured_ns: physical instant of the value.
    acts_ns: when it starts to act on the plant input.
    stages_ns: time spent in each stage, in the order of the path's `stages`; they add up to the total.
    lane: the one of the path's `lanes` that it went by.
    """

    tick: int
    captured_ns: int
    acts_ns: int
    stages_ns: tuple[int, ...]
    lane: str = ""

    @property
    def total_ns(self) -> int:
        """From capture to effect."""
        return self.acts_ns - self.captured_ns


@dataclass(frozen=True, slots=True)
class StageSummary:
    """One stage over many ticks, ns; the last of a path is the total."""

    name: str
    least_ns: int
    mean_ns: float
    most_ns: int


class PathLatency:
    """One way from a plant output through blocks to a plant input.

    Attributes
    ----------
    connections: along the way.
    stages: what takes time, in order; `TickLatency.stages_ns` and `summary` follow it.
    lanes: names of what a block on the way serves in turn, such as a stimulator's channels, each of which a
        sample reaches at a time of its own; one without a name where there is no such block.
    later: which block acts on a sample only later, and when, in words; empty where none does. The stages of
        such a way are those of its blocks and wires alone.
    """

    def __init__(self, connections: tuple[Connection, ...], traffic: Traffic, horizon_ns: int,
                 known: dict[Any, list[_Tally]]) -> None:
        self.connections = connections
        self._horizon_ns, self._known = horizon_ns, known
        first, last = connections[0], connections[-1]
        assert first.clock is not None
        self._sampling: Clock = first.clock
        self._source_grid = first.source.plant.grid
        self._target_grid = last.target.plant.grid
        self._transit = traffic.transit(last)
        self._blocks: list[BlockOnWay] = []
        for incoming, outgoing in pairwise(connections):
            self._blocks.append(BlockOnWay(incoming, outgoing, traffic, self._blocks[-1:]))
        self.stages = self._stage_names()
        self._turns = tuple(product(*(range(max(1, len(block.lanes))) for block in self._blocks)))
        self.lanes = tuple(
            ", ".join(block.lanes[turn]
                      for block, turn in zip(self._blocks, turns, strict=True) if block.lanes)
            for turns in self._turns)
        self.later = "; ".join(block.later for block in self._blocks if block.later)

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
        """The ports and nodes on the way."""
        through = [c.target.name for c in self.connections[:-1]]
        return " -> ".join([self.connections[0].wire.source, *through, self.connections[-1].wire.target])

    def of_tick(self, index: int, lane: int = 0) -> TickLatency | None:
        """The way of sample `index` by a lane; None if it is lost or overwritten before it acts.

        A block that steps again before the next sample reaches it sends the same sample again, so from the
        second wire on a sample travels in a run of messages, of which the first to get through counts.
        """
        carried = self._carried(index, lane)
        return None if carried is None else self._traced_back(index, lane, carried)

    def _carried(self, index: int, lane: int) -> _Carried | None:
        """What carries sample `index` by a lane, and when it acts."""
        if self._sampling.tick(index) >= FOREVER:
            return None
        return self._onward(0, (index, index), self._turns[lane])

    def _onward(self, number: int, run: Run, turns: tuple[int, ...]) -> _Carried | None:
        """The way from block `number` on of what a run of messages carries to it."""
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
        """Stages of the way that ended with an arrival at the plant, found from its end."""
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

    def _looked_at(self) -> Iterator[int]:
        """Every sample within the horizon, 20,000 at most."""
        return takewhile(lambda index: self._sampling.tick(index) <= self._horizon_ns, range(_MOST_TICKS))

    def ticks(self, lane: int | None = None) -> Iterator[TickLatency]:
        """Every sample within the horizon (20,000 at most) that acts, by one lane or by each."""
        lanes = range(len(self.lanes)) if lane is None else (lane,)
        found = (self.of_tick(index, each) for index in self._looked_at() for each in lanes)
        return (latency for latency in found if latency is not None)

    def least_ns(self, lane: int = 0) -> int | None:
        """The least time from capture to effect of the samples within the horizon; None if none acts."""
        totals = (carried.acts_ns - self._captured_ns(index) for index in self._looked_at()
                  if (carried := self._carried(index, lane)) is not None)
        return min(totals, default=None)

    def summary(self, lane: int | None = None) -> tuple[StageSummary, ...]:
        """Each stage, then the total, over the samples that act; empty if none does.

        Least, mean and greatest are over samples and lanes alike, unless one lane is named.
        """
        looked_at = self._tallies if lane is None else self._tallies[lane:lane + 1]
        tallies = [tally for tally in looked_at if tally.samples]
        if not tallies:
            return ()
        count = sum(tally.samples for tally in tallies)
        return tuple(
            StageSummary(name, min(tally.least[i] for tally in tallies),
                         sum(tally.sums[i] for tally in tallies) / count,
                         max(tally.most[i] for tally in tallies))
            for i, name in enumerate((*self.stages, "total")))

    def by_lane(self) -> tuple[StageSummary, ...]:
        """The total of each lane by which a sample acts, under the lane's name; empty for a single lane."""
        if len(self.lanes) == 1:
            return ()
        return tuple(replace(summary[-1], name=name) for lane, name in enumerate(self.lanes)
                     if (summary := self.summary(lane)))

    @property
    def _tallies(self) -> list[_Tally]:
        """Of the samples that act, by lane; counted once for all ways that take the same time."""
        key = (tuple((c.source.name, c.target.name, c.clock, _timing(c.wire)) for c in self.connections),
               tuple(block.waiting for block in self._blocks))
        if key not in self._known:
            self._known[key] = self._counted()
        return self._known[key]

    def _counted(self) -> list[_Tally]:
        tallies = []
        for lane in range(len(self.lanes)):
            rows = [(*latency.stages_ns, latency.total_ns) for latency in self.ticks(lane)]
            columns = list(zip(*rows, strict=True))
            tallies.append(_Tally(len(rows), *([of(column) for column in columns] for of in (min, sum, max))))
        return tallies

    @property
    def hold_ns(self) -> float:
        """Mean age that holding adds between two values that act: half the sampling period, ns."""
        return _period_s(self._sampling) * NS_PER_S / 2


class _Tally(NamedTuple):
    """How many samples act, and the least, sum and greatest of each stage and the total, ns."""

    samples: int
    least: list[int]
    sums: list[int]
    most: list[int]


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
    trial: whose random numbers count.
    horizon_ns: up to when the summaries look; 10 s by default. It ends with the 100,000th tick of the block
        that ticks fastest, so that a report on a loop in the MHz takes no longer than others.
    through: a node that every path is to lead to or through; None for all paths.
    """

    def __init__(self, wiring: Wiring, trial: int = 0, horizon_ns: int | None = None,
                 through: Node | None = None) -> None:
        horizon = 10 * NS_PER_S if horizon_ns is None else horizon_ns
        horizon = min([horizon, *(_FASTEST_TICKS * node.clock.shortest_ns for node in wiring.nodes
                                  if isinstance(node.clock, RateClock))])
        traffic = Traffic(wiring.seed, trial)
        known: dict[Any, list[_Tally]] = {}
        self.paths = tuple(PathLatency(path, traffic, horizon, known)
                           for path in _paths(wiring.connections)
                           if through is None or any(connection.target is through for connection in path))

    def path(self, source: str, target: str) -> PathLatency:
        """The only path from a plant output ("node.port") to a plant input; KeyError if none or several."""
        found = [p for p in self.paths
                 if (p.connections[0].wire.source, p.connections[-1].wire.target) == (source, target)]
        if len(found) != 1:
            raise KeyError(f"{len(found)} paths from {source} to {target}: "
                           f"{', '.join(p.name for p in found or self.paths)}")
        return found[0]


def _paths(connections: Sequence[Connection]) -> Iterator[tuple[Connection, ...]]:
    """Ways from a plant to a plant that pass no block twice."""
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
    """What of a wire decides when its messages arrive: its name too, where chance has a part in it."""
    plain = wire.jitter.kind == "zero" and not wire.loss
    return replace(wire, source="a.wire", target="a.wire") if plain else wire


def _period_s(clock: Clock) -> float:
    """Seconds between two ticks."""
    if isinstance(clock, RateClock):
        return clock.period_s
    return (clock.tick(1) - clock.tick(0)) / NS_PER_S if clock.tick(1) < FOREVER else 0.0
