"""Plants in operation: advanced no further than needed, split only where an input changes.

A plant is advanced when one of its outputs is sampled. Messages that arrived on the way split the advance
at their instants (an exact plant) or are latched at the next grid tick (a fixed-step plant). Outputs for the
recorder in between are evaluated beside the trajectory, so that recording changes no bit of it.

Samples that are not read yet need no event of their own. A block that is about to read requests everything
that was due by then, and the samples are made in order of time, as if each had been made at its tick: the
plant passes the same instants and the same inputs.
"""

from __future__ import annotations

import copy
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence, Set
from typing import Any

import numpy as np

from fesloop.errors import RunError
from fesloop.loop.abilities import AdvancesSteps, AdvancesThrough, Glances, Observes, Reports, offers
from fesloop.loop.block import Plant
from fesloop.loop.clock import FOREVER, NS_PER_MS, Clock, RateClock, ticks_from
from fesloop.loop.record import EventRow, InputRow, PlantRow
from fesloop.loop.signals import (
    NEVER,
    Sample,
    Value,
    check_shapes,
    finite_check,
    is_finite,
    is_ours,
    read_only,
)
from fesloop.loop.wire import Link

_new_tuple = tuple.__new__
"""Makes a Sample of a message without the cost of its argument handling."""


_NO_MESSAGE = (0.0, NEVER, NEVER, FOREVER)
"""Message that never arrives."""


def _reader(plant: Plant) -> Callable[[Any, Sequence[Value]], tuple[Value, ...]]:
    """`read` of a plant; of one that is not ours with copies, as it may give an array of its state."""
    read = plant.read
    if is_ours(plant):
        return read

    def fresh(state: Any, inputs: Sequence[Value]) -> tuple[Value, ...]:
        values: Any = read(state, inputs)
        if not isinstance(values, tuple):
            return values  # type: ignore[no-any-return]  # refused where outputs are checked
        return tuple([value.copy() if isinstance(value, np.ndarray) else value for value in values])

    return fresh


def _named(plant: Plant, values: Sequence[Value]) -> dict[str, Value]:
    return {port.name: value for port, value in zip(plant.outputs, values, strict=True)}


