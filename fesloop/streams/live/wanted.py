"""Which live stream is wanted, and looking for it on the network."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from fesloop.errors import InputError, did_you_mean
from fesloop.streams.live.library import Network, open_library

_KEYS = {"name": "stream", "type": "stream_type", "source_id": "source_id"}
"""What LSL asks of a stream, and how whoever wants one says it: in experiments, and as `--stream`."""
_SEARCH_S, _GLANCE_S = 1.0, 0.5
"""How long to look for one stream, and for all that there are, at a time (chosen: what is there answers in
half a second, and who waits hears soon what for)."""


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
            raise InputError("stream", "no stream is named", f"one or more of {', '.join(_KEYS.values())}")
        for key, value in asked.items():
            if "'" in value:
                raise InputError(_KEYS[key], f"{value!r}", "text without '")
        if not 0.0 < self.timeout_s <= 600.0:
            raise InputError("timeout_s", f"{self.timeout_s}", "above 0, up to 600")

    def _asked(self) -> dict[str, str]:
        return {key: value for key in _KEYS if (value := getattr(self, key))}

    def __str__(self) -> str:
        return "stream " + ", ".join(f"{key} {value!r}" for key, value in self._asked().items())

    def search(self, pylsl: Any, timeout_s: float) -> list[Any]:
        """Streams that fit and answer within some seconds; at least 0.5 s even where one answers at once."""
        predicate = " and ".join(f"{key}='{value}'" for key, value in self._asked().items())
        found: list[Any] = pylsl.resolve_bypred(predicate, 1, timeout_s)
        return found

    def among(self, infos: Sequence[Any]) -> list[Any]:
        """Those of the streams that fit."""
        return [info for info in infos
                if all(getattr(info, key)() == value for key, value in self._asked().items())]


def describe(info: Any) -> str:
    """A stream in a few words, for messages."""
    return (f"{info.name()!r} (type {info.type()!r}, source_id {info.source_id()!r}, "
            f"{info.channel_count()} channels, {info.nominal_srate():g} Hz)")


def _say(text: str) -> None:
    """To whoever sits in front of a run that waits."""
    print(f"fesloop: {text}", file=sys.stderr, flush=True)


def glance(wanted: Wanted, say: Callable[[str], None] = _say) -> None:
    """Give `say` a line where the stream does not answer yet: what is wanted, and which streams there are.

    Raises InputError where liblsl is missing.
    """
    pylsl = open_library(wanted.network)
    if not wanted.search(pylsl, min(wanted.timeout_s, _SEARCH_S)):
        there = pylsl.resolve_streams(_GLANCE_S)
        if wanted.among(there):
            return
        say(str(_absent(wanted, there, f"does not answer yet; it is waited for up to {wanted.timeout_s:g} s "
                        "when the loop is ready")))


def find(wanted: Wanted, say: Callable[[str], None] = _say) -> Any:
    """The description of the one stream that is wanted.

    While it does not answer, `say` is given a line with what is waited for and which streams there are, at
    first after a second and a half, and again when there are others.

    Raises InputError where none answers in time, naming those that are there, or where more than one fits.
    """
    pylsl, left_s = open_library(wanted.network), wanted.timeout_s
    there: list[Any] = []
    said: set[str] | None = None
    while left_s > 0.0:
        found = wanted.search(pylsl, min(wanted.timeout_s, _SEARCH_S))
        if not found:
            there = pylsl.resolve_streams(_GLANCE_S)
            found = wanted.among(there)
        if len(found) == 1:
            return found[0]
        if found:
            raise InputError(str(wanted), f"{len(found)} streams fit: {', '.join(map(describe, found))}",
                             "one", "name its source_id")
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
