"""`fesloop bench closed_loop`: how much faster than real time the whole hand's closed loop runs, all of it.

Predictive control at 40 Hz, safety, stimulator, electrodes, 29 muscles, the hand, 17 inertial sensors and a
tracker at 100 Hz, a recording on disk (`closed_loop.toml`): in `free` motion, and in a `grasp` of a cylinder
on a table. A row gives microseconds per simulated millisecond, and `realtime_factor`. Beside it bare
`mj_step` of the same model under the same activations; both take turns, in several fresh processes, and
`ratio` is the median of such pairs. Times are CPU time of the thread, which is all that runs: what else the
machine does counts less so.

A row's `parts` say where the time goes, us per simulated ms: a part for each node, `loop` for what lies
between them, `recording` for the file. Nodes are timed call by call, in runs of their own. `max_abs_error`
is how far loop and bare MuJoCo end apart in any coordinate.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.apps.bench._closed_loop_parts import BareHand, file_s, parts_s, recorded_loop
from fesloop.experiment.experiment import Experiment
from fesloop.experiment.files.parse import from_document, read

Array = NDArray[np.float64]
CASES = {"free": ("constrained", False), "grasp": ("constrained", True),
         "free, salchow_m2": ("salchow_m2", False), "grasp, salchow_m2": ("salchow_m2", True)}
"""Tracker, and whether there are a cylinder and a table."""
_FOLDER = Path(__file__).parent


def experiment(case: str, duration_s: float) -> Experiment:
    """The closed loop of a case."""
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
    """One row a case, from some fresh processes; `realtime_factor` is the median of each case."""
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


def measure(case: str, repeats: int, duration_s: float) -> dict[str, Any]:
    """Times (repeats, 2), s, of the loop with its recording and of bare MuJoCo; of each part; the `error`."""
    this = experiment(case, duration_s)
    loop, seen, _ = recorded_loop(this)  # compiles what is not yet compiled
    bare = BareHand(loop, seen)
    times, parts = np.empty((repeats, 2)), parts_s(this)
    with tempfile.TemporaryDirectory(prefix="fesloop-bench-") as folder:
        for i in range(repeats):
            loop, seen, loop_s = recorded_loop(this)
            written_s = file_s(this, seen, Path(folder))
            times[i] = loop_s + written_s, bare.run_s()
    parts |= {"loop": loop_s - sum(parts.values()), "recording": written_s}
    return {"times": times, "parts": parts, "error": bare.distance(loop)}


def _row(case: str, several: list[dict[str, Any]], duration_s: float) -> dict[str, Any]:
    """A row of the table from what each process measured."""
    times = np.concatenate([each["times"] for each in several]) * (1e3 / duration_s)
    ours, bare = times.T
    parts = {name: float(np.median([each["parts"][name] for each in several])) * (1e3 / duration_s)
             for name in several[0]["parts"]}
    return {"case": case, "us_median": float(np.median(ours)), "us_p99": float(np.percentile(ours, 99)),
            "us_worst": float(ours.max()), "reference": "bare mj_step",
            "reference_us_median": float(np.median(bare)), "ratio": float(np.median(ours / bare)),
            "realtime_factor": 1e3 / float(np.median(ours)),
            "parts": dict(sorted(parts.items(), key=lambda part: -part[1]))}
