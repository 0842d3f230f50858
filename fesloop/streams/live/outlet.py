"""Signals of a loop, sent as a live stream."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from fesloop.errors import InputError
from fesloop.loop.abilities import Present
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_S, RateClock
from fesloop.loop.signals import NEVER, Port, Sample, Value
from fesloop.streams.live.library import Network, open_library
from fesloop.streams.live.source import monotonic_offset_ns

_STAMPS = {"capture": "oldest capture behind the sample", "sent": "instant of the loop at which it was sent"}


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class OutletStandIn:
    """Replaces an outlet in rehearsals and checks: takes its inputs and sends nothing.

    Attributes
    ----------
    inputs: ports of the outlet that it replaces.
    """

    inputs: tuple[Port, ...]
    outputs: tuple[Port, ...] = ()

    def init(self, context: Context) -> None:
        """No state."""

    def step(self, state: None, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """No output."""
        return ()


@dataclass(slots=True, eq=False)
class OutletState:
    """An open outlet.

    Attributes
    ----------
    outlet: pylsl's.
    offset_ns: the monotonic clock less LSL's.
    origin_ns: t = 0 of the trial by the monotonic clock; NEVER before the first.
    """

    outlet: Any
    offset_ns: int
    origin_ns: int = NEVER


@dataclass(frozen=True, slots=True, kw_only=True)
class LslOutlet:
    """Sends a signal, such as a posture or the stimulation, as a stream of Lab Streaming Layer.

    Input `values`: (k,), or (k, columns) such as current and pulse width of k channels; each tick at which
    there is one sends a sample of double floats, row by row. Its stamp is an instant of the loop by LSL's
    clock; the stream's description says which one (`synchronization`, `stamps`). No outputs.

    Attributes
    ----------
    stream, stream_type: name and type of the stream.
    source_id: lets receivers find the stream again; empty: "fesloop" and the stream's name.
    unit: of the wire; units of columns are joined by commas ("A,s").
    columns: of each row; 0 for a vector.
    rows: k; 0 takes it from the wire.
    labels: a name a row; empty: their numbers.
    column_labels: a name a column.
    stamp: "capture" (the oldest behind the sample, so that a receiver knows its age) or "sent".
    network: "loopback" to be found from this machine; "lab" to be found from the local network.
    """

    stream: str
    stream_type: str = "fesloop"
    source_id: str = ""
    unit: str = "1"
    columns: int = 0
    rows: int = 0
    labels: tuple[str, ...] = ()
    column_labels: tuple[str, ...] = ()
    stamp: Literal["capture", "sent"] = "capture"
    network: Network = "loopback"

    def __post_init__(self) -> None:
        if not self.stream:
            raise InputError("stream", "is empty", "a name")
        for key in ("columns", "rows"):
            if getattr(self, key) < 0:
                raise InputError(key, f"{getattr(self, key)}", "0 or more")
        if self.rows and len(self.labels) not in (0, self.rows):
            raise InputError("labels", f"{len(self.labels)} names", f"{self.rows}, one a row, or none")
        if len(self.column_labels) not in (0, self.columns):
            raise InputError("column_labels", f"{len(self.column_labels)} names",
                             f"{self.columns}, one a column, or none")
        for key in ("labels", "column_labels"):
            names = getattr(self, key)
            if len(set(names)) < len(names):
                raise InputError(key, f"a name is listed twice: {', '.join(names)}", "different names")

    @property
    def inputs(self) -> tuple[Port, ...]:
        """`values`."""
        rows = self.rows or None
        return (Port("values", (rows, self.columns) if self.columns else (rows,), self.unit),)

    @property
    def outputs(self) -> tuple[Port, ...]:
        """No outputs."""
        return ()

    def resolve(self, shapes: Mapping[str, tuple[int, ...]]) -> LslOutlet:
        """The outlet for the wired rows; raises InputError for another shape."""
        shape = shapes["values"]
        if len(shape) != 1 + (self.columns > 0) or shape[1:] not in ((), (self.columns,)):
            raise InputError("values", f"a signal of shape {shape} is wired in", "a vector, or columns = "
                             f"{shape[-1]}" if len(shape) == 2 else "a vector")
        return replace(self, rows=shape[0])

    def stand_in(self) -> OutletStandIn:
        """An outlet that sends nothing."""
        return OutletStandIn(inputs=self.inputs)

    def channels(self) -> tuple[tuple[str, str], ...]:
        """(label, unit) of every channel of the stream."""
        labels = self.labels or tuple(str(row) for row in range(self.rows))
        units = self.unit.split(",")
        if not self.columns:
            return tuple((label, self.unit) for label in labels)
        if len(units) != self.columns:
            units = [self.unit] * self.columns
        names = self.column_labels or tuple(str(column) for column in range(self.columns))
        return tuple((f"{label} {name}", unit) for label in labels
                     for name, unit in zip(names, units, strict=True))

    def init(self, context: Context) -> OutletState:
        """Open the outlet; raises InputError where liblsl is missing."""
        pylsl = open_library(self.network)
        rate = float(context.clock.rate) if isinstance(context.clock, RateClock) else pylsl.IRREGULAR_RATE
        channels = self.channels()
        info = pylsl.StreamInfo(self.stream, self.stream_type, len(channels), rate, "double64",
                                self.source_id or f"fesloop {self.stream}")
        described = info.desc().append_child("channels")
        for label, unit in channels:
            channel = described.append_child("channel")
            channel.append_child_value("label", label)
            channel.append_child_value("unit", unit)
        info.desc().append_child("synchronization").append_child_value("stamps", _STAMPS[self.stamp])
        return OutletState(pylsl.StreamOutlet(info, chunk_size=1), monotonic_offset_ns(pylsl.local_clock))

    def next_trial(self, state: OutletState, context: Context) -> OutletState:
        """The same outlet, open for all trials."""
        return OutletState(state.outlet, state.offset_ns)

    def attach(self, state: OutletState, present: Present) -> None:
        """Take the instant t = 0 of the trial."""
        state.origin_ns = present.origin_ns
        state.offset_ns = monotonic_offset_ns(open_library(self.network).local_clock)

    def step(self, state: OutletState, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """Send a sample."""
        values = inputs[0]
        if values.present:
            instant = values.oldest_ns if self.stamp == "capture" else tick.time_ns
            stamp_ns = state.origin_ns + instant - state.offset_ns
            state.outlet.push_sample(np.ravel(values.value).tolist(), stamp_ns / NS_PER_S)
        return ()

    def close(self, state: OutletState) -> None:
        """End the stream."""
        state.outlet = None
