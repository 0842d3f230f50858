"""The programme of a tick: from what a loop knows and has in force to vectors for `Qp.solve_around`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from controllers.mpc.kernel import pose
from controllers.mpc.observer import ObserverState
from controllers.mpc.plan import charge_room
from controllers.qp.kernel import NOT_FINITE
from fesloop.loop.signals import Sample

if TYPE_CHECKING:
    from controllers.mpc.block import Mpc
    from controllers.mpc.state import MpcState

Array = NDArray[np.float64]


class Posed(NamedTuple):
    """A programme as `Qp.solve_around` takes it."""

    best: Array
    lower: Array
    upper: Array
    below: Array
    above: Array
    fault: int


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


def posed(
    mpc: Mpc, state: MpcState, loop: Loop, gain: Array, reference: Array, sample: Sample, captured_ns: int,
    now_ns: int,
) -> Posed:
    """The programme of a loop, whose estimate takes in the sample, captured at `captured_ns`, with a gain."""
    candidate, estimate = state.candidates[state.chosen], loop.estimate
    plan, observer, charge = candidate.plan, candidate.observer, state.given_uc
    if charge.size:
        charge = charge_room(mpc.horizon_charge_max_uc, charge, plan, state.fallback.planned,
                             estimate.strength, state.table)
    vectors = plan.vectors()
    fault = pose(
        observer.ladder, observer.c, observer.offset, gain, estimate.x, estimate.disturbance,
        estimate.strength, estimate.stamps, estimate.inputs, observer.period_ns, observer.delay_ns,
        estimate.at_ns, captured_ns, now_ns, cast(Array, sample.value), plan.free, plan.rows, plan.boxes,
        state.reach, mpc.slew, state.table, 1e-6 * mpc.charge_rise_uc, charge, loop.drive, loop.pulses,
        reference, *vectors)
    if fault != NOT_FINITE:
        estimate.at_ns = max(estimate.at_ns, captured_ns)
    return Posed(*vectors, fault)
