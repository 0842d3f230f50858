"""Queries for live streams, and the search for the stream that a query means."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from fesloop.errors import InputError, did_you_mean
from fesloop.streams.live.library import Network, open_library

_KEYS = {"name": "stream", "type": "stream_type", "source_id": "source_id"}
"""Properties of a stream in LSL, and the parameters of blocks that state them."""
_SEARCH_S, _LIST_S = 1.0, 0.5
"""Duration of one search for a stream, and for all streams (chosen: a stream that is there answers in half a
second, and a user soon reads what the run waits for)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StreamQuery:
    """Properties of a stream; those that are not empty must be the stream's.

    Attributes
    ----------
    name, type, source_id: of the stream.
    timeout_s: duration of the search.
    network: this machine ("loopback") or as liblsl is configured ("lab").
    """

    name: str = ""
    type: str = ""
    source_id: str = ""
    timeout_s: float = 5.0
    network: Network = "loopback"

    def __post_init__(self) -> None:
        stated = self._stated()
        if not stated:
            raise InputError("stream", "no stream is named", f"one or more of {', '.join(_KEYS.values())}")
        for key, value in stated.items():
            if "'" in value:
                raise InputError(_KEYS[key], f"{value!r}", "text without '")
        if not 0.0 < self.timeout_s <= 600.0:
            raise InputError("timeout_s", f"{self.timeout_s}", "above 0, up to 600")

    def _stated(self) -> dict[str, str]:
        return {key: value for key in _KEYS if (value := getattr(self, key))}

    def __str__(self) -> str:
        return "stream " + ", ".join(f"{key} {value!r}" for key, value in self._stated().items())

    def search(self, pylsl: Any, timeout_s: float) -> list[Any]:
        """Streams that fit and answer within some seconds; takes 0.5 s at least."""
        predicate = " and ".join(f"{key}='{value}'" for key, value in self._stated().items())
        found: list[Any] = pylsl.resolve_bypred(predicate, 1, timeout_s)
        return found

    def among(self, infos: Sequence[Any]) -> list[Any]:
        """The streams of a list that fit."""
        return [info for info in infos
                if all(getattr(info, key)() == value for key, value in self._stated().items())]


def describe(info: Any) -> str:
    """Short description of a stream, for messages."""
    return (f"{info.name()!r} (type {info.type()!r}, source_id {info.source_id()!r}, "
            f"{info.channel_count()} channels, {info.nominal_srate():g} Hz)")


def _print(text: str) -> None:
    """Print a line for a user whose run waits."""
    print(f"fesloop: {text}", file=sys.stderr, flush=True)


def announce_absence(query: StreamQuery, say: Callable[[str], None] = _print) -> None:
    """Give `say` a line where the stream does not answer yet: the query, and the streams that answer.

    Raises InputError where liblsl is missing.
    """
    pylsl = open_library(query.network)
    if not query.search(pylsl, min(query.timeout_s, _SEARCH_S)):
        there = pylsl.resolve_streams(_LIST_S)
        if query.among(there):
            return
        say(str(_absent(query, there, "does not answer yet; the run waits up to "
                        f"{query.timeout_s:g} s for it when the loop is ready")))


def find(query: StreamQuery, say: Callable[[str], None] = _print) -> Any:
    """The description of the one stream that fits a query.

    While none answers, `say` is given a line with the query and the streams that answer, at first after a
    second and a half, and again when there are others.

    Raises InputError where none answers in time, naming those that do, or where more than one fits.
    """
    pylsl, left_s = open_library(query.network), query.timeout_s
    there: list[Any] = []
    said: set[str] | None = None
    while left_s > 0.0:
        found = query.search(pylsl, min(query.timeout_s, _SEARCH_S))
        if not found:
            there = pylsl.resolve_streams(_LIST_S)
            found = query.among(there)
        if len(found) == 1:
            return found[0]
        if found:
            raise InputError(str(query), f"{len(found)} streams fit: {', '.join(map(describe, found))}",
                             "one", "name its source_id")
        left_s -= _SEARCH_S + _LIST_S
        names = {describe(info) for info in there}
        if left_s > 0.0 and names != said:
            said = names
            say(str(_absent(query, there, f"does not answer yet; waiting for it {left_s:.0f} s more")))
    raise _absent(query, there, f"does not answer within {query.timeout_s:g} s")


def _absent(query: StreamQuery, there: Sequence[Any], found: str) -> InputError:
    """The fault of a stream that does not answer, with the streams that do and a remedy."""
    if there:
        remedy = did_you_mean(query.name, [info.name() for info in there]) if query.name else ""
        return InputError(str(query), found, ", ".join(map(describe, there)), remedy)
    remedy = ('start its sender on this machine, or say network = "lab" for streams of other computers'
              if query.network == "loopback" else "start its sender")
    return InputError(str(query), f"{found}, nor does any other", remedy=remedy)
