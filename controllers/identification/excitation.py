"""`excitation`: stimulation for the identification of a patient's model, in one experiment."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import isfinite, radians
from typing import Literal, cast

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.loop.abilities import Passage
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_S, duration_ns
from fesloop.loop.noise import NoiseStream
from fesloop.loop.signals import Port, Sample, Value

Array = NDArray[np.float64]


@dataclass(slots=True, eq=False)
class Answers:
    """Movement of the hand on each stair of each channel.

    Attributes
    ----------
    moved: (channels, 1 + stairs), rad, greatest change of any measured angle; column 0: on no stair.
    before: (m,), measurement at the start of the turn of `channel`.
    """

    moved: Array
    before: Array
    channel: int = -1

    @classmethod
    def none(cls, channels: int, stairs: int) -> Answers:
        """State before the first stair."""
        return cls(np.zeros((channels, 1 + stairs)), np.zeros(0))

    def note(self, channel: int, stair: int, measured: Array) -> None:
        """Record a measurement while a channel is on a stair; later ones are ignored."""
        if channel != self.channel:
            self.channel, self.before = channel, measured.copy()
        if stair < self.moved.shape[1] - 1:
            self.moved[channel, 1 + stair] = max(np.abs(measured - self.before).max(),
                                                 self.moved[channel, 1 + stair])

    def widths(self, bounds: Array, answers: Array) -> Array:
        """Widths (channels, 2), s, at which each channel moved the hand by `answers` (2,), rad, interpolated.

        A channel that never moved it that far has the longest; the shortest is at most 0.8 of the longest.
        """
        steps = np.linspace(0.0, 1.0, self.moved.shape[1])
        found = np.empty_like(bounds)
        for c, (low, high) in enumerate(bounds):
            moved = np.maximum.accumulate(self.moved[c]) + 1e-9 * steps
            found[c] = low + (high - low) * np.interp(answers, moved, steps)
        found[:, 0] = np.minimum(found[:, 0], 0.8 * found[:, 1])
        return found


@dataclass(slots=True, eq=False)
class CurrentSearchState:
    """State of the search for currents.

    Attributes
    ----------
    currents: (channels,), A; NaN until known.
    before: (m,), measurement at the start of the channel's turn, rad.
    turn: channel whose turn it is; -1 before the first.
    """

    currents: Array
    before: Array
    turn: int = -1


@dataclass(frozen=True, slots=True, kw_only=True)
class CurrentSearch:
    """Search for currents: each channel's current rises in stairs until the hand responds, its threshold.

    From then on the channel has `above_threshold` times the threshold, rounded to `step_ma`, and at most the
    greatest current allowed, which a channel without a response has too. The duration of a channel's turn
    does not depend on its threshold, so that the experiment is equally long for all patients.

    Attributes
    ----------
    width_us: pulse width in the search.
    from_ma: current of the first stair.
    step_ma: height of a stair.
    response_deg: change of any measured angle since the start of the turn that counts as a response (chosen:
        well above the scatter of a tracker at rest).
    above_threshold: current over threshold, one for all channels or one each (chosen: pulse widths of 60 to
        350 us then reach from below threshold to three times the effective current there).
    stair_s: duration of a stair (chosen: longer than twitches take to fuse and the hand to follow).
    rest_s: rest after each channel.
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
        """Duration of each channel's turn, (channels,), ns."""
        stair, rest = (duration_ns(getattr(self, key), NS_PER_S, key) for key in ("stair_s", "rest_s"))
        return np.array([self.stairs(each) * stair + rest for each in greatest_ma])

    def begin(self, greatest_ma: Sequence[float], measured: int) -> CurrentSearchState:
        """State before the search."""
        return CurrentSearchState(np.full(len(greatest_ma), np.nan), np.zeros(measured))

    def pulse(self, state: CurrentSearchState, greatest_ma: Sequence[float], channel: int, within_ns: int,
              measured: Array) -> tuple[float, float]:
        """Current, A, and width, s, of a channel `within_ns` into its turn; 0 and 0 at rest."""
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
        """Current of a channel whose threshold is known, mA."""
        factor = self.above_threshold[channel if len(self.above_threshold) > 1 else 0]
        return min(greatest_ma, self.step_ma * max(1.0, round(factor * threshold_ma / self.step_ma)))


Bounds = tuple[tuple[float, float], ...]
RESTING, SEARCHING = -1.0, -2.0
"""Phases of rest, and of the search for currents."""


