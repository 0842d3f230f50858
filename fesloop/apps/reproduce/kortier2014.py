"""`fesloop reproduce kortier2014`: its experiments in virtual papers (doi 10.1186/1743-0003-11-70).

The paper has one subject with an optical reference, one for pinch and rapid movements, and five for
repeatability. A virtual paper has the same in one room, with the errors of `error_model`, which is fitted to
the first half of the figures (`published`). The tracker keeps its own noise parameters (`CONSTRAINTS`). The
shipped experiment `kortier2014` is one movement of one subject.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.apps.reproduce.cohort import Job, Kept, Key, Progress, Scoring
from fesloop.apps.reproduce.error_model import (
    FROZEN,
    Reference,
    Theta,
    VirtualPaper,
    person_settings,
    posterior,
    reference,
    room_settings,
    simulated,
    with_model_error,
)
from fesloop.apps.reproduce.hand_recording import (
    HAND,
    Seen,
    contact_points_of,
    each_trial,
    plant_of,
    seen,
    size_of,
    spans,
    within,
)
from fesloop.apps.reproduce.published import published
from fesloop.apps.reproduce.result import Reproduction, Sweep
from fesloop.apps.reproduce.scores import (
    Pattern,
    Replicates,
    all_of,
    baseline,
    figure_rows,
    papers_of_subjects,
    pattern_rows,
)
from fesloop.experiment.recording.reading import Recording
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.kinematics import segment_poses
from fesloop.hand.skeleton import hand_tree
from fesloop.loop.clock import NS_PER_S

Array = NDArray[np.float64]
_INDEX, _TRACKER = 1, "tracker"
_SETTLING_S = 1.0
"""Time left out at the start of each hold, until the hand is at rest."""
_CYCLES = 10
_RANGE = {2: 1.128, 3: 1.693, 4: 2.059, 5: 2.326, 6: 2.534, 7: 2.704, 8: 2.847, 9: 2.970, 10: 3.078}
_DEVIATION = {2: 0.798, 3: 0.886, 4: 0.921, 5: 0.940, 6: 0.952, 7: 0.959, 8: 0.965, 9: 0.969, 10: 0.973}
"""Mean range and mean standard deviation of n normal values, in sd (the d2 and c4 of control charts): those
of ten holds follow from those of fewer."""


def _of_ten(means: dict[int, float], holds: int) -> float:
    return means[_CYCLES] / means[holds]


def index_tip(recording: Recording, optical: Reference | None = None) -> dict[str, Any]:
    """RMS error of the index finger's tip in the hand's frame, mm: x, y, z and distance, (4,), by trial.

    The wrist rests in these experiments, and a calibration trial of the paper gives the place of the MCP
    joint: positions are those from this joint. `optical` is the reference system; None: exact.
    """
    told, own = (_mcp(size) for size in (size_of(recording, _TRACKER), plant_of(recording).hand))
    trials = []
    for trial in each_trial(recording):
        rows = _task(recording, "fingertips", trial)
        truth = rows.truth - own
        measured = truth if optical is None else optical.of(truth)
        error = 1e3 * (rows.estimate[:, _INDEX] - told - measured[:, _INDEX])
        trials.append([*np.sqrt(np.mean(error ** 2, axis=0)), np.sqrt(np.mean((error ** 2).sum(axis=1)))])
    return {"rms_mm": np.array(trials)}


def _mcp(size: HandSize) -> Array:
    """MCP joint of the index finger with the wrist neutral, (3,), m."""
    tree = hand_tree(size)
    place: Array = tree.geometry[tree.index("hand"), 4] + tree.geometry[tree.index("F2p"), 3]
    return place


def pinch(recording: Recording) -> dict[str, Any]:
    """Estimated distance between touching tips: RMS of each contact, mm and share of the widest opening.

    The widest opening is that of the extended hand with its thumb abducted.
    """
    size = size_of(recording, _TRACKER)
    contacts, widest = [], []
    (opening,) = spans(recording, "widest")
    for trial in each_trial(recording):
        rows = seen(recording, "tracker.angles", f"{HAND}.angles", trial)
        poses = segment_poses(hand_tree(size), rows.estimate)
        ends = contact_points_of(size, poses, ("F1 distal", "F2 distal"))
        apart = 1e3 * np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
        for start, stop in spans(recording, "task"):
            inside = (rows.times_s >= start) & (rows.times_s <= stop)
            if stop <= rows.times_s[-1]:
                contacts.append(float(np.sqrt(np.mean(apart[inside] ** 2))))
        open_wide = (rows.times_s >= opening[0]) & (rows.times_s <= opening[1])
        widest.append(float(apart[open_wide].max()))
    return {"rms_mm": np.array(contacts), "share": float(np.mean(contacts) / np.mean(widest))}


def rapid(recording: Recording) -> dict[str, Any]:
    """Range of the index finger's PIP angle in each cycle, deg: estimated and true, medians over cycles."""
    pip = hand_tree(size_of(recording, _TRACKER)).freedom("F2_pip_flexion")
    rows = _task(recording, "angles", 0)
    cycles = np.array_split(np.arange(rows.times_s.size), 30)
    reach = {name: float(np.median([np.ptp(np.degrees(angles[part, pip])) for part in cycles]))
             for name, angles in (("estimate", rows.estimate), ("truth", rows.truth))}
    return {"range_deg": reach["estimate"], "true_range_deg": reach["truth"]}


