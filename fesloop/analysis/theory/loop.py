"""A linear loop: its plant, its blocks, and the transport of messages on the wires between them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import cast

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError, did_you_mean
from fesloop.loop.clock import NS_PER_MS, RateClock
from fesloop.loop.nodes import Connection, Node
from fesloop.loop.order import Sampling, firing_order
from fesloop.loop.wire import transition_probabilities
from fesloop.models.linear_form import ContinuousForm, SampledForm

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LinearLoop:
    """One continuous plant and the sampled blocks that close the loop around it.

    Attributes
    ----------
    name: of the experiment.
    plant, plant_form: the plant.
    blocks: with their forms.
    connections: the wires of the loop, sources and targets on it.
    truth: (outputs, n), rows that map the plant's states to the scored outputs.
    truth_names, truth_unit: of these outputs.
    reading: clock at which the recorder reads the plant.
    given: input from outside the loop at the end of a trial, by (block, port); a port whose input is not
        known beforehand is left out.
    """

    name: str
    plant: Node
    plant_form: ContinuousForm
    blocks: tuple[tuple[Node, SampledForm], ...]
    connections: tuple[Connection, ...]
    truth: Array
    truth_names: tuple[str, ...]
    truth_unit: str
    reading: RateClock
    given: Mapping[tuple[str, str], Array] = field(default_factory=dict)

    @property
    def order(self) -> tuple[Sampling | Node, ...]:
        """Blocks and samplings in the order in which they act at one instant."""
        return firing_order([self.plant, *(node for node, _ in self.blocks)], self.connections)

    @property
    def random(self) -> bool:
        """Whether a wire has random jitter or loss."""
        return any(c.wire.loss or varies(c) for c in self.connections)

    @property
    def clocks(self) -> tuple[RateClock, ...]:
        """Clocks of all blocks and sampled wires."""
        sampled = [c.clock for c in self.connections if c.clock is not None]
        return cast(tuple[RateClock, ...], (*(node.clock for node, _ in self.blocks), *sampled))

    def wire(self, name: str) -> Connection:
        """The wire with a name, "a.b->c.d". Raises InputError for one that is not on the loop."""
        names = [c.wire.name for c in self.connections]
        if name not in names:
            raise InputError(f"wire {name}", "is not on the loop", ", ".join(names),
                             did_you_mean(name, names))
        return self.connections[names.index(name)]

    def with_latency(self, name: str, latency_ns: int) -> LinearLoop:
        """The loop with another latency of one wire. Raises InputError for a wire that is not on the loop."""
        changed = self.wire(name)
        wire = replace(changed.wire, latency_ms=latency_ns / NS_PER_MS)
        return replace(self, connections=tuple(
            replace(c, wire=wire) if c is changed else c for c in self.connections))


def bursts(connection: Connection) -> bool:
    """Whether the loss of a message depends on the loss of the one before."""
    begins, stays = transition_probabilities(connection.wire.loss, connection.wire.burst_messages)
    return begins != stays


def clock_of(connection: Connection) -> RateClock:
    """Clock of the messages: ticks of the source, or samples of the plant."""
    clock = connection.clock or connection.source.clock
    assert isinstance(clock, RateClock)
    return clock


def varies(connection: Connection) -> bool:
    """Whether the transport time differs from message to message."""
    return connection.wire.jitter.random


def latency_ns(connection: Connection) -> int:
    """Time from the source's tick to arrival, without random jitter."""
    fixed = 0 if varies(connection) else connection.wire.jitter.least_ns
    return connection.wire.latency_ns + fixed + connection.source.execution.least_ns


def most_ns(connection: Connection) -> int:
    """Longest transport of a message that is not lost."""
    jitter = connection.wire.jitter
    return latency_ns(connection) + ((jitter.most_ns or 0) if varies(connection) else 0)


def arrived(connection: Connection, age_ns: int) -> float:
    """Probability that a message of an age has arrived."""
    wire, late_ns = connection.wire, age_ns - latency_ns(connection)
    kept = 1.0 - wire.loss
    return kept * (wire.jitter.share_within(late_ns) if varies(connection) else float(late_ns >= 0))
