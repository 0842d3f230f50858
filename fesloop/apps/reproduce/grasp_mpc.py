"""`fesloop reproduce grasp_mpc`: effect of a tracker's latency on a grasp under predictive control.

Members of a cohort of `sci_c6`, on whom nothing was tuned, are identified through the tracker and then grasp
a cylinder once at every latency, in the whole loop: inertial sensors, tracker, safety, stimulator. The tables
show the errors of wrist and fingers before contact, whether the cylinder was held, and the latency at which a
patient no longer holds it or an error has doubled. A patient who fails counts as one who did not hold, with
infinite error.
"""

from __future__ import annotations

import math
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.apps.reproduce.cohort import Progress, run_jobs
from fesloop.apps.reproduce.comparison import Row
from fesloop.apps.reproduce.patient_session import Kept, Session
from fesloop.apps.reproduce.result import Reproduction, Sweep
from fesloop.errors import InputError, RunError
from fesloop.experiment.metrics.scoring import metrics_of
from fesloop.experiment.recording.reading import Recording

Array = NDArray[np.float64]
SUBJECTS = 10
COHORT = 2
"""Pilots were members of cohort 1 and the presets."""
SEED = 1
LATENCIES_MS = (0.0, 20.0, 40.0, 60.0, 80.0, 100.0, 125.0, 150.0)
HELD_AT_MS, HELD_SHARE = 40.0, 0.8
LATE_MS, DEARER = 100.0, 1.3
"""Latency of the claim, ms, and the largest ratio of errors there to those at zero latency."""
DOUBLED = 2.0
ROWS = {"wrist": "wrist_extension", "fingers": "finger_flexion"}


def grasp(session: Session, folder: Path, latencies_ms: tuple[float, ...] = LATENCIES_MS) -> Kept:
    """Run one patient's session: identification, then a grasp at every latency; failures are reported."""
    model = session.identified("identify_grasp", folder)
    return {"runs": [grasped(session, model, latency, folder) for latency in latencies_ms]}


def grasped(session: Session, model: Path, latency_ms: float, folder: Path) -> dict[str, Any]:
    """Run one grasp: RMSE before contact of `wrist` and `fingers`, deg; `held`; `margin`; `failed`."""
    try:
        experiment = session.load("grasp_mpc", (f"model={model}", f"tracker_latency_ms={latency_ms:g}"))
        with Recording(session.ran(experiment, folder)) as recording:
            found = metrics_of(recording)
    except (InputError, RunError) as fault:
        return {"failed": str(fault), "held": False, "margin": 0.0, **dict.fromkeys(ROWS, math.inf)}
    return {"failed": "", "held": bool(found["held"][0]), "margin": float(found["grip_margin"][0]),
            **{name: float(found["joints"][row]["joint_rmse_deg"][0]) for name, row in ROWS.items()}}


def run(subjects: int = SUBJECTS, workers: int = 1, progress: Progress | None = None,
        latencies_ms: tuple[float, ...] = LATENCIES_MS) -> Reproduction:
    """Run every patient at every latency."""
    steps = partial(grasp, latencies_ms=latencies_ms)
    sessions = [Session((member,), ("patient=sci_c6", f"cohort={COHORT}", f"member={member}"), SEED, steps)
                for member in range(subjects)]
    kept = run_jobs(sessions, workers, progress)
    return compare([kept[session.key] for session in sessions], latencies_ms)


def compare(patients: list[Kept], latencies_ms: tuple[float, ...] = LATENCIES_MS) -> Reproduction:
    """Make rows and curves from the patients' sessions."""
    lost = {"held": False, "margin": 0.0, **dict.fromkeys(ROWS, math.inf)}
    runs = [patient.get("runs") or [lost] * len(latencies_ms) for patient in patients]
    held = np.array([[run["held"] for run in each] for each in runs])
    errors = {name: np.array([[run[name] for run in each] for each in runs]) for name in ROWS}
    rows = [_row_held(held, latencies_ms), *_rows_dearer(errors, latencies_ms),
            *_rows_failed(patients, latencies_ms)]
    curve = partial(_curve, latencies_ms)
    sweeps = {name: curve(f"{name.capitalize()} before contact", "deg RMSE", values, "median",
                          np.median(values, axis=0)) for name, values in errors.items()}
    sweeps["held"] = curve("Cylinder held", "1: yes", held.astype(float), "patients", held.sum(axis=0))
    sweeps["failure"] = _points(held, errors, latencies_ms)
    return Reproduction("grasp_mpc", len(patients), rows, sweeps, {
        "latencies_ms": latencies_ms, "held": held, "errors": errors})


