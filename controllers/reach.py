"""Angles that a model's stimulation can hold, and a report of a reference beyond them."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.loop.block import Tick
from fesloop.loop.record import StatusLatch
from fesloop.models.linear_model import LinearModel

Array = NDArray[np.float64]
_EVERY = 10
"""Ticks between two looks (chosen: a target is held for longer)."""
_BEYOND_RAD = math.radians(5.0)
"""Distance beyond what can be held from which it is reported (chosen: errors of identified models)."""


class Reach(NamedTuple):
    """Least and greatest angle (outputs,), rad, that constant drives can hold, each output by itself."""

    least: Array
    greatest: Array

    def look(self, latch: StatusLatch, tick: Tick, reference: Array) -> None:
        """Report a reference (outputs,), rad, beyond these angles, when it gets there."""
        if tick.index % _EVERY:
            return
        beyond = np.maximum(self.least - reference, reference - self.greatest)
        if beyond.max() < _BEYOND_RAD and "out_of_reach" not in latch.holding:
            return
        worst = int(np.argmax(beyond))
        ends = np.degrees([reference[worst], self.least[worst], self.greatest[worst]])
        latch.put(tick, "out_of_reach", bool(beyond[worst] >= _BEYOND_RAD),
                  f"the reference of output {worst} is {ends[0]:.0f} deg; by the model, stimulation of these "
                  f"channels holds {ends[1]:.0f} to {ends[2]:.0f} deg")


def reach_of(model: LinearModel, greatest_drive: Array) -> Reach:
    """Angles that drives from 0 to `greatest_drive` (muscles,) hold; no limits for an unstable model."""
    if np.linalg.eigvals(model.a).real.max() >= 0.0:
        return Reach(np.full(model.outputs, -math.inf), np.full(model.outputs, math.inf))
    effects = -model.c @ np.linalg.solve(model.a, model.b) * greatest_drive
    return Reach(model.offset + np.minimum(effects, 0.0).sum(axis=1),
                 model.offset + np.maximum(effects, 0.0).sum(axis=1))
