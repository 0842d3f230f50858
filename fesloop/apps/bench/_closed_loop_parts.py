"""Beside a closed loop in its bench: bare MuJoCo under the same activations, and a clock for each node."""

from __future__ import annotations

import gc
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from time import thread_time, thread_time_ns
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from fesloop.experiment.experiment import Experiment
from fesloop.experiment.recording.writing import RecordingWriter
from fesloop.loop.block import Context
from fesloop.loop.clock import NS_PER_S
from fesloop.loop.record import Recorder
from fesloop.loop.run import Loop
from fesloop.loop.wiring import Wiring

Array = NDArray[np.float64]
_TIMED = ("step", "advance", "advance_through", "read", "glance", "observe")
"""Members of blocks and plants that the loop calls as it runs."""


def recorded_loop(experiment: Experiment, wiring: Wiring | None = None) -> tuple[Loop, Recorder, float]:
    """A loop gone through the experiment's time, what was recorded of it, and how long it took, s."""
    recorder = Recorder(experiment.record.plant_rate)
    loop = Loop(wiring or experiment.wiring, recorder=recorder)
    gc.disable()  # an experiment collects so rarely that it costs nothing
    started = thread_time()
    loop.run_until(experiment.duration_ns - 1)
    took = thread_time() - started
    gc.enable()
    return loop, recorder, took


def file_s(experiment: Experiment, seen: Recorder, folder: Path) -> float:
    """Time to write what was recorded into a file, s."""
    writer = RecordingWriter(folder, experiment)
    started = thread_time()
    writer.write(seen, 0)
    took = thread_time() - started
    writer.close("done", took)
    return took


class BareHand:
    """MuJoCo alone, taking the steps that the plant `hand` of a loop took.

    Parameters
    ----------
    loop: gone through its time. seen: what was recorded of it.
    """

    def __init__(self, loop: Loop, seen: Recorder) -> None:
        plant: Any = next(node.plant for node in loop.wiring.nodes if node.name == "hand")
        self.model, grid = plant.model, plant.grid
        self._start = plant.init(Context("hand")).data.qpos.copy()
        steps = loop.states()["hand"].time_ns // grid.period_num
        times = np.arange(steps) * grid.period_num
        rows = [row for row in seen.inputs["hand"] if row[1] == 0]
        newest = np.searchsorted([row[0] for row in rows], times, side="right") - 1
        resting = np.zeros_like(rows[0][4])
        self._activations = [rows[k][4] if k >= 0 else resting for k in newest]
        self._heights = None if plant.table is None else [
            plant.table.height_m - 0.005 - plant.table.drop(int(now)) for now in times]
        self._data = mujoco.MjData(self.model)

    def run_s(self) -> float:
        """Time of all steps, s."""
        model, data = self.model, mujoco.MjData(self.model)
        data.qpos[:len(self._start)] = self._start
        drive, heights = data.ctrl[:self._activations[0].size], self._heights
        started = thread_time()
        for k, activation in enumerate(self._activations):
            drive[:] = activation
            if heights is not None:
                data.mocap_pos[0, 2] = heights[k]
            mujoco.mj_step(model, data)
        self._data = data
        return thread_time() - started

    def distance(self, loop: Loop) -> float:
        """How far the newest run ended from the loop's hand in any coordinate."""
        return float(np.abs(self._data.qpos - loop.states()["hand"].data.qpos).max())


class _TimedPart:
    """A block or plant that is another one in everything, and adds up how long its calls take."""

    def __init__(self, part: Any) -> None:
        self._part = part
        self.spent_ns = 0
        for name in _TIMED:
            if hasattr(part, name):
                setattr(self, name, self._timed(getattr(part, name)))

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return getattr(self._part, name)

    def _timed(self, call: Callable[..., Any]) -> Callable[..., Any]:
        def timed(*given: Any) -> Any:
            began = thread_time_ns()
            outcome = call(*given)
            self.spent_ns += thread_time_ns() - began
            return outcome
        return timed


def parts_s(experiment: Experiment) -> dict[str, float]:
    """Time of each node's own calls over the experiment's time, s, by its name."""
    wiring = experiment.wiring
    timed = {node.name: _TimedPart(node.part) for node in wiring.nodes}
    nodes = [replace(node, part=timed[node.name]) for node in wiring.nodes]
    wires = [connection.wire for connection in wiring.connections]
    recorded_loop(experiment, Wiring(nodes, wires, wiring.seed))
    return {name: part.spent_ns / NS_PER_S for name, part in timed.items()}
