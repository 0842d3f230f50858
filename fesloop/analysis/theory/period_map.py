"""The map of a linear loop's state over one period, from running the period on matrices in place of numbers.

Every signal is a row of coefficients of the state at the beginning of the flow and of the noise since then.
Operations of a run on numbers (advance the plant, sample, send, deliver, step) act on these rows. The state
holds the plant's states and input, each block's states, the value that each port holds, and for each wire the
messages that can still have an effect, newest first (delays as states: Astrom and Wittenmark 1997,
Computer-Controlled Systems, 3rd ed., section 2.3, for latencies of any length between ticks).

The map is a sequence of linear flows, and of random draws of the messages that ports receive:

    flow    z' = matrix z + noise w
    draw    z'[i] = z[take[i]], where `take` is random: independent, or the next state of a Markov chain

Between draws everything is one matrix; a loop without random wires is a single flow.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from fesloop.analysis.theory import schedule as ages
from fesloop.analysis.theory.linear_loop import within_floats
from fesloop.analysis.theory.loop import LinearLoop, bursts
from fesloop.analysis.theory.schedule import Delivery, Schedule, schedule
from fesloop.errors import RunError
from fesloop.loop.clock import NS_PER_S
from fesloop.loop.nodes import Node
from fesloop.loop.order import Sampling
from fesloop.loop.wire import transition_probabilities
from fesloop.models.linear_form import SampledForm, numbers_of
from fesloop.models.linear_model import zero_order_hold

Array = NDArray[np.float64]
Rows = NDArray[np.intp]
Marks = NDArray[np.bool_]
_MOST_STATES = 3000
"""Most states of a loop (chosen: a matrix of 72 MB)."""
_PLANT_INPUT = 0
"""Number of the input of a linear plant, which has one, whatever its number among the ports."""


@dataclass(frozen=True, slots=True, eq=False)
class Flow:
    """The linear step from one draw to the next.

    Attributes
    ----------
    matrix: (after, before).
    covariance: (after, after), of the noise of these ticks.
    readings: (readings, outputs, before), the recorder's readings in between, as rows of the state.
    reading_variance: (readings, outputs), from the noise of these ticks.
    """

    matrix: Array
    covariance: Array
    readings: Array
    reading_variance: Array


@dataclass(frozen=True, slots=True, eq=False)
class Draw:
    """A random choice among rows of the state: each row after it is a copy of a row before it.

    Attributes
    ----------
    chances: (before, after), transition probabilities of the chain; (choices,) for an independent draw.
    takes: (states or choices, rows after), index of the row before that each row after is a copy of.
    """

    chances: Array
    takes: Rows

    @property
    def independent(self) -> bool:
        """Whether the draw is independent of those before it."""
        return self.chances.ndim == 1


Step = Flow | Draw


@dataclass(frozen=True, slots=True, eq=False)
class PeriodMap:
    """The map of a loop's state over one period.

    Attributes
    ----------
    period_s: its length.
    steps: applied in order; the rows after the last are those before the first.
    chain: probabilities of the Markov chain's states as the period begins: ages under jitter, whether the
        last message was lost where losses come in bursts; a single 1 elsewhere.
    """

    period_s: float
    steps: tuple[Step, ...]
    chain: Array

    @property
    def matrix(self) -> Array | None:
        """The matrix of the map where it has no random draws, else None."""
        only = self.steps[0]
        return only.matrix if len(self.steps) == 1 and isinstance(only, Flow) else None


@within_floats("a period of the loop")
def period_map(loop: LinearLoop, read: bool = True, watched: str = "") -> PeriodMap:
    """The map of a loop over a period, with the recorder's readings where `read`.

    `watched` names a block all of whose outputs are read instead.
    """
    plan = schedule(loop, read and not watched)
    period = PeriodRun(loop, plan, watched)
    steps, chances = period.run()
    return PeriodMap(plan.period_ns / NS_PER_S, tuple(pruned(steps, period.rows.plant)), chances)


class _Layout:
    """Rows of the state, by their owner."""

    def __init__(self, loop: LinearLoop, plan: Schedule) -> None:
        self.total = 0
        form = loop.plant_form
        self.plant = self._next(form.a.shape[0])
        self.port = {(loop.plant.name, _PLANT_INPUT): self._next(form.b.shape[1])}
        self.block = {node.name: self._next(block.a.shape[0]) for node, block in loop.blocks}
        deliveries = [each for event in plan.events for each in event.deliveries]
        self.sent: dict[str, list[slice]] = {}
        self.oldest = 0
        for connection in loop.connections:
            mine = [each for each in deliveries if each.connection is connection]
            port = connection.source.part.outputs[connection.source_port]
            size = len(form.c) if connection.source is loop.plant else numbers_of(port)
            depth = 1 + max((age for each in mine for age in each.ages), default=0)
            looks = [each.look for each in mine if each.look is not None]
            if looks:
                depth = self.oldest = ages.oldest_age(connection, looks)
            if self.total + depth * size > _MOST_STATES:
                raise RunError(f"{connection.wire.name}: {depth} messages are under way at once, which makes "
                               f"more than {_MOST_STATES} states")
            self.sent[connection.wire.name] = [self._next(size) for _ in range(depth)]
            if connection.target is not loop.plant:
                self.port[connection.target.name, connection.target_port] = self._next(size)

    def _next(self, size: int) -> slice:
        self.total += size
        return slice(self.total - size, self.total)


class PeriodRun:
    """Runs a period on rows."""

    def __init__(self, loop: LinearLoop, plan: Schedule, watched: str) -> None:
        self.loop, self.plan, self.watched = loop, plan, watched
        self.rows = _Layout(loop, plan)
        self.forms: dict[str, SampledForm] = {node.name: form for node, form in loop.blocks}
        self.outputs = len(self.forms[watched].c) if watched else len(loop.truth)
        self.steps: list[Step] = []
        self.transitions: list[Array] = []
        self.held: dict[int, tuple[Array, Array]] = {}
        self._begin()

    def _begin(self) -> None:
        """Begin a flow."""
        self.z = np.eye(self.rows.total)
        self.readings: list[Array] = []

    def _end(self) -> None:
        """End the flow, and begin the next one."""
        states, outputs = self.rows.total, self.outputs
        noise = self.z[:, states:]
        readings = np.zeros((len(self.readings), outputs, self.z.shape[1]))
        for row, reading in zip(readings, self.readings, strict=True):
            row[:, :reading.shape[1]] = reading
        self.steps.append(Flow(self.z[:, :states], noise @ noise.T, readings[..., :states],
                               np.square(readings[..., states:]).sum(axis=-1)))
        self._begin()

    def run(self) -> tuple[list[Step], Array]:
        """All steps, and the probabilities of the ages as the period begins."""
        now = 0
        for event in self.plan.events:
            self._advance(event.time_ns - now)
            now = event.time_ns
            for delivery in event.deliveries:
                self._deliver(delivery)
            if isinstance(event.what, Node):
                self._step(event.what)
            elif isinstance(event.what, Sampling):
                self._sample(event.what)
            elif not event.deliveries:
                self.readings.append(self.loop.truth @ self.z[self.rows.plant])
        self._advance(self.plan.period_ns - now)
        self._end()
        return self._possible() if self.transitions else (self.steps, np.ones(1))

    def _possible(self) -> tuple[list[Step], Array]:
        """The steps without states of the chain that never occur, and the probabilities of the others."""
        kept = np.flatnonzero(np.any([chances.any(axis=0) for chances in self.transitions], axis=0))
        steps = [step if isinstance(step, Flow) or step.independent else
                 Draw(step.chances[np.ix_(kept, kept)], step.takes[kept]) for step in self.steps]
        return steps, ages.stationary([chances[np.ix_(kept, kept)] for chances in self.transitions])

    def _advance(self, duration_ns: int) -> None:
        """Advance the plant with its input held."""
        if duration_ns == 0:
            return
        if duration_ns not in self.held:
            form = self.loop.plant_form
            self.held[duration_ns] = zero_order_hold(form.a, form.b, duration_ns / NS_PER_S)
        phi, gamma = self.held[duration_ns]
        plant, port = self.rows.plant, self.rows.port[self.loop.plant.name, _PLANT_INPUT]
        self.z[plant] = phi @ self.z[plant] + gamma @ self.z[port]

    def _deliver(self, delivery: Delivery) -> None:
        """Let a port hold an arrived message, certainly or by chance."""
        connection = delivery.connection
        number = _PLANT_INPUT if connection.target is self.loop.plant else connection.target_port
        port, sent = self.rows.port[connection.target.name, number], self.rows.sent[connection.wire.name]
        if delivery.look is not None:
            chances = ages.transition(connection, delivery.look, self.rows.oldest)
            self.transitions.append(chances)
            self._draw(chances, port, [*sent, port])
        elif bursts(connection):
            begins, stays = transition_probabilities(connection.wire.loss, connection.wire.burst_messages)
            chances = np.array([[1.0 - begins, begins], [1.0 - stays, stays]])
            for age in reversed(delivery.ages):
                self.transitions.append(chances)
                self._draw(chances, port, [sent[age], port])
        elif connection.wire.loss:
            lost = connection.wire.loss ** np.arange(len(delivery.ages) + 1)
            chances = np.append(lost[:-1] * (1.0 - connection.wire.loss), lost[-1])
            self._draw(chances, port, [*(sent[age] for age in delivery.ages), port])
        else:
            self.z[port] = self.z[sent[delivery.ages[0]]]

    def _draw(self, chances: Array, port: slice, sources: list[slice]) -> None:
        """Let a port take one of several rows by chance."""
        self._end()
        takes = np.tile(np.arange(self.rows.total), (len(sources), 1))
        for take, source in zip(takes, sources, strict=True):
            take[port] = np.arange(source.start, source.stop)
        self.steps.append(Draw(chances, takes))

    def _step(self, node: Node) -> None:
        """Step a block: outputs and states from its ports' values, with new noise."""
        form, block = self.forms[node.name], self.rows.block[node.name]
        names = [port.name for port in node.part.inputs]
        given = np.concatenate([self._held(node, names.index(name)) for name in form.inputs])
        self.z = np.hstack([self.z, np.zeros((self.rows.total, form.noise.shape[1]))])
        given = np.hstack([given, np.zeros((len(given), form.noise.shape[1]))])
        output = form.c @ self.z[block] + form.d @ given
        output[:, output.shape[1] - form.noise.shape[1]:] += form.noise
        self.z[block] = form.a @ self.z[block] + form.b @ given
        if node.name == self.watched:
            self.readings.append(output)
        number = [port.name for port in node.part.outputs].index(form.output)
        for connection in self.loop.connections:
            if connection.source is node and connection.source_port == number:
                self._send(connection.wire.name, output)

    def _held(self, node: Node, port: int) -> Array:
        """Rows of the value that a port holds; zero where its wire comes from outside the loop."""
        rows = self.rows.port.get((node.name, port))
        size = numbers_of(node.part.inputs[port])
        return self.z[rows] if rows is not None else np.zeros((size, self.z.shape[1]))

    def _sample(self, sampling: Sampling) -> None:
        """Send the plant's output on every wire that samples it now."""
        output = self.loop.plant_form.c @ self.z[self.rows.plant]
        for connection in sampling.connections:
            self._send(connection.wire.name, output)

    def _send(self, wire: str, value: Array) -> None:
        """Send a message: the others grow older by one."""
        sent = self.rows.sent[wire]
        for older, newer in pairwise(reversed(sent)):
            self.z[older] = self.z[newer]
        self.z[sent[0]] = value


