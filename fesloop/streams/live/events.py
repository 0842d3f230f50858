"""Statuses of a loop, and marks, as a live stream of text."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from fesloop.errors import InputError
from fesloop.loop.abilities import Present
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_S
from fesloop.loop.record import EventRow
from fesloop.loop.signals import NEVER, Port, Sample, Value
from fesloop.streams.live.library import Network, open_library
from fesloop.streams.live.outlet import OutletStandIn
from fesloop.streams.live.source import monotonic_offset_ns


@dataclass(slots=True, eq=False)
class EventsState:
    """An open outlet of text.

    Attributes
    ----------
    outlet: pylsl's.
    origin_ns: t = 0 of the trial by LSL's clock, ns; NEVER before the first.
    mark: the newest value of `mark` that was sent; None before any.
    """

    outlet: Any
    origin_ns: int = NEVER
    mark: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class LslEvents:
    """Sends statuses of blocks, such as those of a safety block, as a stream of markers.

    One channel of text: `safety posture_stale: posture older than 100 ms: ramp to zero`, stamped with the
    instant of the loop at which the block reported it. The optional input `mark`, a number such as that of a
    phase, sends its name and value whenever it changes. Receivers find the stream by its type, "Markers".

    Attributes
    ----------
    stream: name of the stream.
    source_id: lets receivers find the stream again; empty: "fesloop" and the stream's name.
    blocks: names of the blocks whose statuses are sent; empty: all.
    mark_name: name of `mark` in the stream.
    network: "loopback" to be found from this machine; "lab" to be found from the local network.
    """

    stream: str
    source_id: str = ""
    blocks: tuple[str, ...] = ()
    mark_name: str = "mark"
    network: Network = "loopback"

    def __post_init__(self) -> None:
        if not self.stream:
            raise InputError("stream", "is empty", "a name")

    @property
    def inputs(self) -> tuple[Port, ...]:
        """`mark`, which may be left without a wire."""
        return (Port("mark", (), "1", optional=True),)

    @property
    def outputs(self) -> tuple[Port, ...]:
        """No outputs."""
        return ()

    def stand_in(self) -> OutletStandIn:
        """An outlet that sends nothing."""
        return OutletStandIn(inputs=self.inputs)

    def init(self, context: Context) -> EventsState:
        """Open the outlet; raises InputError where liblsl is missing."""
        pylsl = open_library(self.network)
        info = pylsl.StreamInfo(self.stream, "Markers", 1, pylsl.IRREGULAR_RATE, "string",
                                self.source_id or f"fesloop {self.stream}")
        return EventsState(pylsl.StreamOutlet(info, chunk_size=1))

    def next_trial(self, state: EventsState, context: Context) -> EventsState:
        """The same outlet, open for all trials."""
        return EventsState(state.outlet)

    def attach(self, state: EventsState, present: Present) -> None:
        """Take the instant t = 0 of the trial."""
        state.origin_ns = present.origin_ns - monotonic_offset_ns(open_library(self.network).local_clock)

    def heed(self, state: EventsState, events: Sequence[EventRow]) -> None:
        """Send the statuses that blocks have just reported."""
        for time_ns, where, status, detail in events:
            if not self.blocks or where in self.blocks:
                self._send(state, time_ns, f"{where} {status}: {detail}" if detail else f"{where} {status}")

    def step(self, state: EventsState, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """Send the mark where it has changed."""
        mark = inputs[0]
        if mark.present and mark.value != state.mark:
            value = state.mark = float(mark.value)
            self._send(state, tick.time_ns, f"{self.mark_name} {value:g}")
        return ()

    def _send(self, state: EventsState, time_ns: int, text: str) -> None:
        state.outlet.push_sample([text], (state.origin_ns + time_ns) / NS_PER_S)

    def close(self, state: EventsState) -> None:
        """End the stream."""
        state.outlet = None
