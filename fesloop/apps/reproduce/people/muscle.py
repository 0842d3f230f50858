"""Muscles of rats: fitted to isometric contractions, quick releases and ramps, stretch-shortening predicted.

Each file of the folder is one rat's medial gastrocnemius (doi 10.1101/2025.09.29.678508). A muscle with a
tendon that yields is fitted to its recordings of the kinds ISOM, QR and SR (`fesloop.analysis.muscle_fit`),
and predicts those of the kind SSC, stretch-shortening cycles. Errors are root mean squares of a recording,
the mean over recordings of a kind, in percent of the fitted largest isometric force.

The model was chosen by cross-validation on the rats GMe1 and GMe2, each kind of ISOM, QR and SR predicted
from the other two: 2.5 % with calcium that acts by its cube on fibres that are more sensitive to it when
longer; 3.2 % without that sensitivity, 3.1 % with a second-order lag in place of calcium, 2.6 % with a
separate time constant of decay or a sensitivity to force besides, 2.7 % with a delay. No stretch-shortening
cycle took part.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from fesloop.analysis.muscle_fit import STEP_S, MuscleFit, MuscleTrial, fit_muscle, rms_error, trial_of
from fesloop.apps.reproduce.comparison import Row
from fesloop.apps.reproduce.people.part import Part
from fesloop.apps.reproduce.result import Sweep
from fesloop.streams.stimulation import open_stimulation

FITTED, PREDICTED = ("ISOM", "QR", "SR"), "SSC"
MOST = 4.0
"""Greatest error of the prediction that holds, %."""
BASELINES = {"GMe1": 3.9, "GMe2": 3.3}
"""Prediction by MuJoCo's curves with a quadratic tendon and a second-order lag, fitted to the same, %."""
BOUNDS = {"force_n": (5.0, 30.0), "fibre_mm": (8.0, 16.0), "slack_mm": (20.0, 45.0), "strain": (0.01, 0.15),
          "fastest": (4.0, 25.0), "passive": (0.0, 2.0), "calcium_ms": (10.0, 80.0), "half": (0.1, 1.5),
          "sensitivity": (0.0, 6.0)}
"""Bounds of the fit, of any rat's gastrocnemius (chosen: fibres are 12 to 14 mm long)."""


def rats(folder: Path) -> dict[str, list[MuscleTrial]]:
    """Trials of each rat by name."""
    found = {}
    for path in sorted(folder.glob("*.npz")):
        recording = open_stimulation(path)
        found[recording.person] = [trial_of(each, recording.frequency_hz) for each in recording.forces]
    return found


def fitted(trials: Sequence[MuscleTrial]) -> MuscleFit:
    """Fit a rat's muscle to its recordings of the kinds `FITTED`."""
    return fit_muscle([trial for trial in trials if trial.kind in FITTED], BOUNDS)


def errors(fit: MuscleFit, trials: Sequence[MuscleTrial]) -> dict[str, list[float]]:
    """Error of each recording by kind, % of the largest isometric force."""
    return {kind: [100.0 * rms_error(fit.muscle, trial) / fit.muscle.force_n
                   for trial in trials if trial.kind == kind] for kind in (*FITTED, PREDICTED)}


def part(folder: Path, random_people: int) -> Part:
    """Rows of the prediction, errors and parameters by rat, and courses of force for figures."""
    rows, shown, numbers = [], [], []
    curves: dict[str, Any] = {}
    for rat, trials in rats(folder).items():
        lacking = {*FITTED, PREDICTED} - {trial.kind for trial in trials}
        if lacking:
            rows.append(Row("rat muscle", rat, f"recordings of {', '.join((*FITTED, PREDICTED))}",
                            f"none of {', '.join(sorted(lacking))}", holds=False))
            continue
        fit = fitted(trials)
        found = errors(fit, trials)
        of_kind = {kind: float(np.mean(each)) for kind, each in found.items()}
        beside = f", baseline {BASELINES[rat]:g}" if rat in BASELINES else ""
        rows.append(Row("rat muscle", f"{rat}: stretch-shortening, fitted to {', '.join(FITTED)}",
                        f"at most {MOST:g}{beside}", f"{of_kind[PREDICTED]:.2f}", of_kind[PREDICTED] <= MOST,
                        "% of the largest force, rms"))
        shown.append((rat, (*of_kind.values(), float(np.max(found[PREDICTED])))))
        numbers.append((rat, tuple(getattr(fit.muscle, name) for name in BOUNDS)))
        numbers.append((f"{rat}, standard error", tuple(fit.standard_errors.values())))
        curves[rat] = examples(fit, trials)
    sweeps = {
        "rat_errors": Sweep(title="rat muscle: rms error of force by kind of recording",
                            unit="% of the largest force",
                            columns=(*FITTED, PREDICTED, f"worst {PREDICTED}"), rows=tuple(shown)),
        "rat_parameters": Sweep(title="rat muscle: fitted parameters", unit="as in HillMuscle",
                                columns=tuple(BOUNDS), rows=tuple(numbers))}
    return Part(rows, sweeps, {"rats": curves})


def examples(fit: MuscleFit, trials: Sequence[MuscleTrial]) -> dict[str, Any]:
    """Recorded and predicted courses that the figure shows.

    They are the shortest and the longest contraction at the length of the greatest force, the steepest ramp,
    and the stretch-shortening recording of median error.
    """
    isometric = [trial for trial in trials if trial.kind == "ISOM"]
    long = max(isometric, key=lambda trial: (trial.drive.sum(), trial.force_n.max()))
    short = min(isometric, key=lambda trial: (trial.drive.sum(), abs(trial.length_m[0] - long.length_m[0])))
    ramp = max((trial for trial in trials if trial.kind == "SR"), key=lambda trial: np.ptp(trial.length_m))
    cycles = sorted((trial for trial in trials if trial.kind == PREDICTED),
                    key=lambda trial: rms_error(fit.muscle, trial))
    chosen = {"long": long, "short": short, "ramp": ramp, "cycles": cycles[len(cycles) // 2]}
    return {name: {
        "name": trial.name, "times_s": STEP_S * np.arange(trial.force_n.size),
        "length_mm": 1e3 * trial.length_m, "theirs_n": trial.force_n, "drive": trial.drive,
        "ours_n": fit.muscle.force(trial.length_m, trial.drive, STEP_S)} for name, trial in chosen.items()}
