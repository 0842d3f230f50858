"""How long a plant output takes to act on a plant input: by stage, exactly, for any tick.

Everything is computed from the wiring in whole ns, without running it, so that a run can be held against
it. The numbers of jitter, loss and execution times are those that the run draws: functions of seed, name,
trial and tick. A block's wall time ("measured") is not known beforehand and counts as nothing here.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import takewhile

from fesloop.loop.clock import FOREVER, NS_PER_S, Clock, RateClock
from fesloop.loop.instants import Traffic
from fesloop.loop.wiring import Connection, Node, Wiring

_MOST_TICKS = 20_000


@dataclass(frozen=True, slots=True)
class TickLatency:
    """The way of one sampled value.

    Attributes
    ----------
    tick: number of the sampling.
    captured_ns: physical instant of the value.
    acts_ns: when it starts to act on the plant input.
    stages_ns: time spent in each stage, in the order of the path's `stages`; they add up to the total.
    """

    tick: int
    captured_ns: int
    acts_ns: int
    stages_ns: tuple[int, ...]

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
    """

    def __init__(self, connections: tuple[Connection, ...], traffic: Traffic, horizon_ns: int) -> None:
        self.connections = connections
        self._horizon_ns = horizon_ns
        first, last = connections[0], connections[-1]
        assert first.clock is not None
        self._sampling: Clock = first.clock
        self._source_grid = first.source.plant.grid
        self._target_grid = last.target.plant.grid
        self._readers = [traffic.timeline(c.target) for c in connections[:-1]]
        self._transits = [traffic.transit(c) for c in connections]
        self.stages = self._stage_names()

    def _stage_names(self) -> tuple[str, ...]:
        names = [f"{self.connections[0].source.name} holds its last step"] if self._source_grid else []
        for connection in self.connections[:-1]:
            reader = connection.target.name
            names += [f"wire {connection.wire.name}", f"{reader} waits for its tick", f"{reader} executes"]
        names.append(f"wire {self.connections[-1].wire.name}")
        if self._target_grid:
            names.append(f"{self.connections[-1].target.name} waits for its step")
        return tuple(names)

    @property
    def name(self) -> str:
        """The ports and nodes on the way."""
        through = [c.target.name for c in self.connections[:-1]]
        return " -> ".join([self.connections[0].wire.source, *through, self.connections[-1].wire.target])

    def of_tick(self, index: int) -> TickLatency | None:
        """The way of sample `index`; None if it is lost or overwritten before it acts.

        A block that steps again before the next sample reaches it sends the same sample again, so from the
        second wire on a sample travels in a run of messages, of which the first to get through counts.
        """
        carried = self._carried(index)
        return None if carried is None else self._traced_back(index, *carried)

    def _carried(self, index: int) -> tuple[list[tuple[int, int]], int, int] | None:
        """Messages, first and last, that carry sample `index` on each wire, its arrival and when it acts."""
        if self._sampling.tick(index) >= FOREVER:
            return None
        carriers = [(index, index)]
        for transit, reader in zip(self._transits, self._readers, strict=False):
            span = transit.held_span(*carriers[-1])
            steps = None if span is None else reader.steps_within(*span)
            if steps is None:
                return None
            carriers.append(steps)
        span = self._transits[-1].held_span(*carriers[-1])
        if span is None:
            return None
        acts = span[0]
        if self._target_grid:
            acts = self._target_grid.tick(self._target_grid.first_at_or_after(acts))
        return (carriers, span[0], acts) if acts < span[1] else None

    def _traced_back(
        self, index: int, carriers: list[tuple[int, int]], arrival: int, acts: int
    ) -> TickLatency:
        """Stages of the way that ended with an arrival at the plant, found from its end."""
        stages = [acts - arrival] if self._target_grid else []
        arrived, number = self._transits[-1].held_at(arrival, *carriers[-1])
        for i in range(len(self._readers) - 1, -1, -1):
            left = self._readers[i].left_ns(number)
            assert left is not None
            read = self._readers[i].clock.tick(number)
            stages += [arrived - left, left - read]
            arrived, number = self._transits[i].held_at(read, *carriers[i])
            stages.append(read - arrived)
        sent, captured = self._sampling.tick(index), self._captured_ns(index)
        stages.append(arrived - sent)
        if self._source_grid:
            stages.append(sent - captured)
        return TickLatency(index, captured, acts, tuple(reversed(stages)))

    def _captured_ns(self, index: int) -> int:
        """The physical instant of sample `index`: of a fixed-step plant, its last step."""
        sent, grid = self._sampling.tick(index), self._source_grid
        return grid.tick(grid.last_at_or_before(sent)) if grid else sent

    def _looked_at(self) -> Iterator[int]:
        """Every sample within the horizon, 20,000 at most."""
        return takewhile(lambda index: self._sampling.tick(index) <= self._horizon_ns, range(_MOST_TICKS))

    def ticks(self) -> Iterator[TickLatency]:
        """Every sample within the horizon (20,000 at most) that acts."""
        return (latency for latency in map(self.of_tick, self._looked_at()) if latency is not None)

    def least_ns(self) -> int | None:
        """The least time from capture to effect of the samples within the horizon; None if none acts."""
        totals = (carried[2] - self._captured_ns(index) for index in self._looked_at()
                  if (carried := self._carried(index)) is not None)
        return min(totals, default=None)

    def summary(self) -> tuple[StageSummary, ...]:
        """Each stage, then the total, over the samples that act; empty if none does."""
        rows = [(*latency.stages_ns, latency.total_ns) for latency in self.ticks()]
        columns = zip((*self.stages, "total"), zip(*rows, strict=True), strict=False)
        return tuple(StageSummary(name, min(c), sum(c) / len(c), max(c)) for name, c in columns)

    @property
    def hold_ns(self) -> float:
        """Mean age that holding adds between two values that act: half the sampling period, ns."""
        return _period_s(self._sampling) * NS_PER_S / 2


class LatencyReport:
    """Every path from a plant output back to a plant input.

    Parameters
    ----------
    wiring: what runs.
    trial: whose random numbers count.
    horizon_ns: up to when the summaries look; 10 s by default.
    through: a node that every path is to lead to or through; None for all paths.
    """

    def __init__(self, wiring: Wiring, trial: int = 0, horizon_ns: int | None = None,
                 through: Node | None = None) -> None:
        horizon = 10 * NS_PER_S if horizon_ns is None else horizon_ns
        traffic = Traffic(wiring.seed, trial)
        self.paths = tuple(PathLatency(path, traffic, horizon)
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


def _period_s(clock: Clock) -> float:
    """Seconds between two ticks."""
    if isinstance(clock, RateClock):
        return clock.period_s
    return (clock.tick(1) - clock.tick(0)) / NS_PER_S if clock.tick(1) < FOREVER else 0.0
