"""A linear loop: its plant, its blocks and the wires between them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import cast

import numpy as np
from numpy.typing import NDArray

from fesloop.analysis.theory import wires
from fesloop.errors import InputError, did_you_mean
from fesloop.loop.clock import NS_PER_MS, RateClock
from fesloop.loop.nodes import Connection, Node
from fesloop.loop.order import Sampling, firing_order
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
    truth: (outputs, n), rows of the plant's states whose cost is asked.
    truth_names, truth_unit: of these outputs.
    reading: when the recorder looks at the plant.
    given: (block, port) to what comes there from outside the loop, at the end of a trial; not there where
        that is not known beforehand.
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
        """What happens at one instant, in its order."""
        return firing_order([self.plant, *(node for node, _ in self.blocks)], self.connections)

    @property
    def random(self) -> bool:
        """Whether a wire draws jitter or loss."""
        return any(c.wire.loss or wires.varies(c) for c in self.connections)

    @property
    def clocks(self) -> tuple[RateClock, ...]:
        """All that tick on the loop."""
        sampled = [c.clock for c in self.connections if c.clock is not None]
        return cast(tuple[RateClock, ...], (*(node.clock for node, _ in self.blocks), *sampled))

    def wire(self, name: str) -> Connection:
        """The wire of that name, "a.b->c.d"; raises InputError for one that is not on the loop."""
        names = [c.wire.name for c in self.connections]
        if name not in names:
            raise InputError(f"wire {name}", "is not on the loop", ", ".join(names),
                             did_you_mean(name, names))
        return self.connections[names.index(name)]

    def with_latency(self, name: str, latency_ns: int) -> LinearLoop:
        """The same loop with another latency of one wire; raises InputError for a wire that is not on it."""
        changed = self.wire(name)
        wire = replace(changed.wire, latency_ms=latency_ns / NS_PER_MS)
        return replace(self, connections=tuple(
            replace(c, wire=wire) if c is changed else c for c in self.connections))
