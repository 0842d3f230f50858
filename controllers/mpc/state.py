"""What a running predictive controller remembers."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from controllers.grip.contact import Touch
from controllers.mpc.design import Candidate
from controllers.mpc.fallback import Fallback
from controllers.mpc.kernel import Loop
from controllers.mpc.observer import ObserverState
from fesloop.loop.record import StatusLatch

Array = NDArray[np.float64]


@dataclass(slots=True, eq=False)
class MpcState:
    """Everything that a running controller remembers, and what its clock decides.

    Attributes
    ----------
    reach, table: coefficients; never written to.
    candidates, chosen: the plant as it may be, and number of the one that control goes by.
    drive: (muscles,), in force.
    pulses: (muscles, 2), in force.
    given_uc: (N,), charge of the last N ticks on all channels, oldest first; of size 0 without a budget.
    fallback: what is done while the controller is kept from control.
    alone: the model's own loop while the hand touches something.
    touch: whether the hand touches something.
    """

    reach: Array
    table: Array
    candidates: tuple[Candidate, ...]
    chosen: int
    drive: Array
    pulses: Array
    given_uc: Array
    fallback: Fallback = field(default_factory=Fallback)
    alone: Loop | None = None
    touch: Touch = field(default_factory=Touch)
    latch: StatusLatch = field(default_factory=StatusLatch)

    @property
    def estimate(self) -> ObserverState:
        """Of the plant, as control has it."""
        return self.candidates[self.chosen].estimate
