"""`fesloop reproduce kortier2014`: its experiments on virtual subjects (doi 10.1186/1743-0003-11-70).

Published are ten trials of one subject for each movement, and five subjects for repeatability. Ours is a
cohort, each seed of the shipped experiment `kortier2014` a subject, whose error sources stand there. That
the tracker keeps its own noise in place of the paper's was decided after a pilot run (`CONSTRAINTS`).
"""

from __future__ import annotations

import json
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.apps.reproduce import kortier_scores
from fesloop.apps.reproduce.cohort import Job, Progress, Scoring, run_jobs
from fesloop.apps.reproduce.comparison import Row, band, band_of_means, compared
from fesloop.apps.reproduce.result import Reproduction, Sweep
from fesloop.experiment import registry

Array = NDArray[np.float64]
EXPERIMENT = "kortier2014"
SUBJECTS = 10
TABLE_2 = {"flexion": (2.2, 2.0, 3.3, 5.0), "circles": (5.7, 4.9, 9.7, 12.4)}
"""RMS difference of the index finger's tip in x, y, z and distance, mm, mean over ten trials."""
PINCH_MM, PINCH_SHARE = 6.5, 3.7
"""RMS distance of touching tips, mm, and in per cent of the widest opening."""
RAPID_DEG = 80.0
"""Range of the PIP joint at 116 beats a minute."""
TABLE_3 = {"flat": (1.1, 0.4), "mould": (1.8, 0.6)}
"""Range and standard deviation of joint angles, deg, mean over five subjects."""
_SUBJECTS_OF_TABLE_3 = 5
_MOTIONS: dict[str, tuple[Scoring, int]] = {
    "flexion": (kortier_scores.index_tip, 10), "circles": (kortier_scores.index_tip, 10),
    "pinch": (kortier_scores.pinch, 10), "rapid": (kortier_scores.rapid, 1),
    "flat": (kortier_scores.flat_phase, 3), "mould": (kortier_scores.clenched_phase, 3)}
"""Scoring and trials of each movement. Of the ten trials of flat hand and mould, of two and a half minutes
each, there are three: what is compared is a mean over trials."""


CONSTRAINTS = {
    "as shipped: 5 deg, lasting": (),
    "1 deg, lasting": ("blocks.tracker.constraint_sd_deg=1.0",),
    "0.1 deg, lasting": ("blocks.tracker.constraint_sd_deg=0.1",),
    "table 1: 1e-5 deg, all noise white": (
        "blocks.tracker.constraint_sd_deg=1e-5", "blocks.tracker.error_time_s=0.0",
        "blocks.tracker.lever_m=0.0", "blocks.tracker.mag_sd_ut=0.1")}
"""How firmly joints are held, as settings; the paper's 1e-3 mG of magnetometer noise are read as 1e-3 G."""
_SUBJECTS_OF_SWEEP = 6
_HELD = ("flexion", "circles")


def jobs(subjects: int) -> list[Job]:
    """Every movement of every subject, the sweep of constraints, and one subject's traces."""
    every = [Job((motion, seed), EXPERIMENT, settings(motion, trials), seed, scoring)
             for motion, (scoring, trials) in _MOTIONS.items() for seed in range(1, subjects + 1)]
    shown = [Job(("traces", motion), EXPERIMENT, settings(motion, 1), 1, kortier_scores.traces)
             for motion in ("flexion", "circles", "rapid")]
    held = [Job((name, motion, seed), EXPERIMENT, settings(motion, 1) + extra, seed, _MOTIONS[motion][0])
            for name, extra in CONSTRAINTS.items() for motion in _HELD
            for seed in range(1, min(subjects, _SUBJECTS_OF_SWEEP) + 1)]
    return every + held + shown


def settings(motion: str, trials: int) -> tuple[str, ...]:
    """Of the shipped experiment, for a movement."""
    script = f"kortier_{motion}"
    length = registry.find("moving_hand")(script=script).length_s
    unread = [f"hand.site_{name}" for name in ("orientation", "position", "rate", "force")]
    unread += ["gyroscopes.gyr", "imus.acc", "imus.mag", "hand.accelerations",
               *(f"calibration.{kind}" for kind in ("gyr", "acc", "mag"))]
    return (f"motion={script}", f"duration_s={length!r}", f"trials={trials}",
            f"record.leave_out={json.dumps(unread)}")


def run(subjects: int = SUBJECTS, workers: int = 1, progress: Progress | None = None) -> Reproduction:
    """The whole paper."""
    kept = run_jobs(jobs(subjects), workers, progress)
    by_motion = {motion: [kept[motion, seed] for seed in range(1, subjects + 1)] for motion in _MOTIONS}
    traces = {motion: kept["traces", motion] for motion in ("flexion", "circles", "rapid")}
    sweep = {"constraints": _constraints(kept, min(subjects, _SUBJECTS_OF_SWEEP))}
    return Reproduction(EXPERIMENT, subjects, rows(by_motion), sweep, {"traces": traces})


def _constraints(kept: dict[Any, dict[str, Any]], subjects: int) -> Sweep:
    """RMS error of the index tip, median over subjects, by how firmly joints are held."""
    table = [(name, tuple(float(np.median([kept[name, motion, seed]["rms_mm"][:, 3].mean()
                                           for seed in range(1, subjects + 1)])) for motion in _HELD))
             for name in CONSTRAINTS]
    return Sweep(title="Index tip, by how firmly joints are held", unit="mm", columns=_HELD,
                 rows=tuple(table))


def rows(kept: dict[str, list[dict[str, Any]]]) -> list[Row]:
    """The paper's figures beside ours; `kept` has each subject's scores by movement."""
    found = []
    for motion, theirs in TABLE_2.items():
        means = np.array([each["rms_mm"].mean(axis=0) for each in kept[motion]])
        found += [compared("Table 2", f"{motion}, {name}", value, band(column), "mm")
                  for name, value, column in zip(("x", "y", "z", "distance"), theirs, means.T, strict=True)]
    found += [
        compared("Pinch", "RMS distance of the tips", PINCH_MM,
                 band([each["rms_mm"].mean() for each in kept["pinch"]]), "mm"),
        compared("Pinch", "over the widest opening", PINCH_SHARE,
                 band([100.0 * each["share"] for each in kept["pinch"]]), "%"),
        compared("Figure 6", "range of the PIP joint at 116 beats/min", RAPID_DEG,
                 band([each["range_deg"] for each in kept["rapid"]]), "deg")]
    for motion, pair in TABLE_3.items():
        for name, key, value in zip(("range", "sd"), ("range_deg", "sd_deg"), pair, strict=True):
            column = [each[key] for each in kept[motion]]
            found.append(compared("Table 3", f"{motion}, {name}, mean of five subjects", value,
                                  band_of_means(column, _SUBJECTS_OF_TABLE_3), "deg"))
    return found
