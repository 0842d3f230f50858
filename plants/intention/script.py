"""Attempts of a person: which muscles, when, how strongly, and when their effort really begins."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError, did_you_mean
from fesloop.loop.clock import NS_PER_S, duration_ns

Array = NDArray[np.float64]
ACTIONS: Mapping[str, tuple[str, ...]] = {
    "open_hand": ("EDC2", "EDC3", "EDC4", "EDC5", "EDM", "EIP", "EPL"),
    "close_hand": ("FDS2", "FDS3", "FDS4", "FDS5", "FDP2", "FDP3", "FDP4", "FDP5", "FPL"),
    "extend_wrist": ("ECRL", "ECRB", "ECU"),
    "flex_wrist": ("FCR", "PL", "FCU")}
"""Muscles that a person contracts in an attempt at an action."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Attempt:
    """An attempt to contract some muscles.

    Attributes
    ----------
    at_s: instant at which the person is asked, or decides, to try.
    duration_s: from the onset of effort to the begin of its fall.
    strength: effort, as a fraction of the greatest that the person can make with each muscle.
    action: one of `ACTIONS`. muscles: names of muscles in place of an action.
    """

    at_s: float
    duration_s: float = 1.0
    strength: float = 1.0
    action: str = ""
    muscles: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        duration_ns(self.at_s, NS_PER_S, "at_s")
        if duration_ns(self.duration_s, NS_PER_S, "duration_s") == 0:
            raise InputError("duration_s", f"{self.duration_s:g}", "above 0")
        if not 0.0 < self.strength <= 1.0:
            raise InputError("strength", f"{self.strength:g}", "above 0, at most 1")
        if bool(self.action) == bool(self.muscles):
            raise InputError("action", f"{self.action!r} with muscles {list(self.muscles)}",
                             "either an action or muscles", f"actions: {', '.join(ACTIONS)}")
        if self.action and self.action not in ACTIONS:
            raise InputError("action", f"{self.action!r}", ", ".join(ACTIONS),
                             did_you_mean(self.action, ACTIONS))

    @property
    def contracted(self) -> tuple[str, ...]:
        """Names of the muscles."""
        return self.muscles or ACTIONS[self.action]


def require_order(attempts: Sequence[Attempt], rise_s: float) -> None:
    """Raise InputError for an attempt that begins before the one before it has ended."""
    for number, (before, after) in enumerate(pairwise(attempts), 1):
        over_s = before.at_s + before.duration_s + rise_s
        if after.at_s < over_s:
            raise InputError(f"attempts[{number}].at_s", f"{after.at_s:g}",
                             f"{over_s:g} or more, when the attempt before it has ended",
                             "list attempts in order of time, and leave room between them")


class Course(NamedTuple):
    """Attempts in one trial.

    Attributes
    ----------
    onsets_ns: (attempts,), begin of each effort. falls_ns: (attempts,), begin of its fall.
    rise_ns: duration of the linear rise, and of the linear fall.
    """

    onsets_ns: NDArray[np.int64]
    falls_ns: NDArray[np.int64]
    rise_ns: int

    @classmethod
    def of(cls, attempts: Sequence[Attempt], delays_s: Array, rise_s: float) -> Course:
        """Course of attempts whose efforts begin `delays_s` (attempts,) after their instants."""
        onsets = [duration_ns(each.at_s, NS_PER_S, "at_s") + round(delay * NS_PER_S)
                  for each, delay in zip(attempts, delays_s.tolist(), strict=True)]
        falls = [onset + duration_ns(each.duration_s, NS_PER_S, "duration_s")
                 for each, onset in zip(attempts, onsets, strict=True)]
        return cls(np.array(onsets, np.int64), np.array(falls, np.int64), round(rise_s * NS_PER_S))

    def shares(self, time_ns: int) -> Array:
        """Share of each attempt's effort that is made at an instant, (attempts,), from 0 to 1."""
        rising = (time_ns - self.onsets_ns) / self.rise_ns
        falling = 1.0 - (time_ns - self.falls_ns) / self.rise_ns
        shares: Array = np.clip(np.minimum(rising, falling), 0.0, 1.0)
        return shares

    def under_way(self, time_ns: int) -> int:
        """Number of the attempt under way at an instant, from 1; 0 for none."""
        begun = int(np.searchsorted(self.onsets_ns, time_ns, side="right"))
        return begun if begun and time_ns < self.falls_ns[begun - 1] + self.rise_ns else 0


def marks(attempts: Sequence[Attempt], names: Sequence[str]) -> Any:
    """Strength of each attempt by muscle, (attempts, names); raises InputError for an unknown muscle."""
    found = np.zeros((len(attempts), len(names)))
    for row, attempt in enumerate(attempts):
        for name in attempt.contracted:
            if name not in names:
                raise InputError(f"attempts[{row}].muscles", f"{name!r}", ", ".join(names),
                                 did_you_mean(name, names) or "name muscles of other limbs in elsewhere")
            found[row, names.index(name)] = attempt.strength
    return found
