"""A recording as a live stream: a stand-in for sensors, in a process of its own."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.loop.clock import NS_PER_S, parse_rate
from fesloop.streams.live.library import Network, open_library
from fesloop.streams.live.sender_faults import FaultySender, SenderFault
from fesloop.streams.recording import MotionRecording

_UNITS = {"gyr": "rad/s", "acc": "m/s^2", "mag": "T"}
_NAP_S = 0.1


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class StreamSender:
    """Plays a recording of inertial sensors as an LSL stream, at the pace of the wall clock.

    Each sensor has channels such as `F2p_gyr_x`, in SI, described in the stream. A sample is stamped as it
    is sent. NaN is what the recording lost.

    Attributes
    ----------
    recording: what is played.
    stream: name of the stream; its type is "IMU".
    source_id: by which receivers find it again; empty: "fesloop" and the name.
    rate: Hz; None: as recorded.
    repeat: whether it begins anew after its end.
    faults: what goes wrong, and when.
    network: "loopback" to be heard on this machine; "lab" opens sockets on every address.
    """

    recording: MotionRecording
    stream: str = "imus"
    source_id: str = ""
    rate: str | None = None
    repeat: bool = False
    faults: Sequence[SenderFault] = ()
    network: Network = "loopback"
    rate_hz: float = field(init=False)

    def __post_init__(self) -> None:
        if not self.stream:
            raise InputError("stream", "is empty", "a name")
        rate = self.recording.rate if self.rate is None else parse_rate(self.rate)
        if rate is None:
            raise InputError("rate", f"{self.recording.path} is not evenly sampled", "a rate in Hz")
        object.__setattr__(self, "rate_hz", float(rate))

    def rows(self) -> NDArray[np.float32]:
        """(samples, channels): gyr, acc and mag of the first sensor, then of the next."""
        source = self.recording
        kinds = [source.gyr, source.acc] + ([source.mag] if source.mag is not None else [])
        return np.stack(kinds, axis=2).reshape(source.samples, -1).astype(np.float32)

    def _open(self) -> Any:
        pylsl = open_library(self.network)
        kinds = ("gyr", "acc", "mag")[:3 if self.recording.mag is not None else 2]
        count = len(self.recording.sensors) * len(kinds) * 3
        info = pylsl.StreamInfo(self.stream, "IMU", count, self.rate_hz, "float32",
                                self.source_id or f"fesloop {self.stream}")
        channels = info.desc().append_child("channels")
        for sensor in self.recording.sensors:
            for kind in kinds:
                for axis in "xyz":
                    channel = channels.append_child("channel")
                    channel.append_child_value("label", f"{sensor}_{kind}_{axis}")
                    channel.append_child_value("unit", _UNITS[kind])
                    channel.append_child_value("type", kind.upper())
        return pylsl.StreamOutlet(info, chunk_size=1)

    def send(self, seconds: float | None = None, going_on: Callable[[], bool] = lambda: True,
             begins: Callable[[int], None] = lambda time_ns: None) -> int:
        """Send until the recording ends, `seconds` have passed, or `going_on` says no; number of samples.

        `begins` is told the instant that faults count from, ns by the monotonic clock.
        """
        local_clock, rows = open_library(self.network).local_clock, self.rows()
        sender, outlet = FaultySender(self.faults, self.rate_hz), self._open()
        nothing, sent, row = np.full(rows.shape[1], np.nan).tolist(), 0, 0
        start = due = time.monotonic()
        begins(round(start * NS_PER_S))
        while going_on() and (self.repeat or row < len(rows)) and (seconds is None or due - start < seconds):
            while (ahead := due - time.monotonic()) > 0.0 and going_on():
                time.sleep(min(ahead, _NAP_S))
            time_s = due - start
            gone = sender.active("vanish", time_s) is not None
            if gone == (outlet is not None):
                outlet = None if gone else self._open()
            for sending in sender.sendings(row, time_s, local_clock()):
                values = nothing if sending.lost else rows[sending.row % len(rows)].tolist()
                outlet.push_sample(values, sending.stamp_s)
                sent += 1
            row += 1
            due += 1.0 / (self.rate_hz * sender.pace(time_s))
        return sent