def repeatability(recording: Recording, which: int) -> dict[str, Any]:
    """Range and standard deviation of each joint angle over the holds of a trial, deg, mean over joints.

    `which` is 0 for the flat phases, between the movements, 1 for those in the far posture.
    """
    ranges, deviations = [], []
    freedoms = hand_tree(size_of(recording, _TRACKER)).freedoms
    seen_joints = np.array([not name.startswith("wrist") for name in freedoms])
    for trial in each_trial(recording):
        rows = seen(recording, "tracker.angles", f"{HAND}.angles", trial)
        (start, stop), = spans(recording, "task")
        # A cycle: a move there, a hold, a move back, a hold.
        cycle = (stop - start) / _CYCLES
        means = []
        for k in range(int((rows.times_s[-1] + 0.1 - start) / cycle)):
            end = start + k * cycle + (0.5 * cycle if which else cycle)
            hold = within(rows, (end - 6.0 + _SETTLING_S, end))
            means.append(np.degrees(hold.estimate[:, seen_joints]).mean(axis=0))
        ranges.append(_of_ten(_RANGE, len(means)) * np.ptp(means, axis=0).mean())
        deviations.append(_of_ten(_DEVIATION, len(means)) * np.std(means, axis=0, ddof=1).mean())
    return {"range_deg": float(np.mean(ranges)), "sd_deg": float(np.mean(deviations))}


def flat_phase(recording: Recording) -> dict[str, Any]:
    """Repeatability in the flat phases."""
    return repeatability(recording, 0)


def clenched_phase(recording: Recording) -> dict[str, Any]:
    """Repeatability in the phases around the mould."""
    return repeatability(recording, 1)


def traces(recording: Recording) -> dict[str, Any]:
    """Estimated and true index tip, mm, PIP angle, deg, and its rate, deg/s, for figures."""
    pip = hand_tree(size_of(recording, _TRACKER)).freedom("F2_pip_flexion")
    tips, angles = _task(recording, "fingertips", 0), _task(recording, "angles", 0)
    rates = recording.signal(f"{HAND}.rates")
    moments = rates.times_ns / NS_PER_S
    inside = (moments >= angles.times_s[0]) & (moments <= angles.times_s[-1])
    return {"times_s": tips.times_s, "tip_mm": 1e3 * tips.estimate[:, _INDEX],
            "true_tip_mm": 1e3 * tips.truth[:, _INDEX], "pip_deg": np.degrees(angles.estimate[:, pip]),
            "true_pip_deg": np.degrees(angles.truth[:, pip]),
            "rate_times_s": moments[inside], "rate_deg_s": np.degrees(rates.values[inside, pip])}


def _task(recording: Recording, port: str, trial: int) -> Seen:
    rows = seen(recording, f"tracker.{port}", f"{HAND}.{port}", trial)
    (span,) = spans(recording, "task")
    return within(rows, span)


EXPERIMENT = "kortier2014"
SUBJECTS = 16
_TIPS, AXES = ("flexion", "circles"), ("x", "y", "z", "distance")


def tip_key(motion: str, axis: str) -> str:
    """Key of a figure of table 2: RMS difference of the index finger's tip, mm, mean over ten trials."""
    return f"Table 2: {motion}, {axis}"


def angle_key(posture: str, what: str) -> str:
    """Key of a figure of table 3: range or sd of joint angles, deg, mean over five subjects."""
    return f"Table 3: {posture}, {what}, mean of five subjects"


