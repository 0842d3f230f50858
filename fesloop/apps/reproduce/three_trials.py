"""`fesloop reproduce three_trials`: from a person nobody knows to a grasp in at most three trials.

Members of a cohort of `sci_c6`, on whom nothing was tuned, are seen for the first time; every tenth has
another hand, MyoHand, so that nobody is judged on one model alone. One way sweeps all elements through the
tracker, chooses elements and currents, and grasps a cylinder three times under predictive control that learns
from trial to trial. The other is what one did before: the electrodes of an average arm, an identification of
three minutes, and iterative learning. MyoHand opens wider, both ways. The patient's time counts all that is
stimulated or waited for: sweep or identification, trials, rests before them. A patient who fails counts as
one who did not hold.

The floor of an error is what the chosen elements leave of it in the opened hand, by the responses in the
sweep (`controllers.identification.elements`).
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from fesloop.apps.reproduce.cohort import Progress, run_jobs
from fesloop.apps.reproduce.comparison import Row, band
from fesloop.apps.reproduce.patient_session import Kept, Session
from fesloop.apps.reproduce.result import Reproduction, Sweep
from fesloop.errors import InputError, RunError
from fesloop.experiment.metrics.scoring import metrics_of
from fesloop.experiment.recording.reading import Recording
from fesloop.experiment.registry import identifier
from fesloop.loop.clock import NS_PER_S

SUBJECTS = 100
COHORT, FIRST_SEED = 43, 4300
"""Pilots were members of cohorts 3 and 40 to 42."""
OTHER_HAND_EVERY = 10
_OTHER_HAND = "plant=myohand"
_WIDELY_DEG = 8.0
"""Finger flexion to which MyoHand opens, in place of 18 (chosen on pilots: else its thumb leaves too little
room for the object in five of twelve)."""
TRIALS = 3
HELD_SHARE, MOST_MIN, MOST_DEG = 0.9, 5.0, 3.0
WAYS = {"sweep": "all elements swept, then predictive control that learns",
        "identify": "usual electrodes identified, then iterative learning"}
_LOST: Kept = {"failed": "", "min": math.nan, "held": [False] * TRIALS, "error": [math.inf] * TRIALS,
               "floor": math.nan}
_GRASPS = {
    "sweep": ("sweep_grasp", "grasp_mpc", ("follow=fingers", "channels=model", "control=mpc_memory"),
              ("F2_flexion", "F3_flexion", "F4_flexion", "F5_flexion")),
    "identify": ("identify_grasp", "grasp_ilc", (f"experiment.trials={TRIALS}",), ("finger_flexion",))}
"""By way: what comes first, the grasp, its settings, and the controlled quantities that open the hand."""


def grasp(session: Session, folder: Path) -> Kept:
    """Run both ways of one patient; failures are reported."""
    return {"ways": {way: _one_way(session, folder, way) for way in WAYS}}


def _one_way(session: Session, folder: Path, way: str) -> dict[str, Any]:
    """Minutes of the patient's time, and by trial what was held and the error before contact, deg."""
    first, then, settings, opening = _GRASPS[way]
    other = _OTHER_HAND in session.patient
    if other:
        settings += tuple(f"blocks.reference.phases.open.deg.{row}={_WIDELY_DEG:g}" for row in opening)
    try:
        before = session.ran(session.load(first), folder)
        with Recording(before) as recording:
            before_s = _stimulated_s(recording)
        identified = identifier()(str(before), opened_deg=_WIDELY_DEG if other and way == "sweep" else None)
        model = folder / f"{before.stem}.toml"
        identified.model.save(model)
        experiment = session.load(then, (f"model={model}", *settings))
        with Recording(session.ran(experiment, folder)) as recording:
            found, rest_s = metrics_of(recording), _rest_s(recording)
    except (InputError, RunError) as fault:
        return {**_LOST, "failed": str(fault).replace(f"{folder}/", "")}
    trials_s = TRIALS * experiment.duration_ns / NS_PER_S + TRIALS * rest_s
    return {"failed": "", "min": (before_s + trials_s) / 60.0, "held": [bool(each) for each in found["held"]],
            "error": [float(each) for each in found["joint_rmse_deg"]],
            "floor": _floor_deg(identified.report())}