def point_of_failure(held: NDArray[np.bool_], latencies_ms: tuple[float, ...]) -> float:
    """Least latency from which on the object is not held, ms; NaN if it is held at the last."""
    kept = np.flatnonzero(held)
    first = int(kept[-1]) + 1 if kept.size else 0
    return latencies_ms[first] if first < len(latencies_ms) else math.nan


def point_of_doubling(errors: Array, latencies_ms: tuple[float, ...]) -> float:
    """Least latency at which an error (latencies,) is twice the first, ms; NaN if there is none."""
    far = np.flatnonzero(~(errors < DOUBLED * errors[0]))
    return latencies_ms[int(far[0])] if far.size else math.nan


def _row_held(held: NDArray[np.bool_], latencies_ms: tuple[float, ...]) -> Row:
    patients = len(held)
    least = math.ceil(HELD_SHARE * patients)
    count = int(held[:, latencies_ms.index(HELD_AT_MS)].sum())
    return Row("grasp", f"held at {HELD_AT_MS:g} ms", f"{least} of {patients}", f"{count} of {patients}",
               count >= least)


def _rows_dearer(errors: dict[str, Array], latencies_ms: tuple[float, ...]) -> list[Row]:
    """Rows of the errors at a known latency: median over all patients, with failures as infinite."""
    if LATE_MS not in latencies_ms:
        return []
    rows, late = [], latencies_ms.index(LATE_MS)
    for name, values in errors.items():
        sound = np.isfinite(values[:, 0]) & np.isfinite(values[:, late])
        ratio = np.full(len(values), np.inf)
        ratio[sound] = values[sound, late] / values[sound, 0]
        middle = float(np.sort(ratio)[len(ratio) // 2])
        rows.append(Row(name, f"error at {LATE_MS:g} ms over that at 0 ms, median; at most", DEARER,
                        f"{middle:.2f} ({int((~sound).sum())} of {len(values)} failed)", middle <= DEARER))
    return rows


def _rows_failed(patients: list[Kept], latencies_ms: tuple[float, ...]) -> list[Row]:
    """Rows of patients who could not be identified and of runs that failed, with reasons."""
    rows = [Row(f"member {number}", "identified", "yes", patient["failed"], False)
            for number, patient in enumerate(patients) if patient["failed"]]
    return rows + [Row(f"member {number}", f"run to its end at {latency:g} ms", "yes", run["failed"], False)
                   for number, patient in enumerate(patients)
                   for latency, run in zip(latencies_ms, patient.get("runs", ()), strict=False)
                   if run["failed"]]


def _curve(latencies_ms: tuple[float, ...], title: str, unit: str, values: Array, last: str,
           summary: Array) -> Sweep:
    """Make a row for each patient, and one for all."""
    rows = [(f"member {number}", row) for number, row in enumerate(values)]
    return Sweep(title=title, unit=unit, columns=tuple(f"{latency:g} ms" for latency in latencies_ms),
                 rows=tuple((name, tuple(map(float, row))) for name, row in [*rows, (last, summary)]))


def _points(held: NDArray[np.bool_], errors: dict[str, Array], latencies_ms: tuple[float, ...]) -> Sweep:
    """Make a table of the latencies at which each patient fails."""
    rows = [(f"member {number}", (point_of_failure(row, latencies_ms), *(
        point_of_doubling(values[number], latencies_ms) for values in errors.values())))
        for number, row in enumerate(held)]
    return Sweep(title="Latency from which on nothing is held, and at which errors have doubled",
                 unit="ms, nan: none", columns=("held no longer", *(f"{name} doubled" for name in errors)),
                 rows=tuple(rows))
