"""Plants in operation: advanced no further than someone looks, split only where an input changes.

A plant is advanced when one of its outputs is sampled. Messages that arrived on the way split the advance
at their instants (an exact plant) or are latched at the next grid tick (a fixed-step plant). What the
recorder wants to see in between is evaluated beside the trajectory, so observing changes no bit of it.
"""

from __future__ import annotations

import copy
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from fesloop.errors import RunError
from fesloop.loop.block import Plant
from fesloop.loop.clock import FOREVER, NS_PER_MS, RateClock, ticks_from
from fesloop.loop.record import InputRow, PlantRow
from fesloop.loop.signals import NEVER, Sample, Value
from fesloop.loop.wire import Link

Incoming = tuple[tuple[int, Link], ...]


class PlantStation:
    """What exact and fixed-step plants share: inputs, messages, the recorder's instants."""

    __slots__ = (
        "_advance",
        "_feeds",
        "_next_record",
        "_queues",
        "_read",
        "held",
        "input_rows",
        "inputs",
        "name",
        "now",
        "plant",
        "record_clock",
        "record_next",
        "rows",
        "state",
    )

    def __init__(self, name: str, plant: Plant, state: Any, incoming: Incoming, rows: list[PlantRow] | None,
                 input_rows: list[InputRow] | None, record_clock: RateClock | None) -> None:
        self.name, self.plant, self.state = name, plant, state
        self.inputs: list[Value] = [port.initial_value() for port in plant.inputs]
        self.held = [Sample(value, NEVER, NEVER, NEVER) for value in self.inputs]
        self.now = 0
        self.rows, self.input_rows = rows, input_rows
        self.record_clock = record_clock
        self.record_next = FOREVER
        if record_clock is not None and rows is not None:
            self._next_record = ticks_from(record_clock, 0)
            self.record_next = self._next_record()
        self._feeds = tuple((port, link, link.queue) for port, link in incoming)
        self._queues = tuple(link.queue for _, link in incoming)
        self._advance, self._read = plant.advance, plant.read

    def values_through(self, times_ns: Sequence[int]) -> Iterator[tuple[int, int, tuple[Value, ...]]]:
        """(instant, physical instant of the values, outputs) at increasing instants, going along."""
        raise NotImplementedError

    def settle(self, time_ns: int) -> None:
        """Everything up to `time_ns` is over: latch what has arrived and record what is due."""
        raise NotImplementedError

    def _next_feed(self, time_ns: int) -> tuple[int, Link] | None:
        """Port and link of the next message due at or before `time_ns`."""
        first, found = time_ns + 1, None
        for port, link, queue in self._feeds:
            if queue and queue[0][3] < first:
                first, found = queue[0][3], (port, link)
        return found

    def _latch(self, port: int, link: Link, acts_ns: int) -> None:
        """Deliver one message; it acts from `acts_ns` on."""
        before = self.held[port]
        sample = link.take(before)
        if sample is before:
            return
        self.held[port] = sample
        self.inputs[port] = sample[0]
        if self.input_rows is not None:
            self.input_rows.append((acts_ns, port, sample[1], sample[2], sample[0]))

    def _instants_before(self, stop_ns: int) -> list[int]:
        """The recorder's instants before `stop_ns` that have not been recorded."""
        following = self._next_record
        times = [self.record_next]
        while (instant := following()) < stop_ns:
            times.append(instant)
        self.record_next = instant
        return times

    def _check_recorded(self, times: Sequence[int], stacks: Sequence[Any]) -> None:
        """Raise RunError where a recorded output is not finite, naming the first instant."""
        for port, stack in zip(self.plant.outputs, stacks, strict=True):
            finite = np.isfinite(stack).reshape(len(times), -1).all(axis=1)
            if not finite.all():
                at = times[int(np.argmin(finite))]
                raise RunError(f"{self.name}.{port.name} is not finite at {at / NS_PER_MS:.6f} ms: "
                               "the simulation became unstable")

    def save(self) -> Any:
        """All that changes, for a snapshot."""
        return self.state, self.now, list(self.inputs), list(self.held)

    def restore(self, saved: Any, recorded_to_ns: int) -> None:
        """Back to what `save` gave; the recorder goes on after `recorded_to_ns`."""
        self.state, self.now, self.inputs[:], self.held[:] = saved
        if self.record_clock is not None and self.rows is not None:
            first = self.record_clock.first_at_or_after(recorded_to_ns + 1)
            self._next_record = ticks_from(self.record_clock, first)
            self.record_next = self._next_record()


