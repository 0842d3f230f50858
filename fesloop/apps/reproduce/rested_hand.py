"""What elements of the arrays truly do: the response of a rested hand, its muscles fresh, without any noise.

The same blocks as in the loop (electrodes, muscles, hand) and the same timetable, but nothing in between and
nothing before: every query meets the hand at rest, and no muscle has tired. That is what a search is scored
on, and thirty times faster than searching exhaustively in the loop.
"""

from __future__ import annotations

import copy
from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.experiment.experiment import Experiment
from fesloop.hand.muscles import MUSCLES
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_S, RateClock
from fesloop.loop.signals import Sample, Value

Array = NDArray[np.float64]
Key = tuple[tuple[int, ...], float]
"""Elements, and the current through them, mA."""
SETTLE_S = 6.0
"""After which the hand lies still under gravity (chosen: several of the wrist's time constants)."""
_TICK_RATE = 40
_STEP_NS = 1_000_000


class RestedHand:
    """The hand of an experiment with nodes `electrodes`, `muscles`, `hand` and `search`, at rest.

    Attributes
    ----------
    space, timetable: of the search. rest: (23,), rad, its posture.
    """

    __slots__ = ("_body", "_electrodes", "_hand", "_muscles", "_none", "_seed", "rest", "space", "timetable")

    def __init__(self, experiment: Experiment) -> None:
        parts: dict[str, Any] = {node.name: node.part for node in experiment.nodes}
        self.space, self.timetable = parts["search"].space, parts["search"].timetable
        self._electrodes, self._hand = parts["electrodes"], parts["hand"]
        self._muscles = replace(parts["muscles"], fatigue=None)
        self._seed = experiment.seed
        self._none = np.zeros(len(MUSCLES))
        self._body = self._hand.init(Context("hand", self._seed))
        for now in range(0, int(SETTLE_S * NS_PER_S), _STEP_NS):
            self._hand.advance(self._body, [self._none], now, now + _STEP_NS)
        self.rest: Array = self._hand.glance(self._body)[0]

    def responses(self, queries: Iterable[Key]) -> dict[Key, Array]:
        """Movement from rest, (23,), rad, of each query."""
        return {query: self.response(*query) for query in queries}

    def response(self, elements: tuple[int, ...], current_ma: float) -> Array:
        """Movement from rest, (23,), rad, while a query is looked at; zeros where it excites no axon."""
        times = self.timetable
        ticks = [round(seconds * _TICK_RATE) for seconds in (times.ramp_s, times.settle_s, times.measure_s)]
        shares = [*(0.5 + 0.5 * k / ticks[0] for k in range(ticks[0])), *(1.0,) * sum(ticks[1:])]
        whole = self._recruited(elements, current_ma, 1.0)
        if not whole[0].any():
            return np.zeros_like(self.rest)
        drives = {share: self._recruited(elements, current_ma, share) for share in dict.fromkeys(shares)}
        muscles, hand = self._muscles.init(Context("muscles", self._seed)), copy.deepcopy(self._body)
        now, per_tick, seen = int(SETTLE_S * NS_PER_S), NS_PER_S // _TICK_RATE // _STEP_NS, []
        for share in shares:
            for _ in range(per_tick):
                velocity = self._hand.glance(hand)[9] if self._muscles.reflex is not None else self._none
                inputs = [*drives[share], velocity, self._none]
                activation = self._muscles.read(muscles, inputs)[0]
                self._hand.advance(hand, [activation], now, now + _STEP_NS)
                self._muscles.advance(muscles, inputs, now, now + _STEP_NS)
                now += _STEP_NS
            seen.append(self._hand.glance(hand)[0])
        mean: Array = np.mean(seen[-ticks[2]:], axis=0)
        return mean - self.rest

    def _recruited(self, elements: tuple[int, ...], current_ma: float, share: float) -> tuple[Array, Array]:
        """Recruitment and frequency, (29,) each, at a share of the pulse width."""
        clock, tick = RateClock.from_rate(_TICK_RATE), Tick()
        state = self._electrodes.init(Context("electrodes", self._seed, 0, clock))
        pulses = np.zeros((self._electrodes.elements, 3))
        pulses[list(elements)] = (1e-3 * current_ma / len(elements), 1e-6 * share * self.space.width_us,
                                  float(_TICK_RATE))
        values: tuple[Value, ...] = (pulses, 0.0, np.ones(len(pulses)), np.zeros(2))
        stamps = (0, -1, -1, -1)
        recruitment, frequency = self._electrodes.step(
            state, [Sample(value, at, at, at) for value, at in zip(values, stamps, strict=True)], tick)
        return recruitment, frequency