@dataclass(slots=True, eq=False)
class ExcitationState:
    """State of the schedule: constants, and the random stream of the bits.

    Attributes
    ----------
    currents: (channels,), A; those of the search, if there is one.
    recruiting, binary: (channels, 2), bounds of the widths, s.
    turns_ns: (channels,), ends of the turns of the search for currents, from its start.
    answers: responses to the stairs, where the binary widths follow from them.
    """

    currents: Array
    recruiting: Array
    binary: Array
    bits: NoiseStream
    turns_ns: NDArray[np.int64]
    search: CurrentSearchState | None = None
    answers: Answers | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Excitation:
    """Recruitment channel by channel, then pseudo-random binary pulse widths on all channels at once.

    Currents are fixed, as for the controllers that will use the model, or searched for first
    (`current_search`); pulse widths are modulated. First all channels rest for `lead_s`. Then each channel
    alone rises from its lowest to its highest width, in stairs or as a ramp up and down again, and rests.
    Last, for `prbs_s`, every channel is at one of its two bounds, drawn for each bit from the run's seed:
    bits of different channels and instants are independent, and a binary signal stays binary behind any
    recruitment curve, so that linear dynamics can be identified whatever the curves are. After that there is
    no stimulation.

    Attributes
    ----------
    current_ma: (channels,), fixed current of each channel; the greatest allowed where it is searched for.
    current_search: search for currents; None: they are fixed.
    measured: size of the input `measured`; 0 takes it from the wire.
    width_us: (channels, 2), lowest and highest width of each channel's stairs or ramp.
    prbs_us: (channels, 2), bounds of the binary widths; empty: `width_us`.
    answer_deg: (least, most): each channel's binary widths are those at which some measured angle moved by
        these amounts on its stairs, in place of `prbs_us`, so that weak and strong hands move alike.
    recruitment: "staircase" or "ramp".
    lead_s: rest at the start, for a tracker to settle.
    stairs, stair_s: number of stairs and duration of one; a ramp lasts as long as all stairs.
    rest_s: rest after each channel.
    prbs_s, bit_s: duration of the binary part and of a bit (chosen: a bit of .2 s, the rise time of muscle,
        .21 s at 16 rad/s).

    Input, for a search or `answer_deg` only: `measured` (m,), rad. Outputs: `stimulation` (channels, 2), A
    and s; `phase`: number of the channel on its stairs or its rest after them; the number of channels while
    the widths are binary; -2 in the search for currents, -1 before and after all that.
    """

    current_ma: tuple[float, ...]
    width_us: Bounds
    prbs_us: Bounds = ()
    recruitment: Literal["staircase", "ramp"] = "staircase"
    lead_s: float = 5.0
    stairs: int = 6
    stair_s: float = 0.5
    rest_s: float = 1.5
    prbs_s: float = 45.0
    bit_s: float = 0.2
    current_search: CurrentSearch | None = None
    answer_deg: tuple[float, float] | None = None
    measured: int = 0

    def __post_init__(self) -> None:
        if not self.current_ma or not all(isfinite(value) and value > 0.0 for value in self.current_ma):
            raise InputError("current_ma", f"{self.current_ma}", "a finite current above 0 for each channel")
        for key in ("width_us", "prbs_us"):
            bounds = getattr(self, key)
            if len(bounds) != self.channels and (bounds or key == "width_us"):
                raise InputError(key, f"{len(bounds)} pairs", f"{self.channels}, one a channel")
            for low, high in bounds:
                if not (isfinite(low) and isfinite(high) and 0.0 <= low < high):
                    raise InputError(key, f"({low}, {high})", "0 <= lowest < highest, us")
        if self.stairs < 2:
            raise InputError("stairs", f"{self.stairs}", "2 or more")
        for key in ("lead_s", "stair_s", "rest_s", "prbs_s", "bit_s"):
            if duration_ns(getattr(self, key), NS_PER_S, key) == 0 and key in ("stair_s", "bit_s"):
                raise InputError(key, "0", "above 0")
        if self.answer_deg is not None:
            self._require_answer()
        if self.current_search and len(self.current_search.above_threshold) not in (1, self.channels):
            raise InputError("current_search.above_threshold",
                             f"{len(self.current_search.above_threshold)} factors",
                             f"one, or {self.channels}, one a channel")

    def _require_answer(self) -> None:
        least, most = self.answer_deg or (0.0, 0.0)
        if not (isfinite(most) and 0.0 < least < most):
            raise InputError("answer_deg", f"{self.answer_deg}", "0 < least < most, deg")
        if self.recruitment != "staircase" or self.prbs_us:
            raise InputError("answer_deg", f"recruitment {self.recruitment!r}, prbs_us {self.prbs_us}",
                             "a staircase, and no prbs_us", "remove prbs_us")

    @property
    def channels(self) -> int:
        """Number of channels."""
        return len(self.current_ma)

    @property
    def duration_s(self) -> float:
        """Duration of the whole schedule."""
        recruiting_s = self.channels * (self.stairs * self.stair_s + self.rest_s)
        return self.lead_s + self._search_s + recruiting_s + self.prbs_s

    @property
    def _search_s(self) -> float:
        """Duration of the search for currents."""
        search = self.current_search
        return search.turns_ns(self.current_ma).sum() / NS_PER_S if search else 0.0

    @property
    def inputs(self) -> tuple[Port, ...]:
        """`measured`, for a search or `answer_deg`."""
        looks = self.current_search or self.answer_deg
        return (Port("measured", (self.measured or None,), "rad"),) if looks else ()

    def passages(self, context: Context) -> tuple[Passage, ...]:
        """A response in the search for currents acts at once; others act when all stairs are over."""
        if self.current_search:
            return ()
        return (Passage(inputs=("measured",), later="once its stairs are over"),)

    def resolve(self, shapes: Mapping[str, tuple[int, ...]]) -> Excitation:
        """The block for the wired input; raises InputError unless it is a vector."""
        shape = shapes.get("measured", (self.measured,))
        if len(shape) != 1:
            raise InputError("measured", f"shape {shape}", "a vector")
        return replace(self, measured=shape[0])

    @property
    def outputs(self) -> tuple[Port, ...]:
        """`stimulation`, `phase`."""
        return Port("stimulation", (self.channels, 2), "A,s"), Port("phase", (), "1", RESTING)

    def init(self, context: Context) -> ExcitationState:
        """Constants, and the state before the search."""
        search, none = self.current_search, np.zeros(0, dtype=np.int64)
        return ExcitationState(np.array(self.current_ma) / 1e3, np.array(self.width_us) / 1e6,
                               np.array(self.prbs_us or self.width_us) / 1e6,
                               context.noise(self.channels, "uniform", "bits"),
                               np.cumsum(search.turns_ns(self.current_ma)) if search else none,
                               search.begin(self.current_ma, self.measured) if search else None,
                               Answers.none(self.channels, self.stairs) if self.answer_deg else None)

    def step(self, state: ExcitationState, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """Pulses and phase of this instant."""
        pulses = np.zeros((self.channels, 2))
        since_ns = tick.time_ns - duration_ns(self.lead_s, NS_PER_S, "lead_s")
        lasting_ns = self.stairs * duration_ns(self.stair_s, NS_PER_S, "stair_s")
        turn_ns = lasting_ns + duration_ns(self.rest_s, NS_PER_S, "rest_s")
        if since_ns < 0:
            return pulses, RESTING
        if state.search is not None:
            if since_ns < state.turns_ns[-1]:
                self._search(state, pulses, since_ns, cast(Array, inputs[0].value))
                return pulses, SEARCHING
            since_ns -= int(state.turns_ns[-1])
            found = state.search.currents
            state.currents = np.where(np.isnan(found), state.currents, found)
        channel, within_ns = divmod(since_ns, turn_ns)
        if channel < self.channels:
            if state.answers is not None:
                stair = int(within_ns * self.stairs // lasting_ns)
                state.answers.note(int(channel), stair, cast(Array, inputs[0].value))
            if within_ns < lasting_ns:
                low, high = state.recruiting[channel]
                width = low + (high - low) * self._climbed(within_ns / lasting_ns)
                pulses[channel] = state.currents[channel], width
            return pulses, float(channel)
        since_ns -= self.channels * turn_ns
        if since_ns >= duration_ns(self.prbs_s, NS_PER_S, "prbs_s"):
            return pulses, RESTING
        if state.answers is not None:
            state.binary = state.answers.widths(state.recruiting, np.radians(self.answer_deg or (0.0, 0.0)))
            state.answers = None
        bits = state.bits.row(since_ns // duration_ns(self.bit_s, NS_PER_S, "bit_s")) < 0.5
        widths = np.where(bits, state.binary[:, 1], state.binary[:, 0])
        pulses[widths > 0.0, 0] = state.currents[widths > 0.0]
        pulses[:, 1] = widths
        return pulses, float(self.channels)

    def _search(self, state: ExcitationState, pulses: Array, since_ns: int, measured: Array) -> None:
        """Fill the pulse of the channel whose current is searched for."""
        assert self.current_search is not None
        assert state.search is not None
        channel = int(np.searchsorted(state.turns_ns, since_ns, side="right"))
        within_ns = since_ns - (int(state.turns_ns[channel - 1]) if channel else 0)
        pulses[channel] = self.current_search.pulse(
            state.search, self.current_ma, channel, within_ns, measured)

    def _climbed(self, share: float) -> float:
        """Position of a channel between its bounds after this share of its time."""
        if self.recruitment == "ramp":
            return 1.0 - abs(2.0 * share - 1.0)
        return (int(share * self.stairs) + 1.0) / self.stairs
