"""What an inlet remembers of its stream."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from fesloop.loop.record import StatusLatch
from fesloop.loop.signals import NEVER, Value
from fesloop.streams.live.description import Picked
from fesloop.streams.live.reader import StreamReader

Array = NDArray[np.float64]


@dataclass(slots=True, eq=False)
class InletState:
    """An open stream.

    Attributes
    ----------
    reader: its thread and the samples that wait.
    picked: channels of each output.
    origin_ns: t = 0 of the trial by the monotonic clock; NEVER before the first.
    heard_ns: loop time of the newest tick, and of t = 0.
    captured_ns: loop time of the newest capture put out.
    silent_since_ns: loop time of the last sample before the stream fell silent; NEVER while it is not.
    before, same: numbers of the newest sample, and how many on end have had them before it.
    channels, factors: of all outputs in a row.
    """

    reader: StreamReader
    picked: tuple[Picked, ...]
    origin_ns: int = NEVER
    heard_ns: int = 0
    captured_ns: int = 0
    silent_since_ns: int = NEVER
    before: Array = field(default_factory=lambda: np.empty(0))
    same: int = 0
    latch: StatusLatch = field(default_factory=StatusLatch)
    channels: NDArray[np.int64] = field(init=False)
    factors: Array = field(init=False)

    def __post_init__(self) -> None:
        self.channels = np.concatenate([picked.channels.ravel() for picked in self.picked])
        self.factors = np.concatenate([picked.factors.ravel() for picked in self.picked])

    def outputs(self, numbers: Array) -> tuple[Value, ...]:
        """A row of numbers as the outputs."""
        parts, first = [], 0
        for picked in self.picked:
            size = picked.channels.size
            parts.append(numbers[first:first + size].reshape(picked.channels.shape))
            first += size
        return tuple(parts)
