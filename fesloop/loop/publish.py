"""Sampling of plant outputs into wires, at declared ticks, as late as they are read.

Samples that are not read yet need no event of their own. A block that is about to read requests everything
that was due by then, and the samples are made in order of time, as if each had been made at its tick: the
plant passes the same instants and the same inputs.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

from fesloop.errors import RunError
from fesloop.loop.clock import FOREVER, NS_PER_MS, Clock, ticks_from
from fesloop.loop.guard import check_shapes, finite_check, is_finite
from fesloop.loop.plants import ExactStation, GridStation, PlantStation
from fesloop.loop.wire import Link


class Sampler:
    """One plant, one clock, and the links that carry what is sampled then.

    Attributes
    ----------
    due: instant of the next sample, ns.
    index: its number, which is how many have been sent.
    plain_links: links whose messages the sender counts.
    """

    __slots__ = ("_echo_ns", "_next_tick", "_plain", "_random", "_stacks_through", "_values_at", "clock",
                 "due", "index", "plain_links", "plant")

    def __init__(self, plant: PlantStation, clock: Clock, outgoing: Sequence[tuple[int, Link]],
                 observing: bool = False) -> None:
        self.plant, self.clock = plant, clock
        self._values_at: Callable[[Sequence[int]], Iterator[tuple[int, int, Any]]] = plant.values_through
        self._stacks_through = (None if observing or isinstance(plant, GridStation) or not plant.stacks
                                else plant.stacks_through)
        if isinstance(plant, GridStation) and plant.glances([port for port, _ in outgoing]):
            self._values_at = plant.glances_through
        elif observing:
            self._values_at = plant.observed_at
        checks = [finite_check(port) for port in plant.plant.outputs]
        self.plain_links = [link for _, link in outgoing if link.plain]
        self._plain = tuple((port, checks[port], link.queue.append, link.latency_ns)
                            for port, link in outgoing if link.plain)
        self._random = tuple((port, checks[port], link.send) for port, link in outgoing if not link.plain)
        self._echo_ns = min((link.latency_ns for _, link in outgoing
                             if isinstance(plant, ExactStation) and plant.reads(link)), default=FOREVER)
        self.index = self.due = 0
        self.restore(0)

    def until(self, time_ns: int) -> None:
        """Make every sample due at or before `time_ns`."""
        dues = self._take_dues(time_ns)
        if not dues:
            return
        index, plain, random = self.index, self._plain, self._random
        if index == 0:
            check_shapes(self.plant.name, self.plant.plant.outputs, self.plant.read_now())
        if self._stacks_through is not None and not random:
            self.index = index + len(dues)
            for instants, stacks in self._stacks_through(dues, self._echo_ns):
                self._send_stacks(instants, stacks)
            return
        for due, captured, values in self._values_at(dues):
            for port, finite, append, latency in plain:
                value = values[port]
                if not finite(value):
                    raise _unstable(self.plant, port, due)
                append((value, captured, captured, due + latency))
            for port, finite, send in random:
                if not finite(values[port]):
                    raise _unstable(self.plant, port, due)
                send(index, values[port], captured, captured, due)
            index += 1
        self.index = index

    def _send_stacks(self, instants: Sequence[int], stacks: tuple[Any, ...]) -> None:
        """Send outputs of many instants, stacked, into wires without jitter and loss."""
        if not all(is_finite(stacks[port]) for port, *_ in self._plain):
            for k, instant in enumerate(instants):
                for port, finite, *_ in self._plain:
                    if not finite(stacks[port][k]):
                        raise _unstable(self.plant, port, instant)
        for port, _, append, latency in self._plain:
            for instant, value in zip(instants, stacks[port], strict=True):
                append((value, instant, instant, instant + latency))

    def _take_dues(self, time_ns: int) -> list[int]:
        """Instants of the samples due at or before `time_ns`; `due` moves past them."""
        dues, due, next_tick = [], self.due, self._next_tick
        while due <= time_ns:
            dues.append(due)
            due = next_tick()
        self.due = due
        return dues

    @property
    def sent(self) -> int:
        """Messages sent into each of the links."""
        return self.index

    def fire(self, time_ns: int) -> int:
        """Sample now and return the next instant, for a plant whose sampling is an event of the loop."""
        self.until(time_ns)
        return self.due

    def save(self) -> int:
        """All that changes, for a snapshot."""
        return self.index

    def restore(self, saved: int) -> None:
        """Back to what `save` gave."""
        self.index = saved
        self._next_tick = ticks_from(self.clock, saved)
        self.due = self._next_tick()


class Publisher:
    """The samplers of plants that exchange with each other (mostly one plant).

    Parameters
    ----------
    stages: samplers in order of time within a stage. What an earlier stage sends does not depend on a later
        one, so it is sampled ahead, as far as requested.

    Attributes
    ----------
    due: instant of the next sample, ns.
    """

    __slots__ = ("_stages", "due")

    def __init__(self, stages: Sequence[Sequence[Sampler]]) -> None:
        self._stages = tuple(tuple(stage) for stage in stages if stage)
        self.settle()

    def until(self, time_ns: int) -> None:
        """Make every sample due at or before `time_ns`; at one instant in the order of declaration."""
        for stage in self._stages:
            if len(stage) == 1:
                stage[0].until(time_ns)
                continue
            due = _next_due(stage)
            while due <= time_ns:
                for sampler in stage:
                    if sampler.due == due:
                        sampler.until(due)
                due = _next_due(stage)
        self.settle()

    def settle(self) -> None:
        """Update `due`."""
        self.due = min((_next_due(stage) for stage in self._stages), default=FOREVER)


def _next_due(samplers: Sequence[Sampler]) -> int:
    return min([sampler.due for sampler in samplers])


def _unstable(plant: PlantStation, port: int, time_ns: int) -> RunError:
    name = plant.plant.outputs[port].name
    return RunError(f"{plant.name}.{name} is not finite at {time_ns / NS_PER_MS:.6f} ms: "
                    "the simulation became unstable")
