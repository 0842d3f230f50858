"""`fesloop bench hand`: the hand plant compared with bare `mj_step` of the same model; and the electrodes.

`free` and `grasp` give microseconds per simulated millisecond. Plant and MuJoCo simulate the same motion,
both with the kernel of the tendons, alternating every 10 ms, so that other load affects both; after each
10 ms the plant is read, as by sensors at 100 Hz. `max_abs_error` is the largest difference of a coordinate at
the end.

`electrodes` gives microseconds for one pulse of all elements at once, from currents to recruitment and
frequency of every muscle; `electrodes, field made anew` the same after a rotation of the forearm, when the
field of every element at every axon is computed again. They have no bare counterpart.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Callable
from time import perf_counter_ns
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from fesloop.experiment import registry
from fesloop.forms.schema import make
from fesloop.hand.movements import MUSCLES
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_MS, RateClock
from fesloop.loop.signals import Sample

Array = NDArray[np.float64]
TURNS, TURN_MS, WARM_UP = 600, 10, 150
"""Turns of 10 ms in each case, and those at the start that are not counted, while the hand closes."""
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
PULSES, PULSES_WARM_UP, SLOT_RATE = 400, 20, 320
"""Pulses in each case of the electrodes, those at the start that are not counted, and slots a second."""
PULSE = (20e-3, 300e-6, 40.0)
"""Pulse of every element: A, s, Hz."""


def run(turns: int = TURNS, progress: Callable[[float], None] | None = None) -> dict[str, Any]:
    """Make a row for each case."""
    rows, error = [], 0.0
    for number, (case, parameters) in enumerate(CASES.items()):
        if progress:
            progress(number / (len(CASES) + 1))
        times, apart = _measured(make(registry.find("hand"), parameters, {}, "hand"), turns)
        ours, bare = times[min(WARM_UP, turns // 2):].T
        error = max(error, apart)
        rows.append(_row(case, ours, "bare mj_step", float(np.median(bare))))
    if progress:
        progress(len(CASES) / (len(CASES) + 1))
    rows += [_row("electrodes", _pulse_times(turning=False)),
             _row("electrodes, field made anew", _pulse_times(turning=True))]
    return {"bench": "hand", "rows": rows, "max_abs_error": error}


def _row(case: str, times: Array, reference: str | None = None, bare: float | None = None) -> dict[str, Any]:
    """Row of the table from times, us, and the median of the reference, if there is one."""
    return {"case": case, "us_median": float(np.median(times)), "us_p99": float(np.percentile(times, 99)),
            "us_worst": float(times.max()), "reference": reference, "reference_us_median": bare,
            "ratio": float(np.median(times)) / bare if bare is not None else None}


def _pulse_times(turning: bool) -> Array:
    """Times (n,), us, of a pulse of all elements; `turning`: the forearm turns 2 deg before each."""
    electrodes = registry.find("electrodes")()
    clock, tick = RateClock.from_rate(SLOT_RATE), Tick()
    state = electrodes.init(Context("electrodes", clock=clock))
    slots = SLOT_RATE // round(PULSE[2])
    pulses, times = np.tile(PULSE, (electrodes.elements, 1)), np.empty(PULSES)
    for k in range(PULSES):
        tick.index, tick.time_ns = k * slots, clock.tick(k * slots)
        posture = math.radians(2.0 * (k % 2)) if turning else 0.0
        inputs = [Sample(value, tick.time_ns, tick.time_ns, tick.time_ns)
                  for value in (pulses, posture, np.ones(electrodes.elements), np.zeros(2))]
        started = perf_counter_ns()
        electrodes.step(state, inputs, tick)
        times[k] = perf_counter_ns() - started
    return times[PULSES_WARM_UP:] / 1e3


def _measured(plant: Any, turns: int) -> tuple[Array, float]:
    """Times of plant and bare MuJoCo, (turns, 2), us per simulated ms; their difference at the end."""
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
        for _ in range(steps):
            plant.pull(data, inputs[0])
            mujoco.mj_step(model, data)
        times[k] = between - started, perf_counter_ns() - between
    return times / (1e3 * TURN_MS), float(np.abs(data.qpos - state.data.qpos).max())
