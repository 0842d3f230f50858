"""A sender in place of sensors: rows of numbers as a live stream, at the pace of the wall clock."""

from __future__ import annotations

import math
import re
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.loop.clock import NS_PER_S, parse_rate
from fesloop.streams.live.description import Channel
from fesloop.streams.live.library import Network, open_library
from fesloop.streams.pace import timeline
from fesloop.streams.recording import MotionRecording

_SI_UNITS = {"gyr": "rad/s", "acc": "m/s^2", "mag": "T"}


class Played(NamedTuple):
    """A stream's type, its channels, its rows (samples, channels), and their rate in Hz."""

    stream_type: str
    channels: tuple[Channel, ...]
    rows: NDArray[np.float32]
    rate_hz: float


def inertial(recording: MotionRecording, rate: str | None = None) -> Played:
    """A recording of inertial sensors: gyr, acc and mag of the first sensor, then of the next.

    Channels are called such as `F2p_gyr_x`, in SI. NaN is a lost sample, or one that a gap lacks.

    Parameters
    ----------
    recording: to play.
    rate: Hz; None: as recorded, between gaps. Raises InputError where there is none, as of uneven samples.
    """
    known = recording.rate if rate is None else parse_rate(rate)
    line = timeline(recording.stamps_ns, str(recording.path))
    if known is None and line.gaps:
        known = Fraction(line.rate_hz)
    if known is None:
        raise InputError("rate", f"{recording.path} is not evenly sampled", "a rate in Hz")
    kinds = {"gyr": recording.gyr, "acc": recording.acc}
    if recording.mag is not None:
        kinds["mag"] = recording.mag
    rows = np.stack(list(kinds.values()), axis=2).reshape(recording.samples, -1).astype(np.float32)
    rows = np.where((line.rows >= 0)[:, np.newaxis], rows[line.rows], np.float32(np.nan))
    channels = tuple(Channel(f"{sensor}_{kind}_{axis}", _SI_UNITS[kind], kind.upper())
                     for sensor in recording.sensors for kind in kinds for axis in "xyz")
    return Played("IMU", channels, rows, float(known))


def posture(angles: NDArray[np.float64], joints: Sequence[str], rate_hz: float) -> Played:
    """Joint angles (samples, joints), rad."""
    channels = tuple(Channel(joint, "rad", "Angle") for joint in joints)
    return Played("Posture", channels, angles.astype(np.float32), rate_hz)


FAULTS = {
    "stop": "nothing is sent, the stream stays open",
    "vanish": "the stream is closed, and opened again afterwards",
    "freeze": "the same numbers over and over, with new stamps",
    "repeat": "the same sample over and over, with its old stamp",
    "jump": "the recording jumps ahead by VALUE s (1), the stamps do not",
    "clock": "the stamps jump by VALUE s (-1)",
    "reorder": "each two samples change places",
    "nan": "every number is NaN",
    "rate": "samples come at VALUE times the rate (0.5)",
}
_VALUES = {"jump": 1.0, "clock": -1.0, "rate": 0.5}
_FORM = re.compile(r"(?P<kind>[a-z]+)@(?P<start>[0-9.]+)(?:\+(?P<length>[0-9.]+))?(?:x(?P<value>-?[0-9.]+))?")
FORM = "KIND@START[+LENGTH][xVALUE], in s, such as freeze@5+0.5; KIND is one of " + ", ".join(FAULTS)


@dataclass(frozen=True, slots=True)
class SenderFault:
    """A fault for a stretch of time.

    Attributes
    ----------
    kind: one of FAULTS.
    start_s, length_s: first instant and duration.
    value: as FAULTS describes it; 0 where it has none.
    """

    kind: str
    start_s: float
    length_s: float = 1.0
    value: float = 0.0

    @classmethod
    def parse(cls, text: str) -> SenderFault:
        """The fault of a text such as "rate@5+2x0.5"; raises InputError for another."""
        match = _FORM.fullmatch(text)
        if match is None or match["kind"] not in FAULTS:
            raise InputError("--fault", f"{text!r}", FORM)
        try:
            start, length = float(match["start"]), float(match["length"] or 1.0)
            value = float(match["value"] or _VALUES.get(match["kind"], 0.0))
        except ValueError:
            raise InputError("--fault", f"{text!r}", FORM) from None
        if match["value"] and match["kind"] not in _VALUES:
            raise InputError("--fault", f"{text!r}: {match['kind']} takes no VALUE",
                             f"{', '.join(_VALUES)} do")
        if match["kind"] == "rate" and value <= 0.0:
            raise InputError("--fault", f"{text!r}", "a rate above 0 times the usual one")
        return cls(match["kind"], start, length, value)

    def holds(self, time_s: float) -> bool:
        """Return whether the fault is on, `time_s` after the first sample."""
        return self.start_s <= time_s < self.start_s + self.length_s


class Sending(NamedTuple):
    """A sample to be sent: row of the recording, stamp in s, whether its numbers are NaN."""

    row: int
    stamp_s: float
    lost: bool = False


class FaultySender:
    """Replaces each sample by what a faulty sender sends.

    Parameters
    ----------
    faults: with their times.
    rate_hz: of the samples.
    """

    def __init__(self, faults: Sequence[SenderFault], rate_hz: float) -> None:
        self._faults, self._rate_hz = tuple(faults), rate_hz
        self._before: Sending | None = None
        self._kept: Sending | None = None

    def active(self, kind: str, time_s: float) -> SenderFault | None:
        """The fault of this kind that is on, None if none is."""
        return next((fault for fault in self._faults if fault.kind == kind and fault.holds(time_s)), None)

    def pace(self, time_s: float) -> float:
        """Rate of the samples, relative to the usual one."""
        fault = self.active("rate", time_s)
        return fault.value if fault else 1.0

    def sendings(self, row: int, time_s: float, stamp_s: float) -> list[Sending]:
        """Samples to send in place of the sample `row`, `time_s` after the first, stamped `stamp_s`."""
        if self.active("stop", time_s) or self.active("vanish", time_s):
            return []
        if self._before is not None and self.active("repeat", time_s):
            return [self._before]
        if self._before is not None and self.active("freeze", time_s):
            row = self._before.row
        if fault := self.active("jump", time_s):
            row += round(fault.value * self._rate_hz)
        if fault := self.active("clock", time_s):
            stamp_s += fault.value
        sending = Sending(row, stamp_s, self.active("nan", time_s) is not None)
        if self.active("reorder", time_s):
            if self._kept is None:
                self._kept = sending
                return []
            sendings, self._kept = [sending, self._kept], None
        else:
            sendings = [sending] if self._kept is None else [self._kept, sending]
            self._kept = None
        self._before = sendings[-1]
        return sendings


_NAP_S = 0.1


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class StreamSender:
    """Plays rows of numbers as an LSL stream. A sample is stamped as it is sent.

    Attributes
    ----------
    played: rows to send.
    stream: name of the stream.
    source_id: lets receivers find the stream again; empty: "fesloop" and the name.
    repeat: whether the rows repeat after their end.
    faults: with their times.
    network: "loopback" to be found from this machine; "lab" to be found from the local network.
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
        """Send until the rows end, `seconds` have passed, or `going_on` is false; returns the samples sent.

        `begins` is called with the instant that faults count from, ns by the monotonic clock.
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
