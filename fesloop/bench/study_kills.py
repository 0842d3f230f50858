"""`fesloop bench study_kills`: what comes of a study some of whose processes are killed.

A row a victim, SIGKILL being sent at random moments of the study, from its start to its usual end: a worker,
the coordinator, both, the scheduler of a cluster that was started by hand. Started again where it ended, the
study must end with each result once, equal to the undisturbed study's bit for bit: `identical` says of how
many moments that is true, `moments_s` when they were, `exit_codes` how often it was started. Times are those
of the whole study with its restarts, `reference` that of the undisturbed one.
"""

from __future__ import annotations

import random
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from fesloop.bench._disturbed_study import VICTIMS, DisturbedStudy
from fesloop.study.results.study_results import load

NAME = "killed"
_STUDY = """
[study]
name = "{name}"
experiment = "finger_pid_latency"
replicates = {replicates}
metrics = {{ error_deg = "joint_rmse_deg", seen_deg = "tracker_rmse_deg" }}

[axes.latency_ms]
from = 0
to = 110
count = 12
"""


def run(moments: int = 5, replicates: int = 8, seed: int | None = None,
        progress: Callable[[float], None] | None = None) -> dict[str, Any]:
    """One row a victim; `seed` of the moments, None for new ones each time."""
    chance = random.Random(seed)
    with tempfile.TemporaryDirectory(prefix="fesloop-bench-") as folder:
        study = Path(folder) / "study.toml"
        study.write_text(_STUDY.format(name=NAME, replicates=replicates))
        whole = {by_hand: _undisturbed(study, Path(folder) / f"whole-{by_hand}", by_hand)
                 for by_hand in (False, True)}
        rows = []
        for number, victim in enumerate(VICTIMS):
            by_hand = victim == "scheduler"
            digest, usual_s = whole[by_hand]
            tries = []
            for i in range(moments):
                after_s = chance.uniform(0.0, usual_s)
                tries.append(_disturbed(study, Path(folder) / f"{victim}-{i}", victim, by_hand, after_s))
                if progress:
                    progress((number + (i + 1) / moments) / len(VICTIMS))
            rows.append(_row(victim, tries, digest, usual_s))
    return {"bench": "study_kills", "rows": rows, "same_on_both_clusters": whole[False][0] == whole[True][0]}


def _undisturbed(study: Path, out: Path, by_hand: bool) -> tuple[str, float]:
    """Digest of the results, and how long they took."""
    began = time.perf_counter()
    DisturbedStudy(study, out / "results", by_hand=by_hand).to_its_end()
    return load(out / "results" / NAME).digest(), time.perf_counter() - began


def _disturbed(study: Path, out: Path, victim: str, by_hand: bool, after_s: float) -> dict[str, Any]:
    began = time.perf_counter()
    codes = DisturbedStudy(study, out / "results", by_hand=by_hand).killed(victim, after_s)
    results = load(out / "results" / NAME)
    return {"moment_s": after_s, "exit_codes": codes, "seconds": time.perf_counter() - began,
            "digest": results.digest()}


def _row(victim: str, tries: list[dict[str, Any]], digest: str, usual_s: float) -> dict[str, Any]:
    micros = 1e6 * np.array([each["seconds"] for each in tries])
    return {"case": victim, "us_median": float(np.median(micros)), "us_p99": float(np.percentile(micros, 99)),
            "us_worst": float(micros.max()), "reference": "undisturbed study",
            "reference_us_median": 1e6 * usual_s, "ratio": float(np.median(micros)) / (1e6 * usual_s),
            "identical": f"{sum(each['digest'] == digest for each in tries)} of {len(tries)}",
            "moments_s": [each["moment_s"] for each in tries],
            "exit_codes": [list(each["exit_codes"]) for each in tries]}
