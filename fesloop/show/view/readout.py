"""Numbers beside the hand of a view: joint angles and stimulation at the instant that is shown."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.hand.skeleton import hand_tree
from fesloop.show.picture.cast import Cast
from fesloop.show.picture.courses import DIGITS
from fesloop.show.picture.signals import Signals, values_at
from fesloop.show.report.recorded_hand import ESTIMATE, TRUTH

Array = NDArray[np.float64]
Instants = NDArray[np.int64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Readout:
    """Joint angles and stimulation of a recording that a view shows as numbers at each instant.

    Attributes
    ----------
    joints: names of the angles. angles: by hand ("truth", "estimate"), the signal of these angles, rad.
    stimulation: signal of currents, A, and pulse widths, s, by channel; empty without one.
    channels: number of these.
    """

    joints: tuple[str, ...] = ()
    angles: Mapping[str, str] = field(default_factory=dict)
    stimulation: str = ""
    channels: int = 0

    @property
    def nodes(self) -> list[str]:
        """Blocks and plants whose outputs are read."""
        names = [*self.angles.values(), *([self.stimulation] if self.stimulation else [])]
        return list(dict.fromkeys(name.partition(".")[0] for name in names))

    @property
    def groups(self) -> list[dict[str, Any]]:
        """Names of the angles by part of the hand: title, and words of each angle, in their order."""
        found: dict[str, list[str]] = {}
        for name in self.joints:
            part, _, words = name.partition("_")
            title = DIGITS.get(part, "") if words else ""
            found.setdefault(title or "joints", []).append(_words(words if title else name))
        return [{"title": title, "joints": words} for title, words in found.items()]

    def at(self, signals: Signals, trial: int, at_ns: Instants) -> list[dict[str, Any]]:
        """Readings at instants of a trial, fit for JSON: angles by hand, deg, and by channel mA and us."""
        angles = {hand: values_at(signals, name, trial, at_ns) for hand, name in self.angles.items()}
        pulses = values_at(signals, self.stimulation, trial, at_ns) if self.stimulation else None
        return [{"angles": {hand: _numbers(np.rad2deg(rows[i]), 1)
                            for hand, rows in angles.items() if rows is not None},
                 "pulses": [] if pulses is None else [_numbers(row * (1e3, 1e6), 1) for row in pulses[i]]}
                for i in range(len(at_ns))]


def readout_of(signals: Signals, cast: Cast, score: Mapping[str, Any]) -> Readout:
    """Readout of a recording: the angles of a whole hand, or else those that are scored, and stimulation."""
    joints, angles = _whole_hand(signals, cast)
    if not angles:
        joints, angles = _scored(signals, score)
    pulses = _shape(signals, cast.stimulation)
    shown = len(pulses) == 2 and pulses[1] == 2
    return Readout(joints=joints, angles=angles, stimulation=cast.stimulation if shown else "",
                   channels=pulses[0] if shown else 0)


def _whole_hand(signals: Signals, cast: Cast) -> tuple[tuple[str, ...], dict[str, str]]:
    players = [(TRUTH, cast.hand), *((ESTIMATE, each) for each in cast.trackers)]
    found: dict[str, str] = {}
    names: tuple[str, ...] = ()
    for hand, player in players:
        if player is None or hand in found:
            continue
        freedoms = hand_tree(player.hand_size).freedoms
        if _shape(signals, f"{player.name}.angles") == (len(freedoms),):
            found[hand], names = f"{player.name}.angles", tuple(freedoms)
    return names, found


def _scored(signals: Signals, score: Mapping[str, Any]) -> tuple[tuple[str, ...], dict[str, str]]:
    """Scored angles, named as the score names them, or by number."""
    found: dict[str, str] = {}
    count = 0
    for hand in (TRUTH, ESTIMATE):
        shape = _shape(signals, score.get(hand))
        if len(shape) == 1 and count in (0, shape[0]):
            found[hand], count = str(score[hand]), shape[0]
    named = tuple(map(str, score.get("joints") or ()))
    return named if len(named) == count else tuple(f"joint {i}" for i in range(count)), found


def _shape(signals: Signals, name: object) -> tuple[int, ...]:
    """Shape of a signal's values; empty if it is not recorded."""
    if not isinstance(name, str) or name not in signals.signals:
        return ()
    return tuple(signals.column(name)[1].shape[1:])


def _words(name: str) -> str:
    """Name of an angle in words: "mcp_flexion" is "MCP flexion"."""
    return " ".join(word.upper() if word in ("mcp", "pip", "dip", "cmc", "ip") else word
                    for word in name.split("_"))


def _numbers(row: Array, decimals: int) -> list[float | None]:
    return [round(float(each), decimals) if np.isfinite(each) else None for each in row]
