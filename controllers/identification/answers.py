"""How far a hand moved on each stair of an excitation, and which pulse widths move it so far."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(slots=True, eq=False)
class Answers:
    """How far the hand moved on each stair of each channel.

    Attributes
    ----------
    moved: (channels, 1 + stairs), rad, greatest change of any measured angle; 0 on no stair.
    before: (m,), what was measured when the channel's turn began; `channel` says whose.
    """

    moved: Array
    before: Array
    channel: int = -1

    @classmethod
    def none(cls, channels: int, stairs: int) -> Answers:
        """Before the first stair."""
        return cls(np.zeros((channels, 1 + stairs)), np.zeros(0))

    def note(self, channel: int, stair: int, measured: Array) -> None:
        """What is measured while a channel is on a stair; what comes after the last counts for nothing."""
        if channel != self.channel:
            self.channel, self.before = channel, measured.copy()
        if stair < self.moved.shape[1] - 1:
            self.moved[channel, 1 + stair] = max(np.abs(measured - self.before).max(),
                                                 self.moved[channel, 1 + stair])

    def widths(self, bounds: Array, answers: Array) -> Array:
        """(channels, 2), s: where each channel moved the hand by `answers` (2,), rad, between the stairs.

        Where it never moved that far, the longest; the shortest is four fifths of the longest at most.
        """
        steps = np.linspace(0.0, 1.0, self.moved.shape[1])
        found = np.empty_like(bounds)
        for c, (low, high) in enumerate(bounds):
            moved = np.maximum.accumulate(self.moved[c]) + 1e-9 * steps
            found[c] = low + (high - low) * np.interp(answers, moved, steps)
        found[:, 0] = np.minimum(found[:, 0], 0.8 * found[:, 1])
        return found
