"""A stand-in for sensors: rows of numbers as a live stream, at the pace of the wall clock."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fesloop.errors import InputError
from fesloop.loop.clock import NS_PER_S
from fesloop.streams.live.library import Network, open_library
from fesloop.streams.live.played import Played
from fesloop.streams.live.sender_faults import FaultySender, SenderFault

_NAP_S = 0.1


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class StreamSender:
    """Plays rows of numbers as an LSL stream. A sample is stamped as it is sent.

    Attributes
    ----------
    played: what is sent (see `fesloop.streams.live.played`).
    stream: name of the stream.
    source_id: by which receivers find it again; empty: "fesloop" and the name.
    repeat: whether it begins anew after its end.
    faults: what goes wrong, and when.
    network: "loopback" to be heard on this machine; "lab" opens sockets on every address.
    """

    played: Played
    stream: str = "imus"
    source_id: str = ""
    repeat: bool = False
    faults: Sequence[SenderFault] = ()
    network: Network = "loopback"

    def __post_init__(self) -> None:
        if not self.stream:
            raise InputError("stream", "is empty", "a name")

    def _open(self) -> Any:
        pylsl, played = open_library(self.network), self.played
        info = pylsl.StreamInfo(self.stream, played.stream_type, len(played.channels), played.rate_hz,
                                "float32", self.source_id or f"fesloop {self.stream}")
        described = info.desc().append_child("channels")
        for channel in played.channels:
            entry = described.append_child("channel")
            for key, text in channel._asdict().items():
                entry.append_child_value(key, text)
        return pylsl.StreamOutlet(info, chunk_size=1)

    def send(self, seconds: float | None = None, going_on: Callable[[], bool] = lambda: True,
             begins: Callable[[int], None] = lambda time_ns: None) -> int:
        """Send until the rows end, `seconds` have passed, or `going_on` says no; number of samples sent.

        `begins` is told the instant that faults count from, ns by the monotonic clock.
        """
        local_clock = open_library(self.network).local_clock
        rows, rate_hz = self.played.rows, self.played.rate_hz
        sender, outlet = FaultySender(self.faults, rate_hz), self._open()
        nothing, sent, row = np.full(rows.shape[1], np.nan).tolist(), 0, 0
        start = due = time.monotonic()
        begins(round(start * NS_PER_S))
        last_s = math.inf if seconds is None else seconds - 0.5 / rate_hz  # sums of periods are not exact
        while going_on() and (self.repeat or row < len(rows)) and due - start < last_s:
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
            due += 1.0 / (rate_hz * sender.pace(time_s))
        return sent
