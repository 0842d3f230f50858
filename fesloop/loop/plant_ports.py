"""The two sides of a plant in operation: inputs latched from messages, outputs noted for the record."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterator, Sequence, Set
from typing import Any

import numpy as np

from fesloop.errors import RunError
from fesloop.loop.block import Plant
from fesloop.loop.clock import FOREVER, NS_PER_MS, RateClock, ticks_from
from fesloop.loop.guard import is_finite
from fesloop.loop.record import InputRow, PlantRow
from fesloop.loop.signals import NEVER, Sample, Value
from fesloop.loop.wire import Link

_new_tuple = tuple.__new__
"""Makes a Sample of a message without the cost of its argument handling."""


class PlantInputs:
    """A plant's input values, held between messages.

    Attributes
    ----------
    values: by port; what `Plant.advance` is given.
    queues: of the messages under way to the plant.
    """

    __slots__ = ("_feeds", "_held", "_rows", "queues", "values")

    def __init__(
        self, plant: Plant, incoming: Sequence[tuple[int, Link]], rows: list[InputRow] | None
    ) -> None:
        self.values: list[Value] = [port.initial_value() for port in plant.inputs]
        self._held = [Sample(value, NEVER, NEVER, NEVER) for value in self.values]
        self._feeds = tuple((port, link, link.queue) for port, link in incoming)
        self._rows = rows
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
        self.values[port] = sample.value
        if self._rows is not None:
            self._rows.append((acts_ns, port, sample.oldest_ns, sample.newest_ns, sample.value))

    def save(self) -> Any:
        """All that changes, for a snapshot."""
        return list(self.values), list(self._held)

    def restore(self, saved: Any) -> None:
        """Back to what `save` gave."""
        self.values[:], self._held[:] = saved


class PlantRecord:
    """What the recorder sees of a plant: its outputs at the recorder's own instants.

    `sampled` are the numbers of the output ports that someone samples.

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
        """Go on after an instant."""
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
        """Note outputs that stand still until `stop_ns`."""
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
        """Stack what was seen one by one into a row for the recorder."""
        if self._seen:
            times, captured, values = (list(column) for column in zip(*self._seen, strict=True))
            self._seen.clear()
            self._add(times, captured, tuple(np.array(column) for column in zip(*values, strict=True)))

    def _add(self, times: list[int], captured: list[int], stacks: tuple[Any, ...]) -> None:
        """One row. An output that is sampled is checked there; any other that is not finite ends the run."""
        for i, name in self._unsampled:
            if not is_finite(stacks[i]):
                finite = np.isfinite(stacks[i]).reshape(len(times), -1).all(axis=1)
                at = times[int(np.argmin(finite))]
                raise RunError(f"{self._name}.{name} is not finite at {at / NS_PER_MS:.6f} ms: "
                               "the simulation became unstable")
        self._rows.append((times, captured, stacks))