class PlantInputs:
    """Input values of a plant, constant between messages.

    Attributes
    ----------
    values: by port; what `Plant.advance` is given.
    queues: of the messages under way to the plant.
    """

    __slots__ = ("_feeds", "_guarded", "_held", "_rows", "queues", "values")

    def __init__(
        self, plant: Plant, incoming: Sequence[tuple[int, Link]], rows: list[InputRow] | None
    ) -> None:
        self.values: list[Value] = [port.initial_value() for port in plant.inputs]
        self._held = [Sample(value, NEVER, NEVER, NEVER) for value in self.values]
        self._feeds = tuple((port, link, link.queue) for port, link in incoming)
        self._rows, self._guarded = rows, not is_ours(plant)
        self.queues = tuple(link.queue for _, link in incoming)

    def due(self, time_ns: int) -> Iterator[tuple[int, int, Link]]:
        """(arrival, port, link) of each message due by `time_ns`, in order; the taker latches it."""
        while True:
            first, found = time_ns + 1, None
            for port, link, queue in self._feeds:
                if queue and queue[0][3] < first:
                    first, found = queue[0][3], (port, link)
            if found is None:
                return
            yield first, *found

    def latch_due(self, time_ns: int) -> None:
        """Deliver every message due by `time_ns`, in order of arrival; all act from `time_ns` on."""
        feeds = self._feeds
        while True:
            first, port, link = time_ns + 1, -1, None
            for number, each, queue in feeds:
                if queue and queue[0][3] < first:
                    first, port, link = queue[0][3], number, each
            if link is None:
                return
            self.latch(port, link, time_ns)

    def latch_through(self, times_ns: Sequence[int]) -> None:
        """Deliver every message due by each of `times_ns`, ascending, as `latch_due` at each in turn."""
        if len(self._feeds) != 1 or not self._feeds[0][1].plain or self._guarded:
            for instant in times_ns:
                self.latch_due(instant)
            return
        (port, _, queue), rows, message = self._feeds[0], self._rows, None
        for instant in times_ns:
            while queue and queue[0][3] <= instant:
                message = queue.popleft()
                if rows is not None:
                    rows.append((instant, port, message[1], message[2], message[0]))
        if message is not None:
            self._held[port] = _new_tuple(Sample, message)
            self.values[port] = message[0]

    @property
    def plain(self) -> bool:
        """True if what arrives is known from the messages under way, as none overtakes another."""
        return all(link.plain for _, link, _ in self._feeds)

    def ahead(self, times_ns: Sequence[int]) -> list[list[Value]]:
        """Values of each port at `times_ns`, ascending, for `plain` inputs; delivers nothing."""
        columns = [[value] * len(times_ns) for value in self.values]
        for port, _, queue in self._feeds:
            if queue and queue[0][3] <= times_ns[-1]:
                column, messages = columns[port], iter(queue)
                value, (following, _, _, arrival) = self.values[port], next(messages)
                for k, instant in enumerate(times_ns):
                    while arrival <= instant:
                        value = read_only(following) if self._guarded else following
                        following, _, _, arrival = next(messages, _NO_MESSAGE)
                    column[k] = value
        return columns

    def changes_before(self, time_ns: int) -> list[tuple[int, list[Value]]]:
        """Deliver every message due before `time_ns`; (arrival, values of all ports from then on) of each."""
        changes: list[tuple[int, list[Value]]] = []
        for arrival, port, link in self.due(time_ns - 1):
            self.latch(port, link, arrival)
            if changes and changes[-1][0] == arrival:
                changes.pop()
            changes.append((arrival, self.values.copy()))
        return changes

    def forget_after(self, time_ns: int) -> None:
        """Remove the rows of messages after an instant, at which a run has failed."""
        while self._rows and self._rows[-1][0] > time_ns:
            self._rows.pop()

    def latch(self, port: int, link: Link, acts_ns: int) -> None:
        """Deliver one message; it acts from `acts_ns` on."""
        if link.plain:
            sample = _new_tuple(Sample, link.queue.popleft())
        else:
            before = self._held[port]
            sample = link.take(before)
            if sample is before:
                return
        self._held[port] = sample
        self.values[port] = read_only(sample.value) if self._guarded else sample.value
        if self._rows is not None:
            self._rows.append((acts_ns, port, sample.oldest_ns, sample.newest_ns, sample.value))

    def save(self) -> Any:
        """Return everything that changes, for a snapshot."""
        return list(self.values), list(self._held)

    def restore(self, saved: Any) -> None:
        """Restore what `save` returned."""
        self.values[:], self._held[:] = saved


class PlantRecord:
    """Record of a plant's outputs at the recorder's own instants.

    `sampled` are the numbers of the output ports that wires sample.

    Attributes
    ----------
    next: the first instant that has not been noted; FOREVER where nothing is recorded.
    """

    __slots__ = ("_clock", "_name", "_next_instant", "_rows", "_seen", "_unsampled", "next")

    def __init__(self, name: str, plant: Plant, rows: list[PlantRow] | None, clock: RateClock | None,
                 sampled: Set[int]) -> None:
        self._name, self._clock = name, clock
        self._unsampled = tuple((i, port.name) for i, port in enumerate(plant.outputs) if i not in sampled)
        self._rows: list[PlantRow] = [] if rows is None else rows
        self._seen: list[tuple[int, int, tuple[Value, ...]]] = []
        self.next = FOREVER
        if rows is not None and clock is not None:
            self.resume(-1)

    def resume(self, recorded_to_ns: int) -> None:
        """Continue after an instant."""
        if self._clock is not None:
            self._next_instant = ticks_from(self._clock, self._clock.first_at_or_after(recorded_to_ns + 1))
            self.next = self._next_instant()

    def instants_before(self, stop_ns: int) -> list[int]:
        """The instants before `stop_ns` that have not been noted, which the caller notes now."""
        times, instant, following = [], self.next, self._next_instant
        while instant < stop_ns:
            times.append(instant)
            instant = following()
        self.next = instant
        return times

    def instants_among(self, times_ns: Sequence[int]) -> list[int]:
        """Places of the instants to note in `times_ns`, ascending, up to the first that is not among them.

        The caller notes these now.
        """
        places: list[int] = []
        while self.next <= times_ns[-1]:
            place = bisect_left(times_ns, self.next)
            if times_ns[place] != self.next:
                break
            places.append(place)
            self.next = self._next_instant()
        return places

    def see(self, instant: int, captured_ns: int, values: tuple[Value, ...]) -> None:
        """Note outputs that were read anyway."""
        self._seen.append((instant, captured_ns, values))

    def see_held(self, captured_ns: int, stop_ns: int, values: tuple[Value, ...]) -> None:
        """Note outputs that are constant until `stop_ns`."""
        instant, following, see = self.next, self._next_instant, self._seen.append
        while instant < stop_ns:
            see((instant, captured_ns, values))
            instant = following()
        self.next = instant

    def see_stacks(self, times: list[int], stacks: tuple[Any, ...]) -> None:
        """Note outputs evaluated at many instants."""
        self.hand_over()
        self._add(times, times, stacks)

    def hand_over(self) -> None:
        """Stack outputs that were noted one by one into a row for the recorder."""
        if seen := self._seen:
            # `zip` of many rows makes an object for each, and so garbage collections.
            stacks = tuple([np.array([row[2][port] for row in seen]) for port in range(len(seen[0][2]))])
            times, captured = [row[0] for row in seen], [row[1] for row in seen]
            seen.clear()
            self._add(times, captured, stacks)

    def _add(self, times: list[int], captured: list[int], stacks: tuple[Any, ...]) -> None:
        """One row. An output that is sampled is checked there; any other that is not finite ends the run."""
        for i, name in self._unsampled:
            if not is_finite(stacks[i]):
                finite = np.isfinite(stacks[i]).reshape(len(times), -1).all(axis=1)
                at = times[int(np.argmin(finite))]
                raise RunError(f"{self._name}.{name} is not finite at {at / NS_PER_MS:.6f} ms: "
                               "the simulation became unstable")
        self._rows.append((times, captured, stacks))


