"""`fesloop reproduce grasp_ilc`: a cohort learns to grasp, each patient with an identified model.

Ten members of a cohort of `sci_c6`, on whom nothing was tuned, have one session each: identification through
the tracker, then learning over eight trials (1) in free motion, of a reference that a separate stimulation
produced on the same hand, so that it is reachable; (2) of a cylinder grasp by a therapist's reference; (3) of
the same while all muscles lose 1.5 % of their force from trial to trial. Every run has the patient's own
fatigue, inertial sensors, tracker, safety and stimulator. A patient who fails counts as one who did not learn
and did not hold the cylinder.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.apps.reproduce.cohort import Progress, run_jobs
from fesloop.apps.reproduce.comparison import Row, band
from fesloop.apps.reproduce.patient_session import Kept, Session, sessions
from fesloop.apps.reproduce.reachable import learnt_widths, reachable_floor, reference_course
from fesloop.apps.reproduce.result import Reproduction, Sweep
from fesloop.experiment.metrics.grasp import aperture
from fesloop.experiment.metrics.scoring import metrics_of
from fesloop.experiment.recording.reading import Recording
from fesloop.experiment.running import Experiment
from fesloop.loop.clock import NS_PER_S
from fesloop.loop.noise import NoiseStream, stream_key
from fesloop.models.patient_model import PatientModel, load_patient_model

Array = NDArray[np.float64]
SUBJECTS = 10
WEAR = 0.015
"""Share of force lost from trial to trial in (3)."""
FREE_S = (2.0, 5.5)
"""Length of a trial with a reachable reference."""
_TURNS_S = (2.0, 2.7, 3.4, 4.1, 4.8, 5.5)
_LEVELS = ((0.05, 0.3, 0.3, 0.0, 0.0, 0.0, 0.0, 0.0), (0.3, 0.05, 0.05, 0.25, 0.25, 0.25, 0.25, 0.25))
"""Largest recruitment sampled for the separate stimulation, by channel, while the hand opens (the first two
phases) and closes (chosen to move these hands by some tens of degrees)."""
_OPENING = 2
_FIGURES = ("wrist_extension", "finger_flexion", "aperture", "therapist's reference", "floor", "excess",
            "held", "held, worn", "object moved", "opening", "wrist in the hold", "grip margin",
            "unwanted motion", "charge, uC")
ANGLE_BAR_DEG, APERTURE_BAR_MM, EXCESS_BAR_DEG, HELD_SHARE, WORN_SHARE = 5.0, 10.0, 3.0, 0.8, 0.7


def held_back(model: PatientModel, seed: int) -> tuple[str, ...]:
    """Settings of a random programme of pulse widths, scaled by the patient's recruitment."""
    draws = NoiseStream(stream_key(seed, "held back", 0), len(model.current_ma), "uniform")
    currents = np.array(model.current_ma)
    curves = model.model.recruitment
    assert curves is not None
    widths = [np.zeros(currents.size)]
    for turn in range(1, len(_TURNS_S)):
        fractions = np.array(_LEVELS[turn > _OPENING]) * draws.row(turn)
        us = 1e6 * curves.pulse_width_s(fractions, 1e-3 * currents)
        widths.append(np.where(np.isfinite(us), np.minimum(us, 500.0), 0.0))
    rows = [[float(round(width)) for width in row] for row in widths]
    return ("control=programme", "scene=free", "trials=1", f"blocks.controller.times_s={list(_TURNS_S)}",
            f"blocks.controller.current_ma={[list(model.current_ma)]}", f"blocks.controller.width_us={rows}")


def learn(session: Session, folder: Path) -> Kept:
    """Run one patient's session."""
    file = session.identified("identify_grasp", folder)
    model = load_patient_model(file)
    given = f"model={file}"
    path = session.ran(session.load("grasp_ilc", held_back(model, session.seed)), folder)
    follow = session.load("grasp_ilc", (given, "scene=free", "reference=recorded", f"reference_file={path}",
                                        f"score.until_s={FREE_S[1]}"))
    kept: Kept = {"fit": model.fit["free_run"], "reach": _followed(path, session.ran(follow, folder))}
    for name, extra in (("grasp", ()), ("worn", (f"blocks.muscles.wear_per_trial={WEAR}",))):
        experiment = session.load("grasp_ilc", (given, *extra))
        with Recording(session.ran(experiment, folder)) as recording:
            kept[name] = metrics_of(recording)
            if name == "grasp":
                kept["floor"] = _floor(experiment, recording)
    return kept


