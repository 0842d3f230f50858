"""Plants in operation: advanced no further than someone looks, split only where an input changes.

A plant is advanced when one of its outputs is sampled. Messages that arrived on the way split the advance
at their instants (an exact plant) or are latched at the next grid tick (a fixed-step plant). What the
recorder wants to see in between is evaluated beside the trajectory, so observing changes no bit of it.
"""

from __future__ import annotations

import copy
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from fesloop.loop.block import Plant
from fesloop.loop.clock import FOREVER, RateClock, ticks_from
from fesloop.loop.plant_ports import PlantInputs, PlantRecord
from fesloop.loop.record import EventRow
from fesloop.loop.signals import Value
from fesloop.loop.wire import Link


class ExactStation:
    """A plant that goes to any instant.

    Attributes
    ----------
    now: the instant that `state` is of, ns.
    hand_over: has the recorder take what was seen.
    """

    __slots__ = ("_advance", "_advance_through", "_inputs", "_observe", "_read", "_record", "_shown",
                 "hand_over", "name", "now", "plant", "state")

    def __init__(self, name: str, plant: Plant, state: Any, inputs: PlantInputs, record: PlantRecord) -> None:
        self.name, self.plant, self.state = name, plant, state
        self.now = 0
        self._inputs, self._record, self.hand_over = inputs, record, record.hand_over
        self._advance, self._read = plant.advance, plant.read
        self._observe = getattr(plant, "observe", None) or self._observe_a_copy
        self._advance_through = None if plant.feedthrough else getattr(plant, "advance_through", None)
        self._shown: tuple[Value, ...] | None = None

    def read_now(self) -> tuple[Value, ...]:
        """Outputs of the instant `now`."""
        return self._read(self.state, self._inputs.values)

    def values_through(self, times_ns: Sequence[int]) -> Iterator[tuple[int, int, tuple[Value, ...]]]:
        """(instant, instant, outputs) at increasing instants, the plant going along."""
        for instant in times_ns:
            self._pass_inputs(instant)
            if instant > self.now:
                self._go(instant)
            self._shown = shown = self._read(self.state, self._inputs.values)
            yield instant, instant, shown

    @property
    def stacks(self) -> bool:
        """Whether outputs of many instants can be had at once, by `stacks_through`."""
        return self._advance_through is not None

    def hears(self, link: Link) -> bool:
        """Whether what is sent into a link comes to this plant."""
        return any(queue is link.queue for queue in self._inputs.queues)

    def stacks_through(
        self, times_ns: list[int], echo_ns: int
    ) -> Iterator[tuple[list[int], tuple[Any, ...]]]:
        """As `values_through`, the instants between two changes of the inputs at once, outputs stacked.

        What is sent at an instant may come back `echo_ns` later, so a stretch of instants is no longer.
        """
        assert self._advance_through is not None
        record, done = self._record, 0
        while done < len(times_ns):
            first = times_ns[done]
            self._pass_inputs(first)
            if record.next < first:
                self._note(first)
            change = min([queue[0][3] for queue in self._inputs.queues if queue], default=FOREVER)
            # A message acts from its arrival on: outputs of that instant do not show it yet.
            upto = bisect_right(times_ns, min(change, first + echo_ns), done)
            noted = record.instants_among(times_ns[done:upto])
            if record.next < times_ns[upto - 1]:
                # Evaluated ahead from the sample before it, as if that had been taken by itself.
                upto = bisect_left(times_ns, record.next, done)
            instants, done = times_ns[done:upto], upto
            found = self._advance_through(self.state, self._inputs.values, self.now, instants)
            if noted:
                record.see_stacks([instants[k] for k in noted], tuple(stack[noted] for stack in found))
            stacks = tuple(stack.tolist() if stack.ndim == 1 else stack for stack in found)
            self.now = instants[-1]
            self._shown = tuple(stack[-1] for stack in stacks)
            yield instants, stacks

    def observed_at(self, times_ns: Sequence[int]) -> Iterator[tuple[int, int, tuple[Value, ...]]]:
        """(instant, instant, outputs) at increasing instants, the plant going to input changes only."""
        for instant in times_ns:
            self._pass_inputs(instant)
            stacks = self._observe(self.state, self._inputs.values, self.now, [instant])
            values = tuple(float(stack[0]) if stack.ndim == 1 else stack[0] for stack in stacks)
            yield instant, instant, values

    def _pass_inputs(self, time_ns: int) -> None:
        """Go to the last input change by `time_ns`, through all before it."""
        for queue in self._inputs.queues:
            if queue and queue[0][3] <= time_ns:
                break
        else:
            return
        for arrival, port, link in self._inputs.due(time_ns):
            if arrival > self.now:
                self._go(arrival)
            self._inputs.latch(port, link, arrival)

    def settle(self, time_ns: int) -> None:
        """Latch what has arrived by `time_ns` and record up to and including it, without going there."""
        self._pass_inputs(time_ns)
        if self._record.next <= time_ns:
            self._note(time_ns + 1)
        self.hand_over()

    def finish(self, time_ns: int) -> None:
        """Go to where a trial ends, however long nobody has looked: the next begins with what that leaves."""
        if time_ns > self.now:
            self._go(time_ns)

    def _go(self, stop_ns: int) -> None:
        """Advance under the inputs as they are."""
        if self._record.next < stop_ns:
            self._note(stop_ns)
        self._advance(self.state, self._inputs.values, self.now, stop_ns)
        self._shown = None
        self.now = stop_ns

    def _note(self, stop_ns: int) -> None:
        """Note the outputs at the recorder's instants before `stop_ns`: as just read, or evaluated ahead."""
        times = self._record.instants_before(stop_ns)
        if self._shown is not None and times == [self.now] and not self.plant.feedthrough:
            self._record.see(self.now, self.now, self._shown)
        else:
            self._record.see_stacks(times, self._observe(self.state, self._inputs.values, self.now, times))

    def _observe_a_copy(
        self, state: Any, inputs: Sequence[Value], start_ns: int, times_ns: Sequence[int]
    ) -> tuple[Any, ...]:
        """What `observe` gives, for a plant without it."""
        seen = []
        for instant in times_ns:
            # Each from the same start: what is seen must not depend on where a stretch of the run ended.
            ahead = copy.deepcopy(state)
            if instant > start_ns:
                self._advance(ahead, inputs, start_ns, instant)
            seen.append(self._read(ahead, inputs))
        return tuple(np.array(column) for column in zip(*seen, strict=True))

    def save(self) -> Any:
        """All that changes, for a snapshot."""
        return self.state, self.now, self._inputs.save()

    def restore(self, saved: Any, recorded_to_ns: int) -> None:
        """Back to what `save` gave; the recorder goes on after `recorded_to_ns`."""
        self.state, self.now, inputs = saved
        self._inputs.restore(inputs)
        self._record.resume(recorded_to_ns)
        self._shown = None


