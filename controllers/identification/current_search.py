"""How strong a current each channel needs: what a therapist finds out before anything else."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite, radians

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.loop.clock import NS_PER_S, duration_ns

Array = NDArray[np.float64]


@dataclass(slots=True, eq=False)
class CurrentSearchState:
    """What was found so far.

    Attributes
    ----------
    currents: (channels,), A; NaN until known.
    before: (m,), what was measured when the channel's turn began, rad.
    turn: whose turn it is; -1 before the first.
    """

    currents: Array
    before: Array
    turn: int = -1


@dataclass(frozen=True, slots=True, kw_only=True)
class CurrentSearch:
    """Each channel's current climbs in stairs until the hand answers; that is its threshold.

    From then on the channel has `above_threshold` times the threshold, rounded to `step_ma`, and at most the
    greatest current allowed, which a channel also gets to which the hand never answers. Each channel's turn
    lasts as long whatever it finds, so the length of the experiment does not depend on the patient.

    Attributes
    ----------
    width_us: pulse width meanwhile.
    from_ma: first stair. step_ma: height of each.
    response_deg: change of any measured angle, from where it was when the turn began, that is an answer
        (chosen: well above the scatter of a tracker whose wearer rests).
    above_threshold: current over threshold, one for all channels or one each (chosen: pulse widths of 60 to
        350 us then reach from below threshold to three times the effective current there).
    stair_s: length of a stair (chosen: longer than a twitch fuses and the hand follows).
    rest_s: after each channel.
    """

    width_us: float = 200.0
    from_ma: float = 2.0
    step_ma: float = 1.0
    response_deg: float = 5.0
    above_threshold: tuple[float, ...] = (2.0,)
    stair_s: float = 0.3
    rest_s: float = 1.5

    def __post_init__(self) -> None:
        for key in ("width_us", "from_ma", "step_ma", "response_deg"):
            value = getattr(self, key)
            if not (isfinite(value) and value > 0.0):
                raise InputError(f"current_search.{key}", f"{value}", "finite, above 0")
        if not self.above_threshold or not all(isfinite(x) and x >= 1.0 for x in self.above_threshold):
            raise InputError("current_search.above_threshold", f"{self.above_threshold}",
                             "1 or more, for all channels or for each")
        if duration_ns(self.stair_s, NS_PER_S, "current_search.stair_s") == 0:
            raise InputError("current_search.stair_s", "0", "above 0")
        duration_ns(self.rest_s, NS_PER_S, "current_search.rest_s")

    def stairs(self, greatest_ma: float) -> int:
        """Number of stairs up to the greatest current."""
        return int(max(0.0, greatest_ma - self.from_ma) / self.step_ma + 1e-9) + 1

    def turns_ns(self, greatest_ma: Sequence[float]) -> NDArray[np.int64]:
        """Length of each channel's turn, (channels,), ns."""
        stair, rest = (duration_ns(getattr(self, key), NS_PER_S, key) for key in ("stair_s", "rest_s"))
        return np.array([self.stairs(each) * stair + rest for each in greatest_ma])

    def begin(self, greatest_ma: Sequence[float], measured: int) -> CurrentSearchState:
        """Nothing known yet."""
        return CurrentSearchState(np.full(len(greatest_ma), np.nan), np.zeros(measured))

    def pulse(self, state: CurrentSearchState, greatest_ma: Sequence[float], channel: int, within_ns: int,
              measured: Array) -> tuple[float, float]:
        """(current A, width s) of a channel, `within_ns` into its turn; (0, 0) once it rests."""
        if state.turn != channel:
            state.turn, state.before = channel, measured.copy()
        stair = within_ns // duration_ns(self.stair_s, NS_PER_S, "stair_s")
        climbed = min(stair, self.stairs(greatest_ma[channel]) - 1)
        current_ma = self.from_ma + self.step_ma * climbed
        if not np.isnan(state.currents[channel]):
            return 0.0, 0.0
        if (np.abs(measured - state.before) > radians(self.response_deg)).any():
            state.currents[channel] = 1e-3 * self._above(channel, current_ma, greatest_ma[channel])
        elif stair > climbed:
            state.currents[channel] = 1e-3 * greatest_ma[channel]
        else:
            return 1e-3 * current_ma, 1e-6 * self.width_us
        return 0.0, 0.0

    def _above(self, channel: int, threshold_ma: float, greatest_ma: float) -> float:
        """What a channel gets whose threshold is known, mA."""
        factor = self.above_threshold[channel if len(self.above_threshold) > 1 else 0]
        return min(greatest_ma, self.step_ma * max(1.0, round(factor * threshold_ma / self.step_ma)))
