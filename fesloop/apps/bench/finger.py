"""`fesloop bench finger`: real-time factor of the whole closed finger loop.

Reference, controller, safety, muscles and joints, inertial sensors at 100 Hz, VQF tracker, and a recording
on disk with the plant at 1 kHz. A row gives microseconds of wall time per simulated millisecond.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from importlib.resources import files
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

from fesloop.experiment.files.parse import load
from fesloop.experiment.running import Experiment


def experiments() -> dict[str, Experiment]:
    """Experiments of the cases: `pid`, defined here, and `mpc`, the shipped experiment finger_mpc."""
    return {"pid": load(str(files("fesloop.apps.bench") / "finger_pid.toml")), "mpc": load("finger_mpc")}


def run(
    repeats: int = 4, processes: int = 5, progress: Callable[[float], None] | None = None
) -> dict[str, Any]:
    """Run the cases in turn, in several fresh processes; `realtime_factor` is the median of each case."""
    factors: dict[str, list[float]] = {}
    with ProcessPoolExecutor(1, mp_context=get_context("spawn"), max_tasks_per_child=1) as pool:
        for i in range(processes):
            for name, measured in pool.submit(measure, repeats).result().items():
                factors.setdefault(name, []).extend(measured)
            if progress:
                progress((i + 1) / processes)
    rows = [_row(name, np.array(measured)) for name, measured in factors.items()]
    return {"bench": "finger", "rows": rows,
            "realtime_factor": {name: float(np.median(measured)) for name, measured in factors.items()}}


def measure(repeats: int) -> dict[str, list[float]]:
    """Real-time factors of the cases, run in turn in this process."""
    cases = experiments()
    factors: dict[str, list[float]] = {name: [] for name in cases}
    with tempfile.TemporaryDirectory(prefix="fesloop-bench-") as folder:
        for i in range(repeats + 1):
            for name, experiment in cases.items():
                result = experiment.run(Path(folder))
                if i:  # the first round compiles and warms up
                    factors[name].append(result.realtime_factor)
                result.recording.unlink()
    return factors


def _row(case: str, factors: np.ndarray[Any, np.dtype[np.float64]]) -> dict[str, Any]:
    us = 1000.0 / factors
    return {"case": case, "us_median": float(np.median(us)), "us_p99": float(np.percentile(us, 99)),
            "us_worst": float(us.max()), "reference": None, "reference_us_median": None, "ratio": None}
