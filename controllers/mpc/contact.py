"""Predictive control while the hand touches something: who leads what.

Channels that grasp are planned by the model alone, in a loop of its own that sees nothing after the touch:
how hard they press is how far beyond the object the reference goes. With their drives given, others are
planned by what is seen of the other outputs: a falling wrist is not lifted by fingers that let go.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from controllers.mpc.kernel import give_out
from controllers.mpc.posed import Loop, Posed, posed
from controllers.qp.dense import QpResult
from fesloop.loop.signals import Sample

if TYPE_CHECKING:
    from controllers.mpc.block import Mpc
    from controllers.mpc.state import MpcState

Array = NDArray[np.float64]
_SLACK = 1e-4
"""Drive by which what is given may be missed, so that the programme has an inside (chosen: of no effect)."""


def solve_in_contact(
    mpc: Mpc, state: MpcState, now: Loop, problem: Posed, reference: Array, sample: Sample, captured_ns: int,
    now_ns: int,
) -> QpResult:
    """The optimum of `problem`, with the drives of `grasping_channels` from the model's own loop.

    That loop begins as a copy of `now`; it remembers the drives of its own, which the plant is not given.
    """
    candidate = state.candidates[state.chosen]
    state.alone = alone = state.alone or now.copied()
    still = np.zeros_like(candidate.observer.gain)
    led = candidate.qp.solve_around(
        *posed(mpc, state, alone, still, reference, sample, captured_ns, now_ns))
    if not led.solved:
        return led
    alone.drive = np.minimum(led.x[:alone.drive.size] / alone.estimate.strength, state.reach)
    give_out(state.table, alone.drive, alone.estimate.stamps, alone.estimate.inputs, now_ns, alone.pulses)
    _give(mpc, problem, led.x, alone.drive.size)
    return candidate.qp.solve_around(*problem)


def _give(mpc: Mpc, problem: Posed, led: Array, muscles: int) -> None:
    """Have the problem give `grasping_channels` what they have in `led` (unknowns,), within its bounds."""
    steps = np.arange(mpc.horizon)[:, np.newaxis] * muscles
    given = (steps + np.array(mpc.grasping_channels)).ravel()
    low = np.minimum(np.maximum(led[given] - _SLACK, problem.lower[given]), problem.upper[given])
    problem.lower[given], problem.upper[given] = low, np.minimum(low + 2.0 * _SLACK, problem.upper[given])
    problem.below[given] = problem.lower[given] - problem.best[given]
    problem.above[given] = problem.upper[given] - problem.best[given]
