"""`fesloop bench closed_loop`: real-time factor of the whole hand's closed loop.

Predictive control at 40 Hz, safety, stimulator, electrodes, 29 muscles, the hand, 17 inertial sensors and a
tracker at 100 Hz, and a recording on disk (`closed_loop.toml`): in `free` motion, and in a `grasp` of a
cylinder on a table. A row gives microseconds per simulated millisecond, and `realtime_factor`. The reference
is bare `mj_step` of the same model under the same activations, with the kernel of its tendons; both
alternate, in several fresh processes, and `ratio` is the median of the pairs. `searched_ratio` is to bare
`mj_step` with MuJoCo's own search for contacts, in place of `plants.hand.side_contact`. Times are CPU times
of the thread.

A row's `parts` show where the time goes, us per simulated ms: one part for each node, `loop` for the rest of
the loop, `recording` for the file. Nodes are timed call by call, in separate runs. `max_abs_error` is the
largest difference of a coordinate between loop and bare MuJoCo at the end.
"""

from __future__ import annotations

import copy
import gc
import tempfile
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path
from time import thread_time, thread_time_ns
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from fesloop.experiment.files.parse import from_document, read
from fesloop.experiment.recording.writing import RecordingWriter
from fesloop.experiment.running import Experiment
from fesloop.loop.block import Context
from fesloop.loop.clock import NS_PER_S
from fesloop.loop.machine import one_blas_thread
from fesloop.loop.record import Recorder
from fesloop.loop.run import Loop
from fesloop.loop.wiring import Wiring

Array = NDArray[np.float64]
_TIMED = ("step", "steps_through", "advance", "advance_through", "advance_steps", "read", "glance", "observe")
"""Members of blocks and plants that the loop calls during a run."""


def recorded_loop(experiment: Experiment, wiring: Wiring | None = None) -> tuple[Loop, Recorder, float]:
    """Run an experiment's loop; returns the loop, its records, and the time it took, s."""
    recorder = Recorder(experiment.record.plant_rate)
    loop = Loop(wiring or experiment.wiring, recorder=recorder)
    gc.disable()  # an experiment collects so rarely that it costs nothing
    started = thread_time()
    loop.run_until(experiment.duration_ns - 1)
    took = thread_time() - started
    gc.enable()
    return loop, recorder, took


def file_s(experiment: Experiment, seen: Recorder, folder: Path) -> float:
    """Time to write the records into a file, s."""
    writer = RecordingWriter(folder, experiment)
    started = thread_time()
    writer.write(seen, 0)
    took = thread_time() - started
    writer.close("done", took)
    return took


class BareHand:
    """MuJoCo and the kernel of the tendons alone, with the steps that the plant `hand` of a loop took.

    Parameters
    ----------
    loop: after its run. seen: its records. searched: whether MuJoCo searches for contacts with a cylinder.
    """

    def __init__(self, loop: Loop, seen: Recorder, searched: bool = False) -> None:
        plant: Any = next(node.plant for node in loop.wiring.nodes if node.name == "hand")
        self.model, grid = plant.model, plant.grid
        if searched:
            self.model = copy.copy(plant.model)
            self.model.geom_user[:] = 0.0
        self._pull, start = plant.pull, plant.init(Context("hand")).data
        self._start = start.qpos.copy(), start.userdata.copy()
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
        (data.qpos[:], data.userdata[:]), pull, heights = self._start, self._pull, self._heights
        started = thread_time()
        for k, activation in enumerate(self._activations):
            pull(data, activation)
            if heights is not None:
                data.mocap_pos[0, 2] = heights[k]
            mujoco.mj_step(model, data)
        self._data = data
        return thread_time() - started

    def distance(self, loop: Loop) -> float:
        """Largest difference of a coordinate between the last run and the loop's hand."""
        return float(np.abs(self._data.qpos - loop.states()["hand"].data.qpos).max())


class _TimedPart:
    """A proxy of a block or plant that adds up the time of its calls."""

    def __init__(self, part: Any) -> None:
        self._part = part
        self.spent_ns = 0
        for name in _TIMED:
            if hasattr(part, name):
                setattr(self, name, self._timed(getattr(part, name)))

    def __getattr__(self, name: str) -> Any:
        # The part has been made for its wires: made again, it would no longer be timed.
        if name.startswith("__") or name in ("resolve", "with_sensors"):
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
    """Time of each node's own calls over the experiment, s, by name."""
    wiring = experiment.wiring
    timed = {node.name: _TimedPart(node.part) for node in wiring.nodes}
    nodes = [replace(node, part=timed[node.name]) for node in wiring.nodes]
    wires = [connection.wire for connection in wiring.connections]
    recorded_loop(experiment, Wiring(nodes, wires, wiring.seed))
    return {name: part.spent_ns / NS_PER_S for name, part in timed.items()}


