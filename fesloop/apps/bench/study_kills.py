"""`fesloop bench study_kills`: what comes of a study some of whose processes are killed.

A row a victim, SIGKILL being sent at random moments, when so many results stand in the store (`standing`): a
worker, the coordinator, both, the scheduler of a cluster that was started by hand. Started again where it
ended, the study must end with each result once, equal to the undisturbed study's bit for bit: `identical`
says of how many moments that is true, `killed` how many processes were, `exit_codes` how often it was
started. Times are those of the whole study with its restarts, `reference` that of the undisturbed one.
"""

from __future__ import annotations

import random
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from fesloop.analysis.study.results.study_results import load
from fesloop.apps.bench._disturbed_study import VICTIMS, DisturbedStudy

NAME, CELLS = "killed", 12
_STUDY = """
[study]
name = "{name}"
experiment = "finger_pid_latency"
replicates = {replicates}
metrics = {{ error_deg = "joint_rmse_deg", seen_deg = "tracker_rmse_deg" }}

[axes.latency_ms]
from = 0
to = 110
count = {cells}
"""


def run(moments: int = 5, replicates: int = 8, seed: int | None = None,
        progress: Callable[[float], None] | None = None) -> dict[str, Any]:
    """One row a victim; `seed` of the moments, None for new ones each time."""
    chance = random.Random(seed)
    with tempfile.TemporaryDirectory(prefix="fesloop-bench-") as folder:
        study = Path(folder) / "study.toml"
        study.write_text(_STUDY.format(name=NAME, replicates=replicates, cells=CELLS))
        whole = {by_hand: _undisturbed(study, Path(folder) / f"whole-{by_hand}", by_hand)
                 for by_hand in (False, True)}
        rows = []
        for number, victim in enumerate(VICTIMS):
            by_hand = victim == "scheduler"
            digest, usual_s = whole[by_hand]
            tries = []
            for i in range(moments):
                results = chance.randrange(1, 3 * CELLS * replicates // 4)
                tries.append(_disturbed(study, Path(folder) / f"{victim}-{i}", victim, by_hand, results))
                if progress:
                    progress((number + (i + 1) / moments) / len(VICTIMS))
            rows.append(_row(victim, tries, digest, usual_s))
    return {"bench": "study_kills", "rows": rows, "same_on_both_clusters": whole[False][0] == whole[True][0]}


def _undisturbed(study: Path, out: Path, by_hand: bool) -> tuple[str, float]:
    """Digest of the results, and how long they took."""
    began = time.perf_counter()
    DisturbedStudy(study, out / "results", by_hand=by_hand).to_its_end()
    return load(out / "results" / NAME).digest(), time.perf_counter() - began


def _disturbed(study: Path, out: Path, victim: str, by_hand: bool, results: int) -> dict[str, Any]:
    began = time.perf_counter()
    killing = DisturbedStudy(study, out / "results", by_hand=by_hand).killed(victim, results)
    seconds = time.perf_counter() - began
    return {"killing": killing, "seconds": seconds, "digest": load(out / "results" / NAME).digest()}


def _row(victim: str, tries: list[dict[str, Any]], digest: str, usual_s: float) -> dict[str, Any]:
    micros = 1e6 * np.array([each["seconds"] for each in tries])
    return {"case": victim, "us_median": float(np.median(micros)), "us_p99": float(np.percentile(micros, 99)),
            "us_worst": float(micros.max()), "reference": "undisturbed study",
            "reference_us_median": 1e6 * usual_s, "ratio": float(np.median(micros)) / (1e6 * usual_s),
            "identical": f"{sum(each['digest'] == digest for each in tries)} of {len(tries)}",
            "killed": [each["killing"].processes for each in tries],
            "standing": [each["killing"].standing for each in tries],
            "exit_codes": [list(each["killing"].exit_codes) for each in tries]}
