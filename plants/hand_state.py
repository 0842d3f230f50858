"""What the hand remembers: MuJoCo's own data, stepped and read so that reading changes nothing."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from fesloop.errors import RunError
from fesloop.loop.clock import NS_PER_MS

Array = NDArray[np.float64]

UNSTABLE_RAD_S = 1000.0
"""Chosen: above what joints do (snapping fingers, 140 rad/s: Acharya 2021, doi 10.1098/rsif.2021.0672); of an
object also m/s."""


@dataclass(slots=True, eq=False)
class HandState:
    """Where the hand is.

    Attributes
    ----------
    data: MuJoCo's, of the instant `time_ns`; it copies and pickles with all that it holds.
    time_ns: now.
    evaluated: whether all that follows from position and velocity has been computed for now.
    forearm: the orientation that its drive was last told; None before.
    """

    data: mujoco.MjData
    time_ns: int = 0
    evaluated: bool = False
    forearm: Array | None = None


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


def require_stable(model: mujoco.MjModel, state: HandState) -> None:
    """Raise RunError, naming the joint, where the hand moves as no hand does."""
    speeds = state.data.qvel
    if speeds.dot(speeds) < UNSTABLE_RAD_S**2:
        return
    sizes = np.abs(speeds)
    worst = int(np.argmax(np.where(np.isfinite(sizes), sizes, np.inf)))
    name = model.joint(int(model.dof_jntid[worst])).name
    raise RunError(f"hand became unstable at {state.time_ns / NS_PER_MS:g} ms: {name} moves at "
                   f"{sizes[worst]:.3g} rad/s or m/s; take a smaller step_ms")
