"""A hand left to itself before the start: worked out once in a process for the same hand, and kept."""

from __future__ import annotations

from functools import lru_cache

import mujoco
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
_KEPT = 32
"""Hands that are kept, the last used (chosen: .1 MB each)."""
_STATE = mujoco.mjtState.mjSTATE_INTEGRATION
"""All from which MuJoCo goes on as if it had never stopped, to the last bit."""


def settled(model: mujoco.MjModel, positions: Array, steps: int) -> mujoco.MjData:
    """Data of a model `steps` after all of it was at rest at `positions` (nq,), its time set back to 0.

    The data are the caller's own.
    """
    data = mujoco.MjData(model)
    if not steps:
        data.qpos[:] = positions
        return data
    content = np.empty(mujoco.mj_sizeModel(model), np.uint8)
    mujoco.mj_saveModel(model, None, content)
    state = _settled_state(content.tobytes(), positions.tobytes(), steps)
    mujoco.mj_setState(model, data, np.frombuffer(state), _STATE)
    return data


@lru_cache(maxsize=_KEPT)
def _settled_state(content: bytes, positions: bytes, steps: int) -> bytes:
    """Of `settled`, what MuJoCo calls the state; of the model all its bytes, so that no two are confused."""
    model = mujoco.MjModel.from_binary_path("hand.mjb", {"hand.mjb": content})
    data = mujoco.MjData(model)
    data.qpos[:] = np.frombuffer(positions)
    for _ in range(steps):
        mujoco.mj_step(model, data)
    data.time = 0.0
    state = np.empty(mujoco.mj_stateSize(model, _STATE))
    mujoco.mj_getState(model, data, state, _STATE)
    return state.tobytes()
