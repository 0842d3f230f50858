"""What the hand remembers: MuJoCo's own data, stepped and read so that reading changes nothing."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(slots=True, eq=False)
class HandState:
    """Where the hand is.

    Attributes
    ----------
    data: MuJoCo's, of the instant `time_ns`; it copies and pickles with all that it holds.
    time_ns: now.
    evaluated: whether all that follows from position and velocity has been computed for now.
    """

    data: mujoco.MjData
    time_ns: int = 0
    evaluated: bool = False


def evaluate(model: mujoco.MjModel, state: HandState) -> None:
    """Compute accelerations and sensors of now, under the activation of the step that led here."""
    if state.evaluated:
        return
    # The solver starts from the last step's answer: with another's it would end a last bit elsewhere.
    start = state.data.qacc_warmstart.copy()
    mujoco.mj_forward(model, state.data)
    state.data.qacc_warmstart[:] = start
    state.evaluated = True


def step(model: mujoco.MjModel, state: HandState) -> None:
    """One fixed step under the activation that stands in the data: `mj_step` without sensors."""
    done = mujoco.mjtStage.mjSTAGE_VEL if state.evaluated else mujoco.mjtStage.mjSTAGE_NONE
    mujoco.mj_forwardSkip(model, state.data, done, 1)
    mujoco.mj_implicit(model, state.data)
    state.evaluated = False