PINCH, PINCH_SHARE = "Pinch: RMS distance of the tips", "Pinch: over the widest opening"
RAPID = "Figure 6: range of the PIP joint at 116 beats/min"
FIGURES = published(EXPERIMENT, [
    *(tip_key(motion, axis) for motion in _TIPS for axis in AXES), PINCH, PINCH_SHARE, RAPID,
    *(angle_key(posture, what) for posture in ("flat", "mould") for what in ("range", "sd"))])
_SCORINGS: dict[str, Scoring] = {
    "pinch": pinch, "rapid": rapid, "flat": flat_phase, "mould": clenched_phase}


CONSTRAINTS = {
    "as shipped: 1 deg, lasting": (),
    "5 deg, lasting": ("blocks.tracker.constraint_sd_deg=5.0",),
    "0.1 deg, lasting": ("blocks.tracker.constraint_sd_deg=0.1",),
    "table 1: 1e-5 deg, all noise white": (
        "blocks.tracker.constraint_sd_deg=1e-5", "blocks.tracker.error_time_s=0.0",
        "blocks.tracker.lever_m=0.0", "blocks.tracker.mag_sd_ut=0.1")}
"""Settings of the joint constraints' noise; the paper's 1e-3 mG of magnetometer noise is read as 1e-3 G."""
_PAPERS_OF_SWEEP = 6


_LENGTHS_S = {"flexion": 17.0, "circles": 17.0, "pinch": 25.0, "rapid": 27.5, "flat": 52.1, "mould": 52.1}
"""Length of the one trial of each movement and subject, s, fewer and shorter than the paper's: trials of a
placement are alike, and the range of ten holds follows from that of three."""
_SEATS: dict[str, tuple[int, ...]] = {
    "flexion": (0,), "circles": (0,), "pinch": (1,), "rapid": (1,), "flat": (2, 3, 4, 5, 6),
    "mould": (2, 3, 4, 5, 6)}
"""Subjects of each movement: one with optical reference, a second without, and five for repeatability."""
SEEDS = 8
"""Seeds of a replicate: of the room, and of seven subjects."""


def replicate(theta: Theta, seeds: Sequence[int], motion: str, most: int = 5) -> list[Job]:
    """Jobs of a movement in one virtual paper, one for each of at most `most` subjects."""
    return [_job(theta, seeds, motion, seat) for seat in _SEATS[motion][:most]]


def _job(theta: Theta, seeds: Sequence[int], motion: str, seat: int) -> Job:
    length_s, seed = _LENGTHS_S[motion], seeds[1 + seat]
    scoring = partial(index_tip, optical=reference(theta, seed)) if motion in _TIPS else _SCORINGS[motion]
    return Job((motion, seat), EXPERIMENT, (
        f"motion=kortier_{motion}", f"duration_s={length_s!r}", f"record.leave_out={json.dumps(_UNREAD)}",
        *person_settings(theta, seed, seed),
        *room_settings(theta["room_a_m2"], theta["room_m"], seeds[0], ("imus",)),
        f"blocks.hand.repeat_sd_deg={theta['repeat_deg']!r}",
        f"blocks.gyroscopes.gyroscope={{bias_sd={theta['bias_rad_s']!r}}}",
        f"blocks.imus.magnetometer={{bias_sd={1e-6 * theta['magnet_ut']!r}}}"), seed, scoring)


_UNREAD = [*(f"hand.site_{name}" for name in ("orientation", "position", "rate", "force")), "gyroscopes.gyr",
           "imus.acc", "imus.mag", "hand.accelerations",
           *(f"calibration.{kind}" for kind in ("gyr", "acc", "mag"))]


def run(subjects: int = SUBJECTS, workers: int = 1, progress: Progress | None = None) -> Reproduction:
    """Simulate virtual papers from the frozen posterior, and compare their figures with the published."""
    papers = posterior(EXPERIMENT, subjects)
    kept = simulated(papers, lambda paper: [
        job for motion in _SEATS for job in replicate(paper.theta, paper.seeds, motion)], workers, progress)
    old = baseline(EXPERIMENT)
    ours = with_model_error(EXPERIMENT, replicates(kept))
    before = papers_of_subjects(old.values, FIGURES)
    rows = [*figure_rows(FIGURES, ours, before), *pattern_rows(PATTERNS, ours, before)]
    (shown,) = simulated(papers[:1], _shown, workers)
    sweep = {"constraints": _constraints(simulated(papers[:_PAPERS_OF_SWEEP], _held, workers))}
    return Reproduction(EXPERIMENT, len(kept), rows, sweep,
                        {"traces": {motion: each for (motion, _), each in shown.items()}}, old.commit,
                        FROZEN[EXPERIMENT], "virtual paper")