class ExactStation(PlantStation):
    """A plant that goes to any instant."""

    __slots__ = ("_observe",)

    def __init__(self, *args: Any) -> None:
        super().__init__(*args)
        self._observe = getattr(self.plant, "observe", None) or self._observe_a_copy

    def values_through(self, times_ns: Sequence[int]) -> Iterator[tuple[int, int, tuple[Value, ...]]]:
        """(instant, instant, outputs): the values are of the very instant."""
        for instant in times_ns:
            self._advance_to(instant)
            yield instant, instant, self._read(self.state, self.inputs)

    def _advance_to(self, time_ns: int) -> None:
        """Go to `time_ns`, past every input change on the way."""
        self._pass_inputs(time_ns)
        if time_ns > self.now:
            self._go(time_ns)

    def _pass_inputs(self, time_ns: int) -> None:
        """Go to the last input change by `time_ns`, through all before it."""
        while (feed := self._next_feed(time_ns)) is not None:
            port, link = feed
            arrival = link.queue[0][3]
            if arrival > self.now:
                self._go(arrival)
            self._latch(port, link, arrival)

    def settle(self, time_ns: int) -> None:
        """Latch what has arrived by `time_ns` and record up to and including it, without going there."""
        self._pass_inputs(time_ns)
        if self.record_next <= time_ns:
            self._record(time_ns + 1)

    def _go(self, stop_ns: int) -> None:
        """Advance under the inputs as they are."""
        if self.record_next < stop_ns:
            self._record(stop_ns)
        self._advance(self.state, self.inputs, self.now, stop_ns)
        self.now = stop_ns

    def _record(self, stop_ns: int) -> None:
        """Evaluate the outputs at the recorder's instants before `stop_ns`."""
        times = self._instants_before(stop_ns)
        stacks = self._observe(self.state, self.inputs, self.now, times)
        self._check_recorded(times, stacks)
        assert self.rows is not None
        self.rows.append((times, times, stacks))

    def _observe_a_copy(
        self, state: Any, inputs: Sequence[Value], start_ns: int, times_ns: Sequence[int]
    ) -> tuple[Any, ...]:
        """What `observe` gives, for a plant without it."""
        ahead, now, seen = copy.deepcopy(state), start_ns, []
        for instant in times_ns:
            if instant > now:
                self._advance(ahead, inputs, now, instant)
                now = instant
            seen.append(self._read(ahead, inputs))
        return tuple(np.array(column) for column in zip(*seen, strict=True))


class GridStation(PlantStation):
    """A plant of fixed steps: it rests at its last grid tick, and latches its inputs at the next."""

    __slots__ = ("_direct", "_following", "_grid", "_next_step", "_see", "_seen", "_shown")

    def __init__(self, *args: Any) -> None:
        super().__init__(*args)
        grid = self.plant.grid
        assert grid is not None
        self._grid = grid
        self._start_steps(0)
        self._shown: tuple[Value, ...] | None = None
        self._seen: list[tuple[int, int, tuple[Value, ...]]] = []
        self._see = self._seen.append
        self._direct = self.plant.feedthrough

    def _start_steps(self, now_ns: int) -> None:
        """Rest at a grid tick, the next one being the end of the next step."""
        self._next_step = ticks_from(self._grid, self._grid.first_at_or_after(now_ns + 1))
        self._following = self._next_step()

    def values_through(self, times_ns: Sequence[int]) -> Iterator[tuple[int, int, tuple[Value, ...]]]:
        """(instant, last grid tick by then, outputs of that tick), which are read once a tick."""
        state, inputs, advance, read = self.state, self.inputs, self._advance, self._read
        direct, queues, following = self._direct, self._queues, self._following
        for instant in times_ns:
            while following <= instant:
                now = self.now
                for queue in queues:
                    if queue and queue[0][3] <= now:
                        self._latch_due()
                if self.record_next < following:
                    self._record(following)
                advance(state, inputs, now, following)
                self._shown = None
                self.now = following
                self._following = following = self._next_step()
            if direct:
                self._latch_due()
            if direct or self._shown is None:
                self._shown = read(state, inputs)
            yield instant, self.now, self._shown

    def _latch_due(self) -> None:
        """Deliver what arrived by this grid tick, in order of arrival."""
        while (feed := self._next_feed(self.now)) is not None:
            self._latch(*feed, self.now)

    def settle(self, time_ns: int) -> None:
        """Go as far as the grid allows, record up to and including `time_ns`, hand the rows over."""
        for _ in self.values_through((time_ns,)):
            self._latch_due()
        if self.record_next <= time_ns:
            self._record(time_ns + 1)
        self._hand_over()

    def _record(self, stop_ns: int) -> None:
        """The outputs stand still until the next step: record them for the instants before `stop_ns`."""
        values = self._shown
        if values is None or self._direct:
            values = self._shown = self._read(self.state, self.inputs)
        instant = self.record_next
        while instant < stop_ns:
            self._see((instant, self.now, values))
            instant = self._next_record()
        self.record_next = instant

    def _hand_over(self) -> None:
        """Stack what was seen into one row for the recorder."""
        if self._seen:
            times, captured, values = (list(column) for column in zip(*self._seen, strict=True))
            stacks = tuple(np.array(column) for column in zip(*values, strict=True))
            self._check_recorded(times, stacks)
            assert self.rows is not None
            self.rows.append((times, captured, stacks))
            self._seen.clear()

    def restore(self, saved: Any, recorded_to_ns: int) -> None:
        """Back to what `save` gave; the recorder goes on after `recorded_to_ns`."""
        super().restore(saved, recorded_to_ns)
        self._start_steps(self.now)
        self._shown = None