CASES = {"free": ("constrained", False), "grasp": ("constrained", True),
         "free, salchow_m2": ("salchow_m2", False), "grasp, salchow_m2": ("salchow_m2", True)}
"""Tracker, and whether there are a cylinder and a table."""
_FOLDER = Path(__file__).parent


def experiment(case: str, duration_s: float) -> Experiment:
    """Closed loop of a case."""
    name, document = read(_FOLDER / "closed_loop.toml")
    tracker, grasping = CASES[case]
    blocks = document["blocks"]
    document["experiment"]["duration_s"] = duration_s
    blocks["controller"]["model"]["file"] = str(_FOLDER / blocks["controller"]["model"]["file"])
    blocks["tracker"]["kind"] = tracker
    if not grasping:
        del blocks["hand"]["object"], blocks["hand"]["table"]
    del document["score"]
    return from_document(document, name)


def run(
    repeats: int = 1, processes: int = 3, duration_s: float = 10.0,
    progress: Callable[[float], None] | None = None,
) -> dict[str, Any]:
    """Make a row for each case from several fresh processes; `realtime_factor` is the median of each case."""
    turns = [(case, i) for i in range(processes) for case in CASES]
    measured: dict[str, list[dict[str, Any]]] = {case: [] for case in CASES}
    with ProcessPoolExecutor(1, mp_context=get_context("spawn"), max_tasks_per_child=1) as pool:
        for number, (case, _) in enumerate(turns):
            measured[case].append(pool.submit(measure, case, repeats, duration_s).result())
            if progress:
                progress((number + 1) / len(turns))
    rows = [_row(case, several, duration_s) for case, several in measured.items()]
    return {"bench": "closed_loop", "rows": rows,
            "max_abs_error": max(each["error"] for several in measured.values() for each in several),
            "realtime_factor": {row["case"]: row["realtime_factor"] for row in rows}}


@one_blas_thread()  # as a run
def measure(case: str, repeats: int, duration_s: float) -> dict[str, Any]:
    """Times (repeats, 3), s: of the loop with its recording, of bare MuJoCo, and of it with its own search.

    And the time of each part, and the error.
    """
    this = experiment(case, duration_s)
    loop, seen, _ = recorded_loop(this)  # compiles what is not yet compiled
    bare, searched = BareHand(loop, seen), BareHand(loop, seen, searched=True)
    times, parts = np.empty((repeats, 3)), parts_s(this)
    with tempfile.TemporaryDirectory(prefix="fesloop-bench-") as folder:
        file_s(this, seen, Path(folder))  # loads what writing needs
        for i in range(repeats):
            loop, seen, loop_s = recorded_loop(this)
            written_s = file_s(this, seen, Path(folder))
            times[i] = loop_s + written_s, bare.run_s(), searched.run_s()
    parts |= {"loop": loop_s - sum(parts.values()), "recording": written_s}
    return {"times": times, "parts": parts, "error": bare.distance(loop)}


def _row(case: str, several: list[dict[str, Any]], duration_s: float) -> dict[str, Any]:
    """Row of the table from the measurements of all processes."""
    times = np.concatenate([each["times"] for each in several]) * (1e3 / duration_s)
    ours, bare, searched = times.T
    parts = {name: float(np.median([each["parts"][name] for each in several])) * (1e3 / duration_s)
             for name in several[0]["parts"]}
    return {"case": case, "us_median": float(np.median(ours)), "us_p99": float(np.percentile(ours, 99)),
            "us_worst": float(ours.max()), "reference": "bare mj_step",
            "reference_us_median": float(np.median(bare)), "ratio": float(np.median(ours / bare)),
            "searched_us_median": float(np.median(searched)),
            "searched_ratio": float(np.median(ours / searched)),
            "realtime_factor": 1e3 / float(np.median(ours)),
            "parts": dict(sorted(parts.items(), key=lambda part: -part[1]))}
