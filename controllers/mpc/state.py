"""State of a running predictive controller, and its safe output."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from controllers.allocation import risen
from controllers.grip import Touch
from controllers.mpc.design import Candidate
from controllers.mpc.memory import Course
from controllers.mpc.observer import ObserverState
from controllers.mpc.parameters import MpcParameters
from controllers.reach import Reach
from fesloop.loop.block import Tick
from fesloop.loop.clock import NS_PER_MS
from fesloop.loop.record import StatusLatch
from fesloop.loop.signals import NEVER

Array = NDArray[np.float64]


@dataclass(slots=True, eq=False)
class Fallback:
    """Last solution, and the drive from which a ramp to zero starts.

    Attributes
    ----------
    planned: (steps muscles,), last solution; size 0 before the first.
    used: number of its steps that have been issued.
    trouble: status that prevents control; "" for none.
    held, held_ns: (muscles,), drive that is held and then ramped to zero, and its instant; NEVER for none.
    """

    planned: Array = field(default_factory=lambda: np.empty(0))
    used: int = 0
    trouble: str = ""
    held: Array = field(default_factory=lambda: np.empty(0))
    held_ns: int = NEVER

    def solved(self, planned: Array) -> None:
        """Store a solution whose first step is issued now."""
        self.planned, self.used, self.trouble, self.held_ns = planned, 1, "", NEVER

    def next_planned(self, muscles: int, steps: int) -> Array | None:
        """Next step of the last solution, (muscles,); None once `steps` of it have been issued."""
        if self.used >= steps or self.planned.size == 0:
            return None
        following = self.planned[self.used * muscles:(self.used + 1) * muscles]
        self.used, self.held_ns = self.used + 1, NEVER
        return following

    def ramped(self, drive: Array, now_ns: int, hold_ms: float, ramp_ms: float) -> Array:
        """Drive (muscles,) held since the first call, then ramped to zero."""
        if self.held_ns == NEVER:
            self.held, self.held_ns = drive, now_ns
        ramping_ms = (now_ns - self.held_ns) / NS_PER_MS - hold_ms
        return self.held * (1.0 if ramping_ms <= 0.0 else max(0.0, 1.0 - ramping_ms / max(ramp_ms, 1e-9)))



@dataclass(slots=True, eq=False)
class MpcState:
    """State of the controller, with the coefficients that follow from its clock.

    Attributes
    ----------
    reach, held, table: constant coefficients: greatest drives, angles that they can hold, pulses.
    candidates, chosen: models of the plant, and the index of the one in use.
    drive: (muscles,), present drive.
    pulses: (muscles, 2), present pulses.
    given_uc: (N,), charge of the last N ticks on all channels, oldest first; of size 0 without a limit.
    fallback: safe output while control is not possible.
    alone: loop on the model alone while the hand touches something.
    touch: whether the hand touches something.
    latch: statuses that hold until they end.
    course: record of the trial and what is expected of it; None without memory.
    """

    reach: Array
    held: Reach
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
    course: Course | None = None

    @property
    def estimate(self) -> ObserverState:
        """Estimate of the chosen candidate."""
        return self.candidates[self.chosen].estimate


@dataclass(slots=True, eq=False)
class Loop:
    """Estimate and present output from which a programme starts: of the plant, or of the model alone.

    Attributes
    ----------
    estimate: estimated state.
    drive, pulses: present ones, (muscles,) and (muscles, 2).
    """

    estimate: ObserverState
    drive: Array
    pulses: Array

    def copied(self) -> Loop:
        """Independent copy."""
        now = self.estimate
        return Loop(ObserverState(now.at_ns, now.x.copy(), now.disturbance.copy(), now.strength.copy(),
                                  now.stamps.copy(), now.inputs.copy()), self.drive, self.pulses.copy())


_BAD_INPUT = ("no_input", "stale_input", "non_finite")


def fall_back(mpc: MpcParameters, state: MpcState, tick: Tick, trouble: str, detail: str) -> None:
    """Set the drive to the safe output, and report the trouble when it begins.

    Where only the programme failed, the last solution continues within the limits of a tick; otherwise the
    drive is held and ramped to zero.
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
    target = np.minimum(planned / state.estimate.strength, state.drive + mpc.slew)
    state.drive = np.minimum(target, np.minimum(state.reach, np.maximum(rise, state.drive)))
