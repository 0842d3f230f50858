"""A live stream found on the network and opened: where its samples come from."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError, did_you_mean
from fesloop.loop.clock import NS_PER_S
from fesloop.streams.live.description import channels_of
from fesloop.streams.live.library import Network, open_library

_BUFFER_S = 5
_CLOCK_EVERY_NS = 2 * NS_PER_S
"""How often the offset between the clocks is asked for again: LSL itself measures it anew every 2 s."""
_CLOCK_WAIT_S = 5.0
_SEARCH_S, _GLANCE_S = 1.0, 0.5
"""How long to look for one stream, and for all that there are, at a time (chosen: what is there answers in
half a second, and who waits hears soon what for)."""
_BRACKETS = 5
_LONGEST_S = 4e9
"""Beyond, ns do not fit into 64 bits; seconds since 1970 do."""


class StreamLost(Exception):
    """The sender is gone; the text says what is there in its place, if anything."""


class Pulled(NamedTuple):
    """A sample of every channel, and its stamp by this machine's monotonic clock, ns."""

    values: NDArray[np.float64]
    stamp_ns: int


class Source(Protocol):
    """Where a reader gets samples."""

    def pull(self, wait_s: float) -> Pulled | None:
        """The next sample, None if none comes in time. Raises StreamLost."""

    def reopen(self) -> None:
        """Look for the lost stream for a moment and open it. Raises StreamLost where that fails."""

    def close(self) -> None:
        """Let go."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Wanted:
    """Which stream: what is not empty must be as the stream has it.

    Attributes
    ----------
    name, type, source_id: of the stream.
    timeout_s: how long to look for it.
    network: this machine ("loopback") or as liblsl is set up ("lab").
    """

    name: str = ""
    type: str = ""
    source_id: str = ""
    timeout_s: float = 5.0
    network: Network = "loopback"

    def __post_init__(self) -> None:
        asked = self._asked()
        if not asked:
            raise InputError("name", "no stream is named", "one or more of name, type, source_id")
        for key, value in asked.items():
            if "'" in value:
                raise InputError(key, f"{value!r}", "text without '")
        if not 0.0 < self.timeout_s <= 600.0:
            raise InputError("timeout_s", f"{self.timeout_s}", "above 0, up to 600")

    def _asked(self) -> dict[str, str]:
        texts = {"name": self.name, "type": self.type, "source_id": self.source_id}
        return {key: value for key, value in texts.items() if value}

    def __str__(self) -> str:
        return "stream " + ", ".join(f"{key} {value!r}" for key, value in self._asked().items())

    def search(self, pylsl: Any, timeout_s: float) -> list[Any]:
        """Streams that fit and answer within some seconds; at least 0.5 s even where one answers at once."""
        predicate = " and ".join(f"{key}='{value}'" for key, value in self._asked().items())
        found: list[Any] = pylsl.resolve_bypred(predicate, 1, timeout_s)
        return found


def describe(info: Any) -> str:
    """A stream in a few words, for messages."""
    return (f"{info.name()!r} (type {info.type()!r}, source_id {info.source_id()!r}, "
            f"{info.channel_count()} channels, {info.nominal_srate():g} Hz)")


def _say(text: str) -> None:
    """To whoever sits in front of a run that waits."""
    print(f"fesloop: {text}", file=sys.stderr, flush=True)


def find(wanted: Wanted, say: Callable[[str], None] = _say) -> Any:
    """The description of the one stream that is wanted.

    While it does not answer, `say` is given a line with what is waited for and which streams there are, at
    first after a second and a half, and again when there are others.

    Raises InputError where none answers in time, naming those that are there, or where more than one fits.
    """
    pylsl = open_library(wanted.network)
    left_s, there, said = wanted.timeout_s, [], None
    while left_s > 0.0:
        found = wanted.search(pylsl, min(wanted.timeout_s, _SEARCH_S))
        if len(found) == 1:
            return found[0]
        if found:
            raise InputError(str(wanted), f"{len(found)} streams fit: {', '.join(map(describe, found))}",
                             "one", "name its source_id")
        there = pylsl.resolve_streams(_GLANCE_S)
        left_s -= _SEARCH_S + _GLANCE_S
        names = {describe(info) for info in there}
        if left_s > 0.0 and names != said:
            said = names
            say(str(_absent(wanted, there, f"does not answer yet; waiting for it {left_s:.0f} s more")))
    raise _absent(wanted, there, f"does not answer within {wanted.timeout_s:g} s")


def _absent(wanted: Wanted, there: Sequence[Any], found: str) -> InputError:
    """That a stream does not answer, which do, and what to do about it."""
    if there:
        remedy = did_you_mean(wanted.name, [info.name() for info in there]) if wanted.name else ""
        return InputError(str(wanted), found, ", ".join(map(describe, there)), remedy)
    remedy = ('start its sender on this machine, or say network = "lab" for streams of other computers'
              if wanted.network == "loopback" else "start its sender")
    return InputError(str(wanted), f"{found}, nor does any other", remedy=remedy)


class LslSource:
    """An open stream of numbers.

    Parameters
    ----------
    wanted: which, as it is looked for again after a loss.
    info: as found.

    Attributes
    ----------
    info: the stream's description, complete.

    Raises InputError where the stream holds text or does not open.
    """

    def __init__(self, wanted: Wanted, info: Any) -> None:
        self._pylsl = open_library(wanted.network)
        self._wanted = wanted
        self._inlet: Any = None
        if info.channel_format() == self._pylsl.cf_string:
            raise InputError(str(wanted), "holds text", "numbers")
        try:
            self._open(info)
        except StreamLost:
            raise InputError(str(wanted), f"{describe(info)} is there and does not open",
                             remedy="start its sender again") from None
        self._channels = self.info.channel_count(), channels_of(self.info)

    def _open(self, info: Any) -> None:
        """Subscribe, and find how its clock stands to ours; samples that come meanwhile are left out."""
        pylsl = self._pylsl
        inlet = pylsl.StreamInlet(info, max_buflen=_BUFFER_S, max_chunklen=1, recover=False, as_numpy=True)
        try:
            inlet.open_stream(timeout=_CLOCK_WAIT_S)
            self._correction_s = inlet.time_correction(timeout=_CLOCK_WAIT_S)
            self.info = inlet.info(timeout=_CLOCK_WAIT_S)
            inlet.flush()
        except RuntimeError:  # of which all errors of pylsl are
            raise StreamLost(describe(info)) from None
        self._inlet = inlet
        self._set_clock()

    def _set_clock(self) -> None:
        self._offset_ns = monotonic_offset_ns(self._pylsl.local_clock)
        self._clock_set_ns = time.monotonic_ns()

    def pull(self, wait_s: float) -> Pulled | None:
        """The next sample; see Source."""
        if self._inlet is None:
            raise StreamLost
        try:
            values, stamp = self._inlet.pull_sample(timeout=wait_s)
            if time.monotonic_ns() - self._clock_set_ns > _CLOCK_EVERY_NS:
                self._correction_s = self._inlet.time_correction(timeout=0.0)
                self._set_clock()
        except RuntimeError:
            self._inlet = None
            raise StreamLost from None
        if stamp is None:
            return None
        return Pulled(np.asarray(values, dtype=np.float64), self._ours_ns(stamp))

    def _ours_ns(self, stamp_s: float) -> int:
        """A sender's stamp by our monotonic clock; what is no time at all lies before everything."""
        seconds = stamp_s + self._correction_s
        return round(seconds * NS_PER_S) + self._offset_ns if abs(seconds) < _LONGEST_S else -1

    def reopen(self) -> None:
        """Look for the stream again; see Source."""
        try:
            found = self._wanted.search(self._pylsl, _SEARCH_S)
        except RuntimeError as fault:
            raise StreamLost(f"nothing, for the search failed: {fault}") from None
        if len(found) != 1:
            raise StreamLost(", ".join(map(describe, found)))
        self._open(found[0])
        if (self.info.channel_count(), channels_of(self.info)) != self._channels:
            self._inlet = None
            raise StreamLost(f"{describe(found[0])}, whose channels are not those of before")

    def close(self) -> None:
        """Unsubscribe."""
        self._inlet = None


def monotonic_offset_ns(local_clock: Any) -> int:
    """What to add to LSL's clock for Python's monotonic one, ns; on Linux they are the same clock."""
    best: tuple[int, int] | None = None
    for _ in range(_BRACKETS):
        before = time.monotonic_ns()
        theirs = round(local_clock() * NS_PER_S)
        after = time.monotonic_ns()
        if best is None or after - before < best[0]:
            best = after - before, (before + after) // 2 - theirs
    assert best is not None
    return best[1]
