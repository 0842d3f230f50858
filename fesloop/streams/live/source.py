"""Open live streams: sources of samples stamped by this machine's clock."""

from __future__ import annotations

import time
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.loop.clock import NS_PER_S
from fesloop.streams.live.description import channels_of
from fesloop.streams.live.library import open_library
from fesloop.streams.live.query import StreamQuery, describe

_BUFFER_S = 5
_CLOCK_EVERY_NS = 2 * NS_PER_S
"""Period at which the offset between the clocks is read again: LSL measures it every 2 s."""
_CLOCK_WAIT_S = 5.0
_SEARCH_S = 1.0
_BRACKETS = 5
_LONGEST_S = 4e9
"""Greatest time whose ns fit into 64 bits; seconds since 1970 do."""


class StreamLost(Exception):
    """The sender is gone; the text names the streams in its place, if any."""


class Pulled(NamedTuple):
    """A sample of every channel, and its stamp by this machine's monotonic clock, ns."""

    values: NDArray[np.float64]
    stamp_ns: int


class Source(Protocol):
    """A source of a reader's samples."""

    def pull(self, wait_s: float) -> Pulled | None:
        """The next sample, None if none comes in time. Raises StreamLost."""

    def reopen(self) -> None:
        """Search for the lost stream for a moment and open it. Raises StreamLost where that fails."""

    def close(self) -> None:
        """Close the stream."""


class LslSource:
    """An open stream of numbers.

    Parameters
    ----------
    query: finds the stream again after a loss.
    info: as found.

    Attributes
    ----------
    info: the stream's description, complete.

    Raises InputError where the stream holds text or does not open.
    """

    def __init__(self, query: StreamQuery, info: Any) -> None:
        self._pylsl = open_library(query.network)
        self._query = query
        self._inlet: Any = None
        if info.channel_format() == self._pylsl.cf_string:
            raise InputError(str(query), "holds text", "numbers")
        try:
            self._open(info)
        except StreamLost:
            raise InputError(str(query), f"{describe(info)} answers and does not open",
                             remedy="start its sender again") from None
        self._channels = self.info.channel_count(), channels_of(self.info)

    def _open(self, info: Any) -> None:
        """Subscribe, and measure the offset of its clock; samples that come meanwhile are left out."""
        pylsl = self._pylsl
        inlet = pylsl.StreamInlet(info, max_buflen=_BUFFER_S, max_chunklen=1, recover=False, as_numpy=True)
        try:
            inlet.open_stream(timeout=_CLOCK_WAIT_S)
            self._correction_s = inlet.time_correction(timeout=_CLOCK_WAIT_S)
            self.info = inlet.info(timeout=_CLOCK_WAIT_S)
            inlet.flush()
        except RuntimeError:  # base class of all errors of pylsl
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
        return Pulled(np.asarray(values, dtype=np.float64), self._monotonic_ns(stamp))

    def _monotonic_ns(self, stamp_s: float) -> int:
        """A sender's stamp by this machine's monotonic clock, ns; -1 for a number that is no time."""
        seconds = stamp_s + self._correction_s
        return round(seconds * NS_PER_S) + self._offset_ns if abs(seconds) < _LONGEST_S else -1

    def reopen(self) -> None:
        """Search for the stream again; see Source."""
        try:
            found = self._query.search(self._pylsl, _SEARCH_S)
        except RuntimeError as fault:
            raise StreamLost(f"nothing, for the search failed: {fault}") from None
        if len(found) != 1:
            raise StreamLost(", ".join(map(describe, found)))
        try:
            self._open(found[0])
        except StreamLost:  # it answered the search while ending, or is just starting
            raise StreamLost from None
        if (self.info.channel_count(), channels_of(self.info)) != self._channels:
            self._inlet = None
            raise StreamLost(f"{describe(found[0])}, whose channels are not those of before")

    def close(self) -> None:
        """Unsubscribe."""
        self._inlet = None


def monotonic_offset_ns(local_clock: Any) -> int:
    """Python's monotonic clock less LSL's, ns; on Linux they are the same clock."""
    best: tuple[int, int] | None = None
    for _ in range(_BRACKETS):
        before = time.monotonic_ns()
        theirs = round(local_clock() * NS_PER_S)
        after = time.monotonic_ns()
        if best is None or after - before < best[0]:
            best = after - before, (before + after) // 2 - theirs
    assert best is not None
    return best[1]
