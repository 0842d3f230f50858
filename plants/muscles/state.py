"""What muscles remember."""

from __future__ import annotations

from bisect import insort
from operator import itemgetter
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from fesloop.hand.movements import MUSCLES
from plants.muscles.lags import LagState

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
PULSES, EFFORT, REFLEX = range(3)
"""Signals on their way to a muscle: (recruited fraction, frequency in Hz) (2, muscles); drives (muscles,)."""


class Contraction(Protocol):
    """How all muscles contract; its state copies itself by `copy()`, and changes at instants of its own."""

    def start(self) -> Any:
        """A state at rest, fresh."""

    def rested(self, state: Any, rest_s: float) -> Any:
        """A state at rest, `rest_s` after `state`."""

    def advance(self, state: Any, stop_ns: int) -> None:
        """As far as the model's own instants go before `stop_ns`."""

    def change(self, state: Any, time_ns: int, pulses: Array, drive: Array) -> None:
        """From `time_ns` on `pulses` (2, muscles) act, or the steady activation `drive` (muscles,)."""

    def look(self, state: Any, time_ns: int) -> tuple[Array, Array]:
        """At an instant by which `advance` went: activation, and what the model's own fatigue has left of
        the fresh muscles, (muscles,) each."""


class MusclesState:
    """Where the muscles are. Everything but `now_ns` changes at instants of their own, whoever looks.

    Attributes
    ----------
    now_ns: instant that the state is of.
    stimulated, natural: what stimulation, and what nerves, have made of the muscles.
    fitness, effort: (muscles,), fitness at `since_ns` and what wears it from then on.
    since_ns: the last change of the drive.
    seen: the inputs as they last were, to tell new ones at a glance.
    sent, acting: the newest value of each signal that left for the muscles, and the one that acts.
    arriving: values under way through the delays, with their instants in ns, in order of arrival, and the
        muscles that they are for, (muscles,), None for all.
    latest: (3, muscles), last arrivals of each signal, where muscles have delays of their own.
    waves: of the tremor (3, c).
    left: share of their force that trials have left of the muscles.
    """

    __slots__ = ("acting", "arriving", "effort", "fitness", "latest", "left", "natural", "now_ns", "seen",
                 "sent", "since_ns", "stimulated", "waves")

    def __init__(self, stimulated: Any, natural: LagState, fitness: Array, waves: Array) -> None:
        count = len(MUSCLES)
        self.now_ns = self.since_ns = 0
        self.stimulated, self.natural = stimulated, natural
        self.fitness, self.effort, self.waves = fitness, np.zeros(count), waves
        self.seen: tuple[Array | None, ...] = (None,) * 4
        self.sent: list[Array] = [np.zeros((2, count)), np.zeros(count), np.zeros(count)]
        self.acting: list[Array] = list(self.sent)
        self.arriving: list[tuple[int, int, Array, Flags | None]] = []
        self.latest = np.zeros((3, count), np.int64)
        self.left = 1.0

    def send(self, arrival_ns: int, signal: int, value: Array) -> None:
        """Put a value on its way to all muscles."""
        insort(self.arriving, (arrival_ns, signal, value, None), key=itemgetter(0))

    def send_late(self, arrival_ns: int, late_ns: NDArray[np.int64], signal: int, value: Array) -> None:
        """Put a value on its way to each muscle, where it arrives `late_ns` (muscles,) later, in order."""
        arrivals = np.maximum(arrival_ns + late_ns, self.latest[signal])
        self.latest[signal] = arrivals
        for instant in np.unique(arrivals):
            insort(self.arriving, (int(instant), signal, value, arrivals == instant), key=itemgetter(0))

    def copy(self) -> MusclesState:
        """A state that can go ahead on its own."""
        ahead = MusclesState.__new__(MusclesState)
        ahead.now_ns, ahead.since_ns = self.now_ns, self.since_ns
        ahead.stimulated, ahead.natural = self.stimulated.copy(), self.natural.copy()
        ahead.fitness, ahead.effort, ahead.waves = self.fitness, self.effort, self.waves
        ahead.seen = self.seen
        ahead.sent, ahead.acting = self.sent.copy(), self.acting.copy()
        ahead.left = self.left
        ahead.arriving, ahead.latest = self.arriving.copy(), self.latest.copy()
        return ahead
