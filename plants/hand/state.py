"""What the hand remembers: MuJoCo's own data, stepped and read so that reading changes nothing."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from fesloop.compiled import compiled
from fesloop.errors import RunError
from fesloop.loop.clock import NS_PER_MS

Array = NDArray[np.float64]

UNSTABLE_RAD_S = 1000.0
"""Chosen: above what joints do (snapping fingers, 140 rad/s: Acharya 2021, doi 10.1098/rsif.2021.0672); of an
object also m/s."""
BEYOND_RAD = math.radians(60.0)
"""Chosen: as far beyond its range no joint is. Full force, all at once, flings one there by up to 45 deg for
some milliseconds, and a quarter as far with a tenth of the usual step."""


_POSITION_AND_VELOCITY, _NOTHING = mujoco.mjtStage.mjSTAGE_VEL, mujoco.mjtStage.mjSTAGE_NONE


class Views(NamedTuple):
    """MuJoCo's own memory, as its data name it: to ask the data for an array costs as much as to use it."""

    ctrl: Array
    qpos: Array
    qvel: Array
    qacc: Array
    qacc_warmstart: Array
    mocap_pos: Array
    xpos: Array
    xquat: Array
    xmat: Array
    site_xpos: Array
    sensordata: Array


@dataclass(slots=True, eq=False)
class HandState:
    """Where the hand is.

    Attributes
    ----------
    data: MuJoCo's, of the instant `time_ns`; it copies and pickles with all that it holds.
    time_ns: now.
    evaluated: whether all that follows from position and velocity has been computed for now.
    forearm: the orientation that its drive was last told; None before.
    given: whether the object, if any, is where it is to be grasped.
    views: into the data; made anew for a copy's own.
    """

    data: mujoco.MjData
    time_ns: int = 0
    evaluated: bool = False
    forearm: Array | None = None
    given: bool = True
    views: Views = field(init=False, repr=False)

    def __post_init__(self) -> None:
        self.views = Views(*(getattr(self.data, name) for name in Views._fields))

    def __getstate__(self) -> tuple[Any, ...]:
        return self.data, self.time_ns, self.evaluated, self.forearm, self.given

    def __setstate__(self, saved: tuple[Any, ...]) -> None:
        self.data, self.time_ns, self.evaluated, self.forearm, self.given = saved
        self.__post_init__()


def evaluate(model: mujoco.MjModel, state: HandState) -> None:
    """Compute accelerations and sensors of now, under the activation of the step that led here."""
    if state.evaluated:
        return
    # The solver starts from the last step's answer: with another's it would end a last bit elsewhere.
    start = state.views.qacc_warmstart.copy()
    mujoco.mj_forward(model, state.data)
    state.views.qacc_warmstart[:] = start
    state.evaluated = True


def step(model: mujoco.MjModel, state: HandState) -> None:
    """One fixed step under the activation that stands in the data: `mj_step` without sensors."""
    mujoco.mj_forwardSkip(model, state.data, _POSITION_AND_VELOCITY if state.evaluated else _NOTHING, 1)
    mujoco.mj_implicit(model, state.data)
    state.evaluated = False


@compiled
def find_unstable(angles: Array, speeds: Array, low: Array, high: Array) -> int:
    """Number of the fastest freedom if it is too fast, or of the first hinge outside its bounds; -1: none.

    `angles` (positions,) holds the hinges first, `speeds` (v,), `low` and `high` (hinges,).
    """
    fastest, found = UNSTABLE_RAD_S, -1
    for i in range(speeds.size):
        if math.isnan(speeds[i]):
            return i
        if abs(speeds[i]) >= fastest:
            fastest, found = abs(speeds[i]), i
    if found >= 0:
        return found
    for i in range(low.size):
        if not low[i] < angles[i] < high[i]:
            return i
    return -1


def stable_bounds(model: mujoco.MjModel) -> tuple[Array, Array]:
    """Least and greatest angle of each hinge, (h,) each, rad, that a stable simulation stays within."""
    hinges = model.jnt_type == mujoco.mjtJoint.mjJNT_HINGE
    reach = np.where(model.jnt_limited[hinges] > 0, BEYOND_RAD, np.inf)
    low, high = model.jnt_range[hinges].T
    return low - reach, high + reach


def require_stable(model: mujoco.MjModel, bounds: tuple[Array, Array], state: HandState) -> None:
    """Raise RunError, naming the joint, where the hand moves as no hand does; `bounds`: `stable_bounds`."""
    angles, speeds = state.views.qpos, state.views.qvel
    worst = find_unstable(angles, speeds, bounds[0], bounds[1])
    if worst < 0:
        return
    name = model.joint(int(model.dof_jntid[worst])).name
    told = f"moves at {abs(speeds[worst]):.3g} rad/s or m/s"
    if abs(speeds[worst]) < UNSTABLE_RAD_S:
        told = f"is at {math.degrees(angles[worst]):.3g} deg, far beyond its range"
    raise RunError(f"hand became unstable at {state.time_ns / NS_PER_MS:g} ms: {name} {told}; take a smaller "
                   "step_ms, or weaker muscles and springs")
