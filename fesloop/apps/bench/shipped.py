"""`fesloop bench shipped`: run time of every shipped experiment, compared with that in its file (`takes_s`).

A row for each experiment: `fesloop run NAME` once in a fresh process, in microseconds; `ratio` is relative to
the file's time. It is CPU time, which equals wall time on a free core, since a run has one thread; in real
time it is wall time. Compilation counts. Experiments whose input or extra is missing are left out; `short`
leaves out those that take more than 10 s.
"""

from __future__ import annotations

import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from typing import Any

from fesloop.errors import RunError
from fesloop.experiment.files.layout import Guide, guide_of
from fesloop.experiment.files.parse import read
from fesloop.experiment.files.source import shipped

_SHORT_S = 10.0
_INPUTS = {"a recording", "a run", "an error process", "a live stream"}
_DONE, _BAD_INPUT = 0, 2


def run(short: bool = False, progress: Callable[[float], None] | None = None) -> dict[str, Any]:
    """Make a row for each experiment."""
    told = ((name, guide_of(read(name)[1])) for name in shipped())
    guides = {name: guide for name, guide in told if guide is not None
              and not _INPUTS.intersection(guide.needs) and (not short or guide.takes_s <= _SHORT_S)}
    rows = []
    for number, (name, guide) in enumerate(guides.items()):
        took_s = seconds_of(name, guide)
        if took_s is not None:
            rows.append(_row(name, took_s, guide.takes_s))
        if progress:
            progress((number + 1) / len(guides))
    return {"bench": "shipped", "rows": rows}


def seconds_of(name: str, guide: Guide) -> float | None:
    """Time of `fesloop run NAME`, s; None if something it needs is missing. Raises RunError if it fails."""
    paced = "real time" in guide.needs
    with tempfile.TemporaryDirectory(prefix="fesloop-bench-") as folder:
        command = [sys.executable, "-m", "fesloop", "run", name, "--out", folder]
        began, before = time.perf_counter(), resource.getrusage(resource.RUSAGE_CHILDREN)
        done = subprocess.run([*command, *(["--realtime"] if paced else [])], capture_output=True, text=True,
                              check=False)
        wall_s, after = time.perf_counter() - began, resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode == _BAD_INPUT:
        return None
    if done.returncode != _DONE:
        raise RunError(f"fesloop run {name}: {done.stderr.strip()}")
    return wall_s if paced else after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime


def _row(name: str, took_s: float, stated_s: float) -> dict[str, Any]:
    took_us = 1e6 * took_s
    return {"case": name, "us_median": took_us, "us_p99": took_us, "us_worst": took_us,
            "reference": "the file", "reference_us_median": 1e6 * stated_s, "ratio": took_s / stated_s}
