"""A patient's chain in open loop: from pulse widths to posture, without noise and without an object.

It has the experiment's own blocks, wires and tick times (safety, stimulator, electrodes, muscles, hand), with
a table of pulses in place of the controller, so that it gives exactly what the plant in the loop would do.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.experiment.running import Experiment
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_S, RateClock
from fesloop.loop.nodes import Node
from fesloop.loop.record import Recorder
from fesloop.loop.run import Loop
from fesloop.loop.signals import Port, Sample, Value
from fesloop.loop.wire import Wire
from fesloop.loop.wiring import Wiring

Array = NDArray[np.float64]
CHAIN = ("safety", "stimulator", "electrodes", "muscles", "hand")
_PLAYER = "played_widths"


class PulseTable:
    """A block that puts out its table of pulses (ticks, channels, 2), A and s, which changes between runs."""

    __slots__ = ("table",)

    def __init__(self, table: Array) -> None:
        self.table = table

    @property
    def inputs(self) -> tuple[Port, ...]:
        """No inputs."""
        return ()

    @property
    def outputs(self) -> tuple[Port, ...]:
        """`stimulation`."""
        return (Port("stimulation", (self.table.shape[1], 2), "A,s"),)

    def init(self, context: Context) -> None:
        """No state."""

    def step(self, state: Any, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """Put out the row of this tick; after the end the last one."""
        return (self.table[min(tick.index, len(self.table) - 1)].copy(),)


class OpenChain:
    """The chain of an experiment, which can be simulated repeatedly.

    Parameters
    ----------
    experiment: with nodes `safety`, `stimulator`, `electrodes`, `muscles`, `hand`; its score's truth is a
        node of kind `synergies`.
    current_ma: (channels,), of the pulses.
    ticks: number of simulated ticks.
    rested: whether muscles do not tire.

    Attributes
    ----------
    parts: blocks of the chain by name, without tremor and object.
    rows, offset, freedoms: C (m, f) and c (m,), rad, of the scored sums of angles, and the angles' names.
    clock: of the ticks.
    width_most: (channels,), s, the widest pulses that safety and device allow.
    seed: of the experiment. ticks: number of simulated ticks.
    wire_latency_ns: from `safety` to the stimulator.
    rollouts: number of simulations so far.
    """

    __slots__ = ("_begun", "_loop", "_nodes", "_player", "_prefix", "_snapshot", "_wires", "clock",
                 "currents", "freedoms", "offset", "parts", "rollouts", "rows", "seed", "ticks", "width_most",
                 "wire_latency_ns")

    def __init__(
        self, experiment: Experiment, current_ma: Array, ticks: int, *, rested: bool = False
    ) -> None:
        by_name = {node.name: node for node in experiment.nodes}
        missing = [name for name in CHAIN if name not in by_name]
        if missing:
            raise InputError("experiment", f"no node named {', '.join(missing)}", ", ".join(CHAIN))
        truth: Any = by_name[str(experiment.score.truth).partition(".")[0]].part
        self.rows, self.offset, self.freedoms = truth.matrix, truth.offset, truth.freedoms
        clock = by_name["safety"].clock
        assert isinstance(clock, RateClock)
        self.clock, self.ticks, self.seed = clock, ticks, experiment.seed
        self.currents = 1e-3 * np.asarray(current_ma, dtype=np.float64)
        channels = len(self.currents)
        self._player = PulseTable(np.zeros((ticks, channels, 2)))
        self._player.table[:, :, 0] = self.currents
        self._nodes = [Node(_PLAYER, self._player, clock),
                       *(self._quiet(by_name[name], rested) for name in CHAIN)]
        self._wires = [Wire(f"{_PLAYER}.stimulation", "safety.stimulation"), *(
            wire for wire in experiment.wires
            if wire.source.partition(".")[0] in CHAIN and wire.target.partition(".")[0] in CHAIN)]
        self.wire_latency_ns = sum(wire.latency_ns for wire in self._wires
                                   if wire.source == "safety.stimulation")
        wiring = Wiring(self._nodes, self._wires, self.seed)
        self.parts: dict[str, Any] = {node.name: node.part for node in wiring.nodes}
        self.width_most = self._widest()
        self._loop = Loop(wiring)
        self._begun = self._loop.snapshot()
        self._prefix, self._snapshot = b"", self._begun
        self.rollouts = 0

    @staticmethod
    def _quiet(node: Node, rested: bool) -> Node:
        """The node without day-to-day variation and without an object."""
        part: Any = node.part
        if node.name == "hand":
            return replace(node, part=replace(part, object=None, table=None))
        if node.name == "muscles":
            return replace(node, part=replace(part, tremor=None, **({"fatigue": None} if rested else {})))
        return node

    def _widest(self) -> Array:
        safety, device = self.parts["safety"], self.parts["stimulator"].limits
        widths = np.minimum(1e-6 * np.asarray(safety.width_max_us), device.width_max)
        charge = np.minimum(1e-6 * np.asarray(safety.charge_max_uc), device.charge_max)
        steps = np.floor(np.minimum(widths, charge / self.currents) / device.width_step + 1e-9)
        widest: Array = steps * device.width_step
        return widest

    def time_ns(self, tick: int) -> int:
        """Time of a tick."""
        return self.clock.tick(tick)

    def tick_at(self, time_s: float) -> int:
        """The first tick at or after a time."""
        return int(np.ceil(time_s * NS_PER_S / self.clock.period_num * self.clock.period_den - 1e-6))

    def given(self, widths: Array) -> Array:
        """Widths (ticks, channels), s, as the device would give them, apart from limits of rise."""
        device = self.parts["stimulator"].limits
        steps = np.floor(np.clip(widths, 0.0, self.width_most) / device.width_step + 0.5) * device.width_step
        return np.where(steps < device.width_min - 1e-12, 0.0, steps)

    def begin(self, widths: Array, first: int) -> Loop:
        """Make the loop, with `widths` (ticks, channels), s, and run it to just before tick `first`."""
        self._player.table[:, :, 1] = self.given(widths)
        self.rollouts += 1
        prefix = np.int64(first).tobytes() + self._player.table[:first].tobytes()
        if prefix != self._prefix:
            self._loop.restore(self._begun)
            if first > 0:
                self._loop.run_until(self.time_ns(first) - 1)
            self._prefix, self._snapshot = prefix, self._loop.snapshot()
        self._loop.restore(self._snapshot)
        return self._loop

    def course(self, widths: Array, first: int) -> Array:
        """Simulate `widths` and return the scored sums from tick `first` on, (ticks - first, m), rad."""
        loop, hand, rows = self.begin(widths, first), self.parts["hand"], []
        for tick in range(first, self.ticks):
            loop.run_until(self.time_ns(tick))
            rows.append(self.rows @ hand.glance(loop.states()["hand"])[0] + self.offset)
        return np.array(rows)

    def admitted(self, widths: Array) -> Array:
        """Widths (ticks, channels), s, that `safety` puts out for `widths`."""
        self._player.table[:, :, 1] = self.given(widths)
        seen, played = Recorder(None), (_PLAYER, "safety")
        loop = Loop(Wiring([node for node in self._nodes if node.name in played], self._wires[:1], self.seed),
                    recorder=seen)
        loop.run_until(self.time_ns(self.ticks - 1))
        return np.array([np.asarray(row[5][0])[:, 1] for row in seen.blocks["safety"]])