class GridStation:
    """A plant of fixed steps: it rests at its last grid tick, and latches its inputs at the next.

    Attributes
    ----------
    now: the grid tick that `state` is of, ns.
    hand_over: has the recorder take what was seen.
    """

    __slots__ = ("_advance", "_events", "_following", "_glance", "_grid", "_inputs", "_next_step", "_read",
                 "_record", "_reports", "_shown", "hand_over", "name", "now", "plant", "state")

    def __init__(self, name: str, plant: Plant, state: Any, inputs: PlantInputs, record: PlantRecord,
                 grid: RateClock, events: list[EventRow]) -> None:
        self.name, self.plant, self.state = name, plant, state
        self.now = 0
        self._inputs, self._record, self._grid = inputs, record, grid
        self.hand_over = record.hand_over
        self._advance, self._read = plant.advance, plant.read
        self._glance = None if plant.feedthrough else getattr(plant, "glance", None)
        self._reports, self._events = getattr(plant, "reports", None), events
        self._shown: tuple[Value, ...] | None = None
        self._start_steps()

    def _start_steps(self) -> None:
        """Have the steps go on from `now`."""
        self._next_step = ticks_from(self._grid, self._grid.first_at_or_after(self.now + 1))
        self._following = self._next_step()

    def values_through(self, times_ns: Sequence[int]) -> Iterator[tuple[int, int, tuple[Value, ...]]]:
        """(instant, last grid tick by then, outputs of that tick), which are read once a tick."""
        return self._through(times_ns, None)

    def glances_through(self, times_ns: Sequence[int]) -> Iterator[tuple[int, int, Mapping[int, Value]]]:
        """As `values_through`, by port number: those outputs alone that the plant gives at a glance."""
        return self._through(times_ns, self._glance)

    def _through(self, times_ns: Sequence[int], glance: Callable[[Any], Any] | None) -> Iterator[Any]:
        state, inputs, record, advance = self.state, self._inputs, self._record, self._advance
        values, queues, direct = inputs.values, inputs.queues, self.plant.feedthrough
        reports = self._reports
        following = self._following
        for instant in times_ns:
            while following <= instant:
                now = self.now
                for queue in queues:
                    if queue and queue[0][3] <= now:
                        self._latch_due()
                if record.next < following:
                    shown = self._shown
                    record.see_held(now, following, self.read_now() if shown is None or direct else shown)
                advance(state, values, now, following)
                if reports is not None:
                    self._events += [(following, self.name, *each) for each in reports(state)]
                self._shown = None
                self.now = following
                self._following = following = self._next_step()
            if glance is not None:
                yield instant, self.now, glance(state)
                continue
            if direct:
                self._latch_due()
            if direct or self._shown is None:
                self._shown = self._read(state, values)
            yield instant, self.now, self._shown

    observed_at = values_through
    """Fixed steps are the same whoever looks."""

    def glances(self, ports: Collection[int]) -> bool:
        """Whether these outputs, by number, can be had at a glance."""
        return self._glance is not None and self._glance(self.state).keys() >= set(ports)

    def read_now(self) -> tuple[Value, ...]:
        """Outputs at the last grid tick, read once unless they follow the inputs."""
        if self._shown is None or self.plant.feedthrough:
            self._shown = self._read(self.state, self._inputs.values)
        return self._shown

    def _latch_due(self) -> None:
        """Deliver what arrived by the last grid tick, in order of arrival; it acts from there on."""
        self._inputs.latch_due(self.now)

    def settle(self, time_ns: int) -> None:
        """Go as far as the grid allows, record up to and including `time_ns`, hand the rows over."""
        for _ in self.values_through((time_ns,)):
            self._latch_due()
        if self._record.next <= time_ns:
            self._record.see_held(self.now, time_ns + 1, self.read_now())
        self.hand_over()

    def finish(self, time_ns: int) -> None:
        """Rest where `settle` has gone, as far as the grid allows."""

    def save(self) -> Any:
        """All that changes, for a snapshot."""
        return self.state, self.now, self._inputs.save()

    def restore(self, saved: Any, recorded_to_ns: int) -> None:
        """Back to what `save` gave; the recorder goes on after `recorded_to_ns`."""
        self.state, self.now, inputs = saved
        self._inputs.restore(inputs)
        self._record.resume(recorded_to_ns)
        self._shown = None
        self._start_steps()


PlantStation = ExactStation | GridStation
