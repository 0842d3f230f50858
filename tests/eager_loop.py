"""The loop's rules written down plainly: an eager simulation of any wiring, and parts to wire at random.

Nothing here is lazy, queued in bulk or skipped: time goes from instant to instant, and everything due is
done in the order of the rules. A plant that goes to any instant is split where the rules split it and nowhere
else, and looked at in a copy: so parts whose arithmetic rounds come out the same to the last bit, too.
"""

from __future__ import annotations

import copy
import heapq
import math
from collections import defaultdict
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np

from fesloop.loop.noise import NoiseStream, stream_key
from fesloop.loop.signals import NEVER, Port, Sample

PRIME = 1_000_003


@dataclass(slots=True)
class Number:
    """State of the parts below."""

    x: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Mixer:
    """A block whose outputs tell every input and every earlier step apart."""

    takes: int
    gives: int
    salt: int
    clock: Any = None

    @property
    def inputs(self):
        return tuple(Port(f"u{i}", optional=True) for i in range(self.takes))

    @property
    def outputs(self):
        return tuple(Port(f"y{i}") for i in range(self.gives))

    def init(self, context):
        return Number(context.trial)

    def next_trial(self, state, context):
        return Number(state.x % 17 + context.trial)

    def step(self, state, inputs, tick):
        mixed = 31 * self.salt + tick.index + sum((i + 2) * int(s.value) for i, s in enumerate(inputs))
        state.x = (7 * state.x + mixed) % PRIME
        return tuple(float((mixed * (i + 1) + state.x) % PRIME) for i in range(self.gives))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Adder:
    """A plant that integrates its inputs exactly; with a grid, one that also multiplies at every step."""

    takes: int
    gives: int
    salt: int
    feedthrough: bool = False
    grid: Any = None

    @property
    def inputs(self):
        return tuple(Port(f"u{i}", optional=True) for i in range(self.takes))

    @property
    def outputs(self):
        return tuple(Port(f"y{i}") for i in range(self.gives))

    def init(self, context):
        return Number(self.salt)

    def next_trial(self, state, context):
        return Number(state.x % 13)

    def advance(self, state, inputs, start_ns, stop_ns):
        assert stop_ns > start_ns
        rate = self.salt + sum((i + 1) * int(value) for i, value in enumerate(inputs))
        state.x = (state.x * (1 if self.grid is None else 3) + rate * (stop_ns - start_ns)) % PRIME

    def read(self, state, inputs):
        direct = sum(int(value) for value in inputs) if self.feedthrough else 0
        return tuple(float((state.x * (i + 1) + direct) % PRIME) for i in range(self.gives))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Drifter(Adder):
    """A plant that goes to any instant, with rounding that tells where its way there was split."""

    def advance(self, state, inputs, start_ns, stop_ns):
        assert stop_ns > start_ns
        kept = math.exp(-self.salt * 1e-9 * (stop_ns - start_ns))
        state.x = kept * state.x + (1.0 - kept) * sum((i + 1) * value for i, value in enumerate(inputs))

    def read(self, state, inputs):
        direct = sum(inputs) if self.feedthrough else 0.0
        return tuple(1000.0 * math.sin(state.x + i + direct) for i in range(self.gives))


class Ahead:
    """Goes through many instants at once."""

    def advance_through(self, state, inputs, times_ns):
        rows, changes = [], list(inputs)
        now, values = changes.pop(0)
        for instant in times_ns:
            while changes and changes[0][0] < instant:
                arrival, following = changes.pop(0)
                if arrival > now:
                    self.advance(state, values, now, arrival)
                now, values = arrival, following
            if instant > now:
                self.advance(state, values, now, instant)
            now = instant
            rows.append(self.read(state, values))
        assert not changes
        return tuple(np.array(column) for column in zip(*rows, strict=True))


class Foreseen:
    """Is looked at ahead."""

    def observe(self, state, inputs, start_ns, times_ns):
        rows = [self.advance_through(copy.copy(state), [(start_ns, inputs)], [instant])
                for instant in times_ns]
        return tuple(np.concatenate(column) for column in zip(*rows, strict=True))


class AheadAdder(Ahead, Adder):
    """All at once, exactly."""


class AheadDrifter(Ahead, Drifter):
    """All at once, rounded."""


class ForeseenDrifter(Foreseen, AheadDrifter):
    """All at once and ahead, rounded."""


class GlancingAdder(Adder):
    """In fixed steps, the first output at a glance."""

    def glance(self, state):
        return {0: self.read(state, ())[0]}


class SteppingAdder(Adder):
    """In fixed steps, several in one call, where it can."""

    def advance_steps(self, state, inputs, start_ns, times_ns):
        if (self.salt + len(times_ns)) % 5 == 0:
            return False
        for stop_ns, *values in zip(times_ns, *inputs, strict=True):
            self.advance(state, values, start_ns, stop_ns)
            start_ns = stop_ns
        return True


