"""`fesloop bench hand`: the hand plant beside bare `mj_step` of the same model, free and in a grasp.

A row gives microseconds per simulated millisecond. Plant and MuJoCo go through the same motion, taking turns
every 10 ms, so that what else the machine does touches both; at the end of these 10 ms the plant is read, as
sensors at 100 Hz make it. `max_abs_error` is how far the two end apart in any coordinate.
"""

from __future__ import annotations

import copy
from collections.abc import Callable
from time import perf_counter_ns
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from fesloop.experiment import registry
from fesloop.experiment.schema import make
from fesloop.hand.muscles import MUSCLES
from fesloop.loop.block import Context
from fesloop.loop.clock import NS_PER_MS

Array = NDArray[np.float64]
TURNS, TURN_MS, WARM_UP = 600, 10, 150
"""Turns of 10 ms in each case, and those at the start that are not counted: until then the hand closes."""
_OPEN = {**{f"F{i}_{joint}_flexion": angle for i in range(2, 6)
            for joint, angle in (("mcp", 0.0), ("pip", 10.0), ("dip", 5.0))},
         "F1_cmc_flexion": 58.0, "F1_cmc_abduction": -15.0, "F1_cmc_pronation": 80.0, "F1_mcp_flexion": 0.0,
         "F1_ip_flexion": 0.0}
_POSE = {"forearm_orientation": [0.0, 0.0, 0.0, 1.0], "rest_deg": _OPEN,
         "splint_deg": {"wrist_flexion": -20.0, "wrist_abduction": 0.0}}
CASES: dict[str, dict[str, Any]] = {
    "free": _POSE,
    "grasp": {**_POSE, "object": {"size_mm": [50.0, 120.0], "position_m": [-0.008, 0.105, 0.0]},
              "table": {"height_m": -0.0601, "centre_m": [-0.008, 0.105], "half_m": [0.04, 0.04]}}}
"""Parameters of the plant: thumb upwards, wrist splinted, the hand open; then also a cylinder on a table."""


def run(turns: int = TURNS, progress: Callable[[float], None] | None = None) -> dict[str, Any]:
    """One row a case."""
    rows, error = [], 0.0
    for number, (case, parameters) in enumerate(CASES.items()):
        if progress:
            progress(number / len(CASES))
        times, apart = _measured(make(registry.find("hand"), parameters, {}, "hand"), turns)
        ours, bare = times[min(WARM_UP, turns // 2):].T
        error = max(error, apart)
        rows.append({"case": case, "us_median": float(np.median(ours)),
                     "us_p99": float(np.percentile(ours, 99)), "us_worst": float(ours.max()),
                     "reference": "bare mj_step", "reference_us_median": float(np.median(bare)),
                     "ratio": float(np.median(ours) / np.median(bare))})
    return {"bench": "hand", "rows": rows, "max_abs_error": error}


def _measured(plant: Any, turns: int) -> tuple[Array, float]:
    """Times (turns, 2) of plant and bare MuJoCo, us a simulated ms; how far they end apart."""
    state = plant.init(Context("hand"))
    model, data = plant.model, copy.deepcopy(state.data)
    closing = np.array([0.05 * name.startswith(("FDP", "FDS")) + 0.1 * name.startswith(("FPL", "THENAR"))
                        for name in MUSCLES])
    span, steps = TURN_MS * NS_PER_MS, TURN_MS * NS_PER_MS // plant.grid.period_num
    times = np.empty((turns, 2))
    for k in range(turns):
        inputs = [min(1.0, 0.01 * k) * closing]
        started = perf_counter_ns()
        for now in range(k * span, (k + 1) * span, plant.grid.period_num):
            plant.advance(state, inputs, now, now + plant.grid.period_num)
        plant.read(state, inputs)
        between = perf_counter_ns()
        data.ctrl[:] = inputs[0]
        for _ in range(steps):
            mujoco.mj_step(model, data)
        times[k] = between - started, perf_counter_ns() - between
    return times / (1e3 * TURN_MS), float(np.abs(data.qpos - state.data.qpos).max())