def _shown(paper: VirtualPaper) -> list[Job]:
    """Jobs of the movements in figures 5 and 6 of the paper."""
    return [replace(replicate(paper.theta, paper.seeds, motion)[0], score=traces)
            for motion in ("flexion", "circles", "rapid")]


def _held(paper: VirtualPaper) -> list[Job]:
    """Jobs of the index finger's movements with other constraints."""
    jobs = [job for motion in _TIPS for job in replicate(paper.theta, paper.seeds, motion)]
    return [replace(job, key=(name, *job.key), settings=job.settings + extra)
            for name, extra in CONSTRAINTS.items() for job in jobs]


def _constraints(kept: Sequence[Mapping[Key, Kept]]) -> Sweep:
    """Sweep of the constraints' noise: RMS error of the index tip, median over virtual papers."""
    table = [(name, tuple(float(np.median([each[name, motion, 0]["rms_mm"][:, 3].mean() for each in kept]))
                          for motion in _TIPS)) for name in CONSTRAINTS]
    return Sweep(title="Index tip, by how firmly joints are held", unit="mm", columns=_TIPS,
                 rows=tuple(table))


def replicates(kept: Sequence[Mapping[Key, Kept]]) -> dict[str, Array]:
    """Figures of virtual papers by key, (papers,); `kept` has each paper's scores by movement and subject."""
    found: dict[str, Any] = {}
    for motion in _TIPS:
        means = np.array([each[motion, 0]["rms_mm"].mean(axis=0) for each in kept])
        found |= {tip_key(motion, axis): column for axis, column in zip(AXES, means.T, strict=True)}
    found[PINCH] = [each["pinch", 1]["rms_mm"].mean() for each in kept]
    found[PINCH_SHARE] = [100.0 * each["pinch", 1]["share"] for each in kept]
    found[RAPID] = [each["rapid", 1]["range_deg"] for each in kept]
    for posture in ("flat", "mould"):
        for what in ("range", "sd"):
            found[angle_key(posture, what)] = [
                np.mean([each[posture, seat][f"{what}_deg"] for seat in _SEATS[posture]]) for each in kept]
    return {key: np.array(values) for key, values in found.items()}


def _z_largest(found: Replicates) -> NDArray[np.bool_]:
    return all_of([found[tip_key(motion, "z")] > found[tip_key(motion, axis)]
                   for motion in _TIPS for axis in ("x", "y")])


def _circles_worse(found: Replicates) -> NDArray[np.bool_]:
    return found[tip_key("circles", "distance")] > found[tip_key("flexion", "distance")]


def _mould_worse(found: Replicates) -> NDArray[np.bool_]:
    return found[angle_key("mould", "range")] > found[angle_key("flat", "range")]


def _tips_below(found: Replicates) -> NDArray[np.bool_]:
    return all_of([found[tip_key(motion, "distance")] < _TIP_MM for motion in _TIPS])


def _angles_below(found: Replicates) -> NDArray[np.bool_]:
    return all_of([found[angle_key(posture, "range")] < _RANGE_DEG for posture in ("flat", "mould")])


_TIP_MM, _RANGE_DEG = 13.0, 2.0
"""Limits of the paper's conclusion: error of the fingertip, and range of a joint's angle in repetitions."""
PATTERNS = (
    Pattern(table="Table 2", statement="z the largest part of the error, in both movements", theirs="2 of 2",
            occurs=_z_largest),
    Pattern(table="Table 2", statement="circles worse than flexion", theirs="12.4 and 5.0 mm",
            occurs=_circles_worse),
    Pattern(table="Table 3", statement="mould less repeatable than flat hand", theirs="1.8 and 1.1 deg",
            occurs=_mould_worse),
    Pattern(table="Conclusion", statement="fingertip below 13 mm, in both movements", theirs="2 of 2",
            occurs=_tips_below),
    Pattern(table="Conclusion", statement="a joint's angle repeats within 2 deg, in both postures",
            theirs="2 of 2", occurs=_angles_below))