def _floor(experiment: Experiment, recording: Recording) -> dict[str, Any]:
    """Least error before contact under any stimulation, deg, and the difference between two searches."""
    score = experiment.score
    window_s = score.after_s, score.until_s or experiment.duration_ns / NS_PER_S
    last = recording.trials - 1
    learnt = {"learnt": learnt_widths(recording, last)}
    floor = reachable_floor(experiment, reference_course(recording, last), window_s, learnt)
    return {"rmse_deg": floor.rmse_deg, "rows_deg": floor.rows_deg.tolist(), "spread_deg": floor.spread_deg}


def _followed(reference: Path, followed: Path) -> dict[str, Any]:
    """RMSE of a reachable reference by trial: of each row, deg, and of the aperture, mm."""
    with Recording(reference) as wanted, Recording(followed) as recording:
        goal_s, goal = _apertures(wanted, 0)
        rows = metrics_of(recording)["joints"]
        found: dict[str, Any] = {name: row["joint_rmse_deg"] for name, row in rows.items()}
        errors = []
        for trial in range(recording.trials):
            times_s, mm = _apertures(recording, trial)
            inside = (times_s >= FREE_S[0]) & (times_s <= FREE_S[1])
            error = mm[inside] - np.interp(times_s[inside], goal_s, goal)
            errors.append(float(np.sqrt(np.mean(error**2))))
        return found | {"aperture_mm": errors}


def _apertures(recording: Recording, trial: int) -> tuple[Array, Array]:
    """Times, s, and true aperture of the hand, mm."""
    signal = recording.signal("hand.fingertips", trial)
    return signal.times_ns / NS_PER_S, 1e3 * aperture(np.asarray(signal.values), ("F2", "F3"))


def run(subjects: int = SUBJECTS, workers: int = 1, progress: Progress | None = None) -> Reproduction:
    """Run every patient's session."""
    patients = sessions(subjects, learn)
    kept = run_jobs(patients, workers, progress)
    return compare([kept[session.key] for session in patients])


def compare(patients: list[Kept]) -> Reproduction:
    """Make rows and tables of what each patient learnt; one who failed has infinite errors and holds nothing.

    An unknown value is NaN in the table, and counts in the rows as that of a patient who failed.
    """
    table = [_of_patient(patient) for patient in patients]
    columns = {name: np.array([row[name] for row in table]) for name in table[0]}
    within = "reference within reach, trial 8"
    rows = [_at_most(within, name, columns[name], ANGLE_BAR_DEG, "deg")
            for name in ("wrist_extension", "finger_flexion")]
    rows += [_at_most(within, "aperture", columns["aperture"], APERTURE_BAR_MM, "mm"),
             _at_most("therapist's reference, trial 8", "excess over the floor", columns["excess"],
                      EXCESS_BAR_DEG, "deg"),
             _held("cylinder held, trial 8", columns["held"], HELD_SHARE),
             _held(f"the same, {100.0 * WEAR:g} % of force lost a trial", columns["held, worn"], WORN_SHARE)]
    each = Sweep(title="Patient by patient, trial 8", unit="deg, mm, as told", columns=tuple(columns),
                 rows=tuple((f"member {number}", tuple(row.values())) for number, row in enumerate(table)))
    failed = {number: kept["failed"] for number, kept in enumerate(patients) if kept["failed"]}
    return Reproduction("grasp_ilc", len(patients), rows, {"patients": each},
                        {"patients": patients, "failed": failed})


def _of_patient(kept: Kept) -> dict[str, float]:
    """Figures of a patient's last trial."""
    if kept["failed"]:
        none = {"held": 0.0, "held, worn": 0.0}
        return {**dict.fromkeys(_FIGURES, math.inf), **none}
    grasp, worn, reach, floor = kept["grasp"], kept["worn"], kept["reach"], kept["floor"]["rmse_deg"]
    values = (reach["wrist_extension"], reach["finger_flexion"], reach["aperture_mm"],
              grasp["joint_rmse_deg"], [floor], [grasp["joint_rmse_deg"][-1] - floor], grasp["held"],
              worn["held"], grasp["object_moved_mm"],
              grasp["aperture_mm"]["opening"], grasp["wrist_extension_deg"], grasp["grip_margin"],
              grasp["unwanted_motion_deg"], grasp["charge_uc"])
    last = (math.nan if course[-1] is None else float(course[-1]) for course in values)
    return dict(zip(_FIGURES, last, strict=True))


def _at_most(table: str, row: str, values: Array, bar: float, unit: str) -> Row:
    """Compare the median over patients, with failures as infinite, with a limit."""
    values = np.where(np.isnan(values), math.inf, values)
    return Row(table, f"{row}, at most", bar, band(values), bool(np.median(values) <= bar), unit)


def _held(table: str, held: Array, share: float) -> Row:
    count = int(np.nansum(held))
    return Row(table, "patients, at least", f"{share * held.size:g} of {held.size}",
               f"{count} of {held.size}", count >= share * held.size)