def pruned(steps: list[Step], kept: slice) -> list[Step]:
    """The steps without rows that have no effect, and rows that always stay at 0.

    A row has an effect if it changes a reading or a kept row; a row moves if noise or a kept row moves it.
    (The integral of a controller without integral gain does neither, and would never come to rest.)
    """
    live = _settled(steps[::-1], kept, _live_before)[::-1]
    moved = _settled(steps, kept, _moved_after)
    rows = [np.flatnonzero(here & there) for here, there in zip(live, moved, strict=True)]
    return [_restricted(step, before, after)
            for step, before, after in zip(steps, rows[:-1], rows[1:], strict=True)]


def _settled(steps: list[Step], kept: slice, passed: Callable[[Step, Marks], Marks]) -> list[Marks]:
    """Marks between the steps, first to last, after as many rounds of the cycle as add marks."""
    first = steps[0]
    rows = len(first.matrix) if isinstance(first, Flow) else len(first.takes[0])
    marks: Marks = np.zeros(rows, dtype=bool)
    marks[kept] = True
    while True:
        found = [marks]
        for step in steps:
            found.append(passed(step, found[-1]))
        if not (found[-1] & ~marks).any():
            return [*found[:-1], marks]
        marks = marks | found[-1]


def _live_before(step: Step, after: Marks) -> Marks:
    """Rows before a step that have an effect on live rows after it."""
    if isinstance(step, Flow):
        return np.asarray((step.matrix[after] != 0.0).any(axis=0) | (step.readings != 0.0).any(axis=(0, 1)))
    before = np.zeros(after.size, dtype=bool)
    before[np.unique(step.takes[:, after])] = True
    return before


def _moved_after(step: Step, before: Marks) -> Marks:
    """Rows after a step that noise, or rows that move before it, move."""
    if isinstance(step, Flow):
        return np.asarray((step.matrix[:, before] != 0.0).any(axis=1) | (np.diag(step.covariance) != 0.0))
    return np.asarray(before[step.takes].any(axis=0))


def _restricted(step: Step, before: Rows, after: Rows) -> Step:
    """The step between the rows that are left."""
    if isinstance(step, Flow):
        return replace(step, matrix=step.matrix[np.ix_(after, before)], readings=step.readings[..., before],
                       covariance=step.covariance[np.ix_(after, after)])
    return replace(step, takes=np.searchsorted(before, step.takes[:, after]))