class ExactStation:
    """A plant that advances to any instant.

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
        self._advance, self._read = plant.advance, _reader(plant)
        self._observe = plant.observe if offers(plant, Observes) else self._observe_a_copy
        self._advance_through = (plant.advance_through
                                 if not plant.feedthrough and offers(plant, AdvancesThrough) else None)
        self._shown: tuple[Value, ...] | None = None

    def read_now(self) -> tuple[Value, ...]:
        """Outputs of the instant `now`."""
        return self._read(self.state, self._inputs.values)

    def peek(self) -> dict[str, Value]:
        """Outputs by port as of the instant `now`, read from a copy of the state: nothing changes."""
        return _named(self.plant, self._read(copy.deepcopy(self.state), self._inputs.values))

    def values_through(self, times_ns: Sequence[int]) -> Iterator[tuple[int, int, tuple[Value, ...]]]:
        """(instant, instant, outputs) at increasing instants; the plant advances to each."""
        for instant in times_ns:
            self._pass_inputs(instant)
            if instant > self.now:
                self._go(instant)
            self._shown = shown = self._read(self.state, self._inputs.values)
            yield instant, instant, shown

    @property
    def stacks(self) -> bool:
        """True if `stacks_through` gives outputs of many instants at once."""
        return self._advance_through is not None

    def reads(self, link: Link) -> bool:
        """True if a link leads to this plant."""
        return any(queue is link.queue for queue in self._inputs.queues)

    def stacks_through(
        self, times_ns: list[int], echo_ns: int, checks: Sequence[tuple[int, Callable[[Any], bool]]]
    ) -> Iterator[tuple[list[int], tuple[Any, ...]]]:
        """`values_through` for many instants at once, outputs stacked; `checks` are (port, `finite_check`).

        What is sent at an instant may come back `echo_ns` later, so a stretch of instants is no longer.
        Raises RunError where an output fails its check; the record ends there, as of single samples.
        """
        assert self._advance_through is not None
        record, done = self._record, 0
        while done < len(times_ns):
            first = times_ns[done]
            self._pass_inputs(first)
            if record.next < first:
                self._note(first)
            upto = bisect_right(times_ns, first + echo_ns, done)
            noted = record.instants_among(times_ns[done:upto])
            if record.next < times_ns[upto - 1]:
                # Evaluated ahead from the sample before it, as if that had been taken by itself.
                upto = bisect_left(times_ns, record.next, done)
            instants, done = times_ns[done:upto], upto
            # A message acts from its arrival on: outputs of that instant do not show it yet.
            held = [(self.now, self._inputs.values.copy()), *self._inputs.changes_before(instants[-1])]
            found = self._advance_through(self.state, held, instants)
            stacks = tuple(stack.tolist() if stack.ndim == 1 else stack for stack in found)
            self.now, failed = instants[-1], None
            if not all(is_finite(found[port]) for port, _ in checks):
                failed = next(((instant, port) for k, instant in enumerate(instants)
                               for port, finite in checks if not finite(stacks[port][k])), None)
            if failed is not None:
                self.now = failed[0]
                self._inputs.forget_after(self.now)
                noted = [k for k in noted if instants[k] < self.now]
            if noted:
                record.see_stacks([instants[k] for k in noted], tuple(stack[noted] for stack in found))
            if failed is not None:
                raise _unstable(self, failed[1], self.now)
            self._shown = tuple(stack[-1] for stack in stacks)
            yield instants, stacks

    def observed_at(self, times_ns: Sequence[int]) -> Iterator[tuple[int, int, tuple[Value, ...]]]:
        """(instant, instant, outputs) at increasing instants; the plant advances to input changes only."""
        for instant in times_ns:
            self._pass_inputs(instant)
            stacks = self._observe(self.state, self._inputs.values, self.now, [instant])
            values = tuple(float(stack[0]) if stack.ndim == 1 else stack[0] for stack in stacks)
            yield instant, instant, values

    def _pass_inputs(self, time_ns: int) -> None:
        """Advance to the last input change by `time_ns`, through all before it."""
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
        """Advance to the end of a trial, whose state the next trial takes over."""
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
        """Replacement of `observe` for a plant without it."""
        seen = []
        for instant in times_ns:
            # Each from the same start: what is seen must not depend on where a stretch of the run ended.
            ahead = copy.deepcopy(state)
            if instant > start_ns:
                self._advance(ahead, inputs, start_ns, instant)
            seen.append(self._read(ahead, inputs))
        return tuple(np.array(column) for column in zip(*seen, strict=True))

    def save(self) -> Any:
        """Return everything that changes, for a snapshot."""
        return self.state, self.now, self._inputs.save()

    def restore(self, saved: Any, recorded_to_ns: int) -> None:
        """Restore what `save` returned; the recorder continues after `recorded_to_ns`."""
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

    __slots__ = ("_advance", "_advance_steps", "_events", "_following", "_glance", "_grid", "_inputs",
                 "_next_step", "_read", "_record", "_refused_ns", "_reports", "_shown", "hand_over", "name",
                 "now", "plant", "state")

    def __init__(self, name: str, plant: Plant, state: Any, inputs: PlantInputs, record: PlantRecord,
                 grid: RateClock, events: list[EventRow]) -> None:
        self.name, self.plant, self.state = name, plant, state
        self.now = 0
        self._inputs, self._record, self._grid = inputs, record, grid
        self.hand_over = record.hand_over
        self._advance, self._read = plant.advance, _reader(plant)
        self._glance = plant.glance if not plant.feedthrough and offers(plant, Glances) else None
        self._reports, self._events = plant.reports if offers(plant, Reports) else None, events
        known = inputs.plain and self._reports is None and not plant.feedthrough
        self._advance_steps = plant.advance_steps if known and offers(plant, AdvancesSteps) else None
        self._refused_ns = NEVER  # the steps up to here are taken one by one
        self._shown: tuple[Value, ...] | None = None
        self._start_steps()

    def _start_steps(self) -> None:
        """Continue the steps from `now`."""
        self._next_step = ticks_from(self._grid, self._grid.first_at_or_after(self.now + 1))
        self._following = self._next_step()

    def values_through(self, times_ns: Sequence[int]) -> Iterator[tuple[int, int, tuple[Value, ...]]]:
        """(instant, last grid tick by then, outputs of that tick), which are read once a tick."""
        return self._through(times_ns, None)

    def glances_through(self, times_ns: Sequence[int]) -> Iterator[tuple[int, int, Mapping[int, Value]]]:
        """`values_through` with the outputs of `glance` alone, by port number."""
        return self._through(times_ns, self._glance)

    def _through(self, times_ns: Sequence[int], glance: Callable[[Any], Any] | None) -> Iterator[Any]:
        state, inputs, record, advance = self.state, self._inputs, self._record, self._advance
        values, queues, direct = inputs.values, inputs.queues, self.plant.feedthrough
        reports, at_once = self._reports, self._advance_steps is not None
        following = self._following
        for instant in times_ns:
            while following <= instant:
                now = self.now
                if at_once:
                    if record.next < following:
                        record.see_held(now, following, self.read_now())
                    if self._took_steps(instant):
                        following = self._following
                        continue
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

    def _took_steps(self, stop_ns: int) -> bool:
        """Take all steps up to an instant, or to the next of the recorder's, at once, if they are several."""
        assert self._advance_steps is not None
        last_ns = min(stop_ns, self._record.next)
        if last_ns <= self._refused_ns:
            return False
        times, following, next_step = [], self._following, self._next_step
        while following <= last_ns:
            times.append(following)
            following = next_step()
        starts = [self.now, *times[:-1]]
        if len(times) < 2 or not self._advance_steps(self.state, self._inputs.ahead(starts), self.now, times):
            self._refused_ns = last_ns
            self._start_steps()
            return False
        self._inputs.latch_through(starts)
        self._shown, self.now, self._following = None, times[-1], following
        return True

    observed_at = values_through
    """Sampling does not change fixed steps."""

    def glances(self, ports: Collection[int]) -> bool:
        """True if `glance` gives these outputs, by number."""
        return self._glance is not None and self._glance(self.state).keys() >= set(ports)

    def read_now(self) -> tuple[Value, ...]:
        """Outputs at the last grid tick, read once unless they follow the inputs."""
        if self._shown is None or self.plant.feedthrough:
            self._shown = self._read(self.state, self._inputs.values)
        return self._shown

    def peek(self) -> dict[str, Value]:
        """Outputs by port as of the instant `now`, read from a copy of the state: nothing changes."""
        return _named(self.plant, self._read(copy.deepcopy(self.state), self._inputs.values))

    def _latch_due(self) -> None:
        """Deliver what arrived by the last grid tick, in order of arrival; it acts from there on."""
        self._inputs.latch_due(self.now)

    def settle(self, time_ns: int) -> None:
        """Advance as far as the grid allows, record up to and including `time_ns`, hand the rows over."""
        for _ in self.values_through((time_ns,)):
            self._latch_due()
        if self._record.next <= time_ns:
            self._record.see_held(self.now, time_ns + 1, self.read_now())
        self.hand_over()

    def finish(self, time_ns: int) -> None:
        """Rest at the instant of `settle`, as far as the grid allows."""

    def save(self) -> Any:
        """Return everything that changes, for a snapshot."""
        return self.state, self.now, self._inputs.save()

    def restore(self, saved: Any, recorded_to_ns: int) -> None:
        """Restore what `save` returned; the recorder continues after `recorded_to_ns`."""
        self.state, self.now, inputs = saved
        self._inputs.restore(inputs)
        self._record.resume(recorded_to_ns)
        self._shown, self._refused_ns = None, NEVER
        self._start_steps()


PlantStation = ExactStation | GridStation


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
        self._plain = tuple((port, checks[port], link.queue, link.latency_ns)
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
            checks = [(port, finite) for port, finite, *_ in plain]
            for instants, stacks in self._stacks_through(dues, self._echo_ns, checks):
                self._send_stacks(instants, stacks)
            return
        for due, captured, values in self._values_at(dues):
            for port, finite, queue, latency in plain:
                value = values[port]
                if not finite(value):
                    raise _unstable(self.plant, port, due)
                queue.append((value, captured, captured, due + latency))
            for port, finite, send in random:
                if not finite(values[port]):
                    raise _unstable(self.plant, port, due)
                send(index, values[port], captured, captured, due)
            index += 1
        self.index = index

    def _send_stacks(self, instants: Sequence[int], stacks: tuple[Any, ...]) -> None:
        """Send outputs of many instants, stacked, into wires without jitter and loss."""
        for port, _, queue, latency in self._plain:
            arrivals = [instant + latency for instant in instants] if latency else instants
            queue.extend(zip(stacks[port], instants, instants, arrivals, strict=True))

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
        """Return everything that changes, for a snapshot."""
        return self.index

    def restore(self, saved: int) -> None:
        """Restore what `save` returned."""
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
