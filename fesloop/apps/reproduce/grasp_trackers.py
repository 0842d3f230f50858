"""`fesloop reproduce grasp_trackers`: share of the tracker in the error of a learnt grasp.

Members of a cohort of `sci_c6` learn `grasp_ilc` with one tracker after the other, each with the model
identified through the experiment's own tracker. The true error (total) in trial 8 before contact is split
into the tracker's error, which the controller could not see, and the error that it saw and did not correct
(controller).
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from fesloop.apps.reproduce.cohort import Progress, run_jobs
from fesloop.apps.reproduce.comparison import Row, band
from fesloop.apps.reproduce.patient_session import Kept, Session, sessions
from fesloop.apps.reproduce.result import Reproduction, Sweep
from fesloop.experiment.metrics.scoring import metrics_of
from fesloop.experiment.recording.reading import Recording

SUBJECTS = 5
TRACKERS = ("ideal", "salchow_m2", "constrained", "kortier")
NEAR_DEG = 1.0
"""Largest excess over the error with an ideal tracker, deg (chosen: error of a goniometer)."""
_PARTS = ("total", "tracker", "controller")


def learn(session: Session, folder: Path) -> Kept:
    """Run one patient with every tracker: errors of the last trial by part, deg, and whether it is held."""
    file = session.identified("identify_grasp", folder)
    kept: Kept = {}
    for tracker in TRACKERS:
        experiment = session.load("grasp_ilc", (f"model={file}", f"tracker={tracker}"))
        with Recording(session.ran(experiment, folder)) as recording:
            metrics = metrics_of(recording)
        kept[tracker] = {part: metrics["split_rmse_deg"][part][-1] for part in _PARTS}
        kept[tracker]["held"] = float(bool(metrics["held"][-1]))
    return kept


def run(subjects: int = SUBJECTS, workers: int = 1, progress: Progress | None = None) -> Reproduction:
    """Run every patient with every tracker."""
    patients = sessions(subjects, learn)
    kept = run_jobs(patients, workers, progress)
    return compare([kept[session.key] for session in patients])


def compare(patients: list[Kept]) -> Reproduction:
    """Make rows of medians over patients; errors of one who failed are infinite."""
    lost = {**dict.fromkeys(_PARTS, math.inf), "held": 0.0}
    every = {tracker: [lost if kept["failed"] else kept[tracker] for kept in patients]
             for tracker in TRACKERS}
    table = Sweep(
        title="Error before contact, trial 8, median over patients, and patients who hold", unit="deg",
        columns=(*_PARTS, "held"), rows=tuple(
            (tracker, (*(_median(rows, part) for part in _PARTS), sum(one["held"] for one in rows)))
            for tracker, rows in every.items()))
    ideal = _median(every["ideal"], "total")
    rows = [Row("trackers", f"{tracker}: total error; beside it that of an ideal one", ideal,
                band([one["total"] for one in every[tracker]]),
                math.isfinite(ideal) and _median(every[tracker], "total") <= ideal + NEAR_DEG, "deg")
            for tracker in TRACKERS[1:]]
    return Reproduction("grasp_trackers", len(patients), rows, {"trackers": table}, {"patients": patients})


def _median(patients: list[Kept], part: str) -> float:
    return float(np.median([patient[part] for patient in patients]))
