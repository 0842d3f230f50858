"""Which share of each muscle the pulses of one period recruit, and how that changes with their widths."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.loop.block import Context, Tick
from fesloop.loop.signals import Sample

Array = NDArray[np.float64]
SECANT_S = 20e-6
"""Half the width over which slopes are taken: axons fire one by one (chosen: some of each muscle's 64)."""
_FIRST_STEP_S = 5e-6
"""Of the search for thresholds (chosen: no muscle gains two axons within it)."""


class RecruitedFront:
    """Stimulator's electrodes, arrays and axons as a static map, channels one after the other in their slots.

    Parameters
    ----------
    parts: with `stimulator` and `electrodes`.
    currents: (channels,), A.
    width_most: (channels,), s.
    seed: of the run.

    Attributes
    ----------
    threshold: (channels,), s, up to which a channel alone recruits nothing.
    """

    __slots__ = ("_clock", "_currents", "_electrodes", "_hertz", "_period", "_shares", "_slot", "_state",
                 "_still", "threshold", "width_most")

    def __init__(self, parts: dict[str, Any], currents: Array, width_most: Array, seed: int) -> None:
        stimulator, self._electrodes = parts["stimulator"], parts["electrodes"]
        self._clock, self._shares, self._currents = stimulator.clock, stimulator.shares, currents
        self._hertz = float(stimulator.frequency_hz)
        self._state = self._electrodes.init(Context("electrodes", seed, 0, self._clock))
        self._still = [Sample(port.initial_value(), -1, -1, -1) for port in self._electrodes.inputs[1:]]
        self._period, self._slot = round(1.0 / self._hertz / self._clock.period_s), 0
        self.width_most = width_most
        self.threshold = np.array([self._threshold(c) for c in range(len(currents))])

    def _threshold(self, channel: int) -> float:
        widths = np.zeros(len(self._currents))
        for width in np.arange(_FIRST_STEP_S, self.width_most[channel], _FIRST_STEP_S):
            widths[channel] = width
            if self.recruited(widths).any():
                return float(width) - _FIRST_STEP_S
        return float(self.width_most[channel])

    def recruited(self, widths: Array) -> Array:
        """Recruited shares, (29,), of pulses of `widths` (channels,), s, one a channel and period."""
        first = (self._slot // self._period + 2) * self._period
        tick, none = Tick(), Sample(np.zeros((self._electrodes.elements, 3)), -1, -1, -1)
        recruitment = np.zeros(0)
        firing = [channel for channel in range(len(widths)) if widths[channel] > 0.0]
        for channel in firing or [0]:
            tick.index = self._slot = first + channel
            tick.time_ns = self._clock.tick(tick.index)
            message = self._message(channel, widths[channel], tick.time_ns) if firing else none
            recruitment, _ = self._electrodes.step(self._state, [message, *self._still], tick)
        return recruitment

    def _message(self, channel: int, width: float, now_ns: int) -> Sample:
        """A channel's pulse in its slot."""
        pulses, row = np.zeros((self._electrodes.elements, 3)), self._shares[channel]
        on = row > 0.0
        pulses[on, 0] = self._currents[channel] * row[on]
        pulses[on, 1:] = width, self._hertz
        return Sample(pulses, now_ns, now_ns, now_ns)

    def slopes(self, widths: Array) -> Array:
        """Change of recruited shares with widths, (29, channels), 1/s, about `widths` (channels,), s."""
        columns = []
        for channel in range(len(widths)):
            shifted = []
            for side in (-SECANT_S, SECANT_S):
                moved = widths.copy()
                moved[channel] = np.clip(widths[channel] + side, 0.0, self.width_most[channel])
                shifted.append((moved[channel], self.recruited(moved)))
            (low, below), (high, above) = shifted
            columns.append((above - below) / (high - low))
        return np.stack(columns, axis=1)
