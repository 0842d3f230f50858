"""What a running predictive controller remembers."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from controllers.grip.contact import Touch
from controllers.limits.allocation import risen
from controllers.mpc.design import Candidate
from controllers.mpc.fallback import Fallback
from controllers.mpc.observer import ObserverState
from controllers.mpc.parameters import MpcParameters
from fesloop.loop.block import Tick
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


@dataclass(slots=True, eq=False)
class Loop:
    """What a programme starts from: of the plant, or of the model alone.

    Attributes
    ----------
    estimate: of the state.
    drive, pulses: in force, (muscles,) and (muscles, 2).
    """

    estimate: ObserverState
    drive: Array
    pulses: Array

    def copied(self) -> Loop:
        """As it is now, from here on by itself."""
        now = self.estimate
        return Loop(ObserverState(now.at_ns, now.x.copy(), now.disturbance.copy(), now.strength.copy(),
                                  now.stamps.copy(), now.inputs.copy()), self.drive, self.pulses.copy())


_BAD_INPUT = ("no_input", "stale_input", "non_finite")


def fall_back(mpc: MpcParameters, state: MpcState, tick: Tick, trouble: str, detail: str) -> None:
    """Set the drive to the safe one, and tell of the trouble when it begins.

    The last plan goes on where only the programme failed, within the limits of a tick; else the drive is held
    and ramped.
    """
    fallback, muscles = state.fallback, state.drive.size
    if trouble != fallback.trouble:
        tick.report(trouble, detail)
    fallback.trouble = trouble
    planned = None if trouble in _BAD_INPUT else fallback.next_planned(muscles, mpc.horizon)
    if planned is None:
        state.drive = fallback.ramped(state.drive, tick.time_ns, mpc.hold_ms, mpc.ramp_ms)
        return
    rise = np.empty(muscles)
    risen(state.table, state.pulses, 1e-6 * mpc.charge_rise_uc, rise)
    wanted = np.minimum(planned / state.estimate.strength, state.drive + mpc.slew)
    state.drive = np.minimum(wanted, np.minimum(state.reach, np.maximum(rise, state.drive)))