def _floor_deg(report: dict[str, Any]) -> float:
    """Error that is left in the opened hand, root mean square over the outputs; nan where none is known."""
    left = report.get("missed_deg", {}).get("opened")
    return math.sqrt(sum(each**2 for each in left.values()) / len(left)) if left else math.nan


def _stimulated_s(recording: Recording) -> float:
    """Time of the last pulse, s."""
    pulses = recording.signal("safety.stimulation")
    given = np.flatnonzero(pulses.values[..., 1].any(axis=1))
    return float(pulses.times_ns[given[-1]]) / NS_PER_S if given.size else 0.0


def _rest_s(recording: Recording) -> float:
    """Rest before each trial, s."""
    return float(recording.experiment["blocks"]["muscles"].get("rest_between_trials_s", 10.0))


def run(subjects: int = SUBJECTS, workers: int = 1, progress: Progress | None = None) -> Reproduction:
    """Run every patient both ways."""
    sessions = [Session((member,), ("patient=sci_c6", f"cohort={COHORT}", f"member={member}", *_hand(member)),
                        FIRST_SEED + member, grasp) for member in range(subjects)]
    kept = run_jobs(sessions, workers, progress)
    return compare([kept[session.key] for session in sessions])


def _hand(member: int) -> tuple[str, ...]:
    return (_OTHER_HAND,) if member % OTHER_HAND_EVERY == OTHER_HAND_EVERY - 1 else ()


def compare(patients: list[Kept]) -> Reproduction:
    """Make rows and tables of both ways."""
    rows, sweeps = list[Row](), dict[str, Sweep]()
    for way, title in WAYS.items():
        runs = [patient.get("ways", {}).get(way, _LOST) for patient in patients]
        held, least = np.array([run["held"] for run in runs]), math.ceil(HELD_SHARE * len(runs))
        above = np.array([run["error"] for run in runs]) - np.array([[run["floor"]] for run in runs])
        counts = {"held in one of three trials": held.any(axis=1), "held in the third trial": held[:, -1]}
        if np.isfinite(above).any():
            counts[f"held in one of three trials within {MOST_DEG:g} deg of the floor"] = (
                held & (above <= MOST_DEG)).any(axis=1)
        for what, those in counts.items():
            rows.append(Row(title, f"{what}, patients, at least", f"{least} of {len(runs)}",
                            f"{those.sum()} of {len(runs)}", bool(those.sum() >= least)))
        minutes = band([run["min"] for run in runs if math.isfinite(run["min"])] or [math.inf])
        rows.append(Row(title, "patient's time, at most", MOST_MIN, minutes, minutes.high <= MOST_MIN, "min"))
        errors = band([run["error"][-1] for run in runs])
        rows.append(Row(title, "error before contact, third trial, median at most", MOST_DEG, errors,
                        errors.median <= MOST_DEG, "deg"))
        rows += [Row(f"{title}: not to its end", f"member {number}", "", run["failed"], False)
                 for number, run in enumerate(runs) if run["failed"]]
        sweeps[way] = Sweep(
            title=title.capitalize(), unit="min, 1: held, deg before contact",
            columns=("time", *(f"held {k + 1}" for k in range(TRIALS)),
                     *(f"error {k + 1}" for k in range(TRIALS)), "floor"),
            rows=tuple((f"member {number}", (run["min"], *map(float, run["held"]), *run["error"],
                                             run["floor"]))
                       for number, run in enumerate(runs)))
    return Reproduction("three_trials", len(patients), rows, sweeps)
