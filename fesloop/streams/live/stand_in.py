"""What takes the place of a live stream where none is to be touched: rehearsals and checks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import RateClock
from fesloop.loop.signals import Port, Sample, Value
from fesloop.streams.labels import GRAVITY

_AT_REST = {"gyr": (0.0, 0.0, 0.0), "acc": (0.0, 0.0, GRAVITY), "mag": (0.0, 2e-5, -4e-5)}
"""Gravity, and a field of the mid latitudes, 45 uT (IGRF: 25 to 65 uT)."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class InletStandIn:
    """Sensors that lie still, or joints at zero, at a plain rate.

    Attributes
    ----------
    outputs: ports of the inlet that it stands for.
    rate: Hz.
    """

    outputs: tuple[Port, ...]
    rate: str
    inputs: tuple[Port, ...] = ()
    clock: RateClock = field(init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "clock", RateClock.from_rate(self.rate))

    def init(self, context: Context) -> None:
        """No state."""

    def step(self, state: None, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """The same at every tick."""
        return tuple(port.initial_value() + np.array(_AT_REST.get(port.name, 0.0)) for port in self.outputs)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class OutletStandIn:
    """Takes what an outlet takes, and sends nothing.

    Attributes
    ----------
    inputs: ports of the outlet that it stands for.
    """

    inputs: tuple[Port, ...]
    outputs: tuple[Port, ...] = ()

    def init(self, context: Context) -> None:
        """No state."""

    def step(self, state: None, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """Nothing."""
        return ()