class SteppingGlancer(SteppingAdder, GlancingAdder):
    """Both."""


class AheadMixer(Mixer):
    """A block that does several ticks in one call."""

    def steps_through(self, state, inputs, ticks):
        rows = [self.step(state, [column[k] for column in inputs], tick) for k, tick in enumerate(ticks)]
        return tuple([*column] for column in zip(*rows, strict=True))


class Reporting:
    """Reports at some of its ticks."""

    def step(self, state, inputs, tick):
        if (tick.index + self.salt) % 3 == 0:
            tick.report("third", f"tick {tick.index}")
        return super().step(state, inputs, tick)


class ReportingMixer(Reporting, Mixer):
    """Tick by tick."""


class ReportingAheadMixer(Reporting, AheadMixer):
    """Several in one call."""


class EagerLoop:
    """A wiring simulated up to and including `until_ns`.

    Attributes
    ----------
    blocks: rows of each block as the Recorder has them. skipped: (time, block, tick).
    inputs: of each plant, (instant it acts from, port, oldest, newest, value).
    plants: what a recorder sees at the ticks of `watch`, (instant, physical instant, outputs).
    counts: messages by wire name: sent, lost.
    states: of every node, at `until_ns`.

    A trial after the first begins with the `states` that the one before left behind.
    """

    def __init__(self, wiring, until_ns, trial=0, watch=None, states=None):
        self.wiring, self.until_ns, self._watch = wiring, until_ns, watch
        self.blocks = {node.name: [] for node in wiring.nodes if not node.is_plant}
        self.inputs = {node.name: [] for node in wiring.nodes if node.is_plant}
        self.plants = {node.name: [] for node in wiring.nodes if node.is_plant}
        self.skipped = []
        self.counts = {c.wire.name: {"sent": 0, "lost": 0} for c in wiring.connections}
        self.states = {n.name: n.part.init(n.context(wiring.seed, trial)) if states is None
                       else n.part.next_trial(states[n.name], n.context(wiring.seed, trial))
                       for n in wiring.nodes}
        self._acting = self._what_acts()
        self._held = {n.name: [Sample(p.initial_value(), NEVER, NEVER, NEVER) for p in n.part.inputs]
                      for n in wiring.nodes}
        self._under_way = {c.wire.name: [] for c in wiring.connections}
        self._newest = dict.fromkeys(self._under_way, -1)
        self._last_arrival = dict.fromkeys(self._under_way, 0)
        self._wire_noise = {c.wire.name: c.wire.noise(wiring.seed, trial) for c in wiring.connections}
        self._fates = {}
        self._execution_noise = {n.name: NoiseStream(
            stream_key(wiring.seed, f"{n.name}/execution", trial), 1, "uniform") for n in wiring.nodes}
        self._at = dict.fromkeys(self.inputs, 0)
        self._busy_until = dict.fromkeys(self.blocks, 0)
        self._due = self._what_is_due()
        self._instants = list(self._due)
        heapq.heapify(self._instants)
        while self._instants:
            self._instant(heapq.heappop(self._instants))
        for node in wiring.nodes:
            if node.is_plant and node.plant.grid is None:
                self._go(node, until_ns)

    def _what_acts(self):
        """Names of what reaches a plant, in whatever way."""
        acting = {node.name for node in self.wiring.nodes if node.is_plant}
        for _ in self.wiring.nodes:
            acting |= {c.source.name for c in self.wiring.connections if c.target.name in acting}
        return acting

    def _what_is_due(self):
        """{instant: [(number, node or connection that is sampled)]}; empty lists at ticks of grids."""
        due = defaultdict(list)
        items = [(c.wire.clock or c.target.clock, c) for c in self.wiring.connections if c.source.is_plant]
        items += [(node.clock, node) for node in self.wiring.nodes if not node.is_plant]
        for clock, item in items:
            number = 0
            while clock.tick(number) <= self.until_ns:
                due[clock.tick(number)].append((number, item))
                number += 1
        for node in self.wiring.nodes:
            if node.is_plant and node.plant.grid is not None:
                for number in range(node.plant.grid.last_at_or_before(self.until_ns) + 1):
                    _ = due[node.plant.grid.tick(number)]
        if self._watch is not None:
            for number in range(self._watch.last_at_or_before(self.until_ns) + 1):
                _ = due[self._watch.tick(number)]
        return due

    def _instant(self, now):
        plants = [node for node in self.wiring.nodes if node.is_plant]
        for node in plants:
            self._advance(node, now)
        for node in plants:
            self._deliver(node, now)
        waiting = list(self._due.pop(now, ()))
        while waiting:
            first = next(item for item in reversed(waiting)
                         if not any(self._precedes(other[1], item[1]) for other in waiting))
            waiting.remove(first)
            self._do(*first, now)
        for node in plants:
            self._deliver(node, now)
            self._observe(node, now)

    def _advance(self, node, now):
        grid = node.plant.grid
        if grid is not None and grid.tick(grid.first_at_or_after(now)) == now:
            self._go(node, now)

    def _go(self, node, now):
        """Split the way of a plant here."""
        if now > self._at[node.name]:
            node.plant.advance(self.states[node.name], self._inputs(node), self._at[node.name], now)
            self._at[node.name] = now

    def _inputs(self, node):
        return [sample.value for sample in self._held[node.name]]

    def _look(self, node, now):
        """The physical instant, and the outputs then, of a plant that is not split for it."""
        state, captured = self.states[node.name], self._at[node.name]
        if node.plant.grid is None and now > captured:
            state = copy.copy(state)
            node.plant.advance(state, self._inputs(node), captured, now)
            captured = now
        return captured, list(node.plant.read(state, self._inputs(node)))

    def _observe(self, node, now):
        """Last of all, the recorder reads. An instant may come twice: messages may still arrive at it."""
        watch, seen = self._watch, self.plants[node.name]
        if watch is None or watch.tick(watch.first_at_or_after(now)) != now:
            return
        if seen and seen[-1][0] == now:
            seen.pop()
        seen.append((now, *self._look(node, now)))

    def _precedes(self, before, after):
        """Whether the one sends to the other, which must see it at this very instant."""
        for c in self.wiring.connections:
            sends = before is (c if c.source.is_plant else c.source)
            direct = c.target.is_plant and c.target.plant.feedthrough
            sees = after is c.target or (direct and getattr(after, "source", None) is c.target)
            if sends and sees and c.wire.least_ns == 0 and c.source.execution.least_ns == 0:
                return True
        return False

    def _do(self, number, item, now):
        if item in self.wiring.connections:
            self._sample(number, item, now)
        elif now < self._busy_until[item.name]:
            self.skipped.append((now, item.name, number))
        else:
            self._step(number, item, now)

    def _sample(self, number, connection, now):
        node = connection.source
        self._deliver(node, now)
        if node.plant.grid is None and connection.target.name in self._acting:
            self._go(node, now)
        captured, values = self._look(node, now)
        self._send(connection, number, values[connection.source_port], (captured, captured), now)

    def _step(self, number, node, now):
        self._deliver(node, now)
        held = self._held[node.name]
        wired = [held[c.target_port] for c in self.wiring.connections if c.target is node]
        stamps = (min((s.oldest_ns if s.present else 0 for s in wired), default=now),
                  max((s.newest_ns if s.present else 0 for s in wired), default=now))
        values = node.block.step(self.states[node.name], held, SimpleNamespace(index=number, time_ns=now))
        left = now
        if node.execution.kind != "zero":
            left += node.execution.draw_ns(float(self._execution_noise[node.name].row(number)[0]))
        self._busy_until[node.name] = left
        self.blocks[node.name].append((number, now, left, *stamps, values))
        for connection in self.wiring.connections:
            if connection.source is node:
                self._send(connection, number, values[connection.source_port], stamps, left)

    def _send(self, connection, number, value, stamps, left):
        wire, counts = connection.wire, self.counts[connection.wire.name]
        sequence = counts["sent"]
        counts["sent"] += 1
        _, shape = self._wire_noise[wire.name].row(number)
        if self._lost(wire, number):
            counts["lost"] += 1
            return
        arrival = left + wire.latency_ns + wire.jitter.draw_ns(float(shape))
        if wire.late == "in-order":
            arrival = self._last_arrival[wire.name] = max(arrival, self._last_arrival[wire.name])
        heapq.heappush(self._under_way[wire.name], (arrival, sequence, value, *stamps))
        if arrival <= self.until_ns:
            heapq.heappush(self._instants, arrival)

    def _lost(self, wire, number):
        """Whether a message is lost, the two-state chain being followed from the first tick on."""
        fates = self._fates.setdefault(wire.name, [])
        stays = 1 - 1 / wire.burst_messages if wire.burst_messages else wire.loss
        begins = wire.loss * (1 - stays) / (1 - wire.loss) if wire.burst_messages else wire.loss
        while len(fates) <= number:
            limit = (stays if fates[-1] else begins) if fates else wire.loss
            fates.append(self._wire_noise[wire.name].row(len(fates))[0] < limit)
        return fates[number]

    def _deliver(self, node, now):
        """What is due goes into the ports of a node; of a plant with a grid at its ticks only."""
        if node.is_plant and node.plant.grid is not None and self._at[node.name] != now:
            return
        for c in self.wiring.connections:
            under_way = self._under_way[c.wire.name]
            while c.target is node and under_way and under_way[0][0] <= now:
                if node.is_plant:
                    self._go(node, now)
                arrival, sequence, value, oldest, newest = heapq.heappop(under_way)
                if sequence < self._newest[c.wire.name]:
                    continue
                self._newest[c.wire.name] = sequence
                self._held[node.name][c.target_port] = Sample(value, oldest, newest, arrival)
                if node.is_plant:
                    self.inputs[node.name].append((now, c.target_port, oldest, newest, value))
