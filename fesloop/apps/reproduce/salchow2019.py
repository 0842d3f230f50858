"""`fesloop reproduce salchow2019`: its experiments on virtual subjects (doi 10.3390/s19010208).

The paper has one subject without (table 6) and four with magnetic disturbance (table 7). Here each seed of
the shipped experiment `salchow2019`, which defines the error sources, is a virtual subject. The furniture
around setting 2 is defined here (`furniture`), and its strength is swept, since no source states a field. Its
distances, the lift off the table, the fusion (that of the paper) and soft tissue were set after a pilot run
of four subjects; nothing was changed after the full one.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.apps.reproduce.cohort import Job, Progress, Scoring, run_jobs
from fesloop.apps.reproduce.hand_recording import (
    HAND,
    contact_points_of,
    each_trial,
    poses_by_angles,
    poses_by_orientations,
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
from fesloop.experiment import registry
from fesloop.experiment.recording.reading import Recording
from fesloop.hand.anthropometry import FINGERS
from fesloop.hand.kinematics import Poses

Array = NDArray[np.float64]
METHODS = ("B", "M1", "M2")
Pair = tuple[str, str, float]
"""Two points, and their distance, cm."""


def node_of(method: str) -> str:
    """Node of a method in the shipped experiment."""
    return f"salchow_{method.lower()}"


def tip(recording: Recording, finger: str) -> dict[str, Any]:
    """Error E of a fingertip, cm (eq. 30, 31): RMSE, and its quartiles and maximum, by method."""
    number = FINGERS.index(finger)
    (task,) = spans(recording, "task")
    kept = {}
    for method in METHODS:
        rows = within(seen(recording, f"{node_of(method)}.fingertips", f"{HAND}.fingertips"), task)
        kept[method] = _summary(100.0 * np.linalg.norm((rows.estimate - rows.truth)[:, number], axis=1))
    return kept


def distances(recording: Recording, pairs: tuple[Pair, ...]) -> dict[str, Any]:
    """Error E of distances between points, cm (eq. 32), by method and pair, mean over trials."""
    kept: dict[str, Any] = {}
    for method in METHODS:
        by_pair: dict[str, list[dict[str, float]]] = {}
        for trial in each_trial(recording):
            for name, error in _distance_errors(recording, method, pairs, trial).items():
                by_pair.setdefault(name, []).append(_summary(error))
        kept[method] = {name: {key: float(np.mean([each[key] for each in trials])) for key in trials[0]}
                        for name, trials in by_pair.items()}
    return kept


def _distance_errors(
    recording: Recording, method: str, pairs: tuple[Pair, ...], trial: int
) -> dict[str, Array]:
    times, poses = _poses(recording, method, trial)
    held = np.zeros(times.size, dtype=np.bool_)
    for start, stop in spans(recording, "task", trial):
        held |= (times >= start) & (times <= stop)
    errors = {}
    for first, second, distance in pairs:
        ends = contact_points_of(size_of(recording), poses, (first, second))
        apart = 100.0 * np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
        errors[f"{first[:2]}-{second[:2]}"] = np.abs(apart - distance)[held]
    return errors


def _poses(recording: Recording, method: str, trial: int) -> tuple[Array, Poses]:
    """Poses by joint angles, or by the segments' orientations where joints do not constrain them."""
    node, size = node_of(method), size_of(recording)
    if method == "B":
        signal = recording.signal(f"{node}.orientation", trial)
        known = signal.newest_ns >= 0
        return signal.newest_ns[known] / 1e9, poses_by_orientations(size, signal.values[known])
    rows = seen(recording, f"{node}.angles", f"{HAND}.angles", trial)
    return rows.times_s, poses_by_angles(size, rows.estimate)


def _summary(error: Array) -> dict[str, float]:
    quartiles = np.percentile(error, [25, 50, 75, 100])
    return {"rmse": float(np.sqrt(np.mean(error ** 2))), "mean": float(error.mean()),
            "std": float(error.std()),
            **dict(zip(("low", "median", "high", "worst"), map(float, quartiles), strict=True))}


def scoring_of(motion: str) -> Scoring:
    """Scoring function of one of the paper's movements."""
    if motion in PAIRS:
        return partial(distances, pairs=PAIRS[motion])
    return partial(tip, finger=motion[-2:])


PAIRS: dict[str, tuple[Pair, ...]] = {
    "P1": (("F1 bottom", "F2 bottom", 3.0),), "P2": (("F2 left", "F3 right", 3.0),),
    "P3": (("F1 distal", "F2 distal", 0.0),),
    "P4": (("F1 bottom", "F2 bottom", 5.3), ("F1 bottom", "F3 bottom", 4.6),
           ("F2 bottom", "F3 bottom", 2.5))}
"""Pairs of points of table 5, with the facing sides of a left hand's F2 and F3."""


def tip_traces(recording: Recording) -> dict[str, Any]:
    """Index tip by M1 and in truth, and its error, cm, for figure 13."""
    (task,) = spans(recording, "task")
    rows = within(seen(recording, "salchow_m1.fingertips", f"{HAND}.fingertips"), task)
    return {"times_s": rows.times_s, "estimate_cm": 100.0 * rows.estimate[:, 1],
            "truth_cm": 100.0 * rows.truth[:, 1]}


def distance_traces(recording: Recording) -> dict[str, Any]:
    """Distance of the pinching tips by M2, cm, and the times of touch, for figure 15."""
    times, poses = _poses(recording, "M2", 0)
    ends = contact_points_of(size_of(recording), poses, ("F1 distal", "F2 distal"))
    return {"times_s": times, "distance_cm": 100.0 * np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1),
            "spans": np.array(spans(recording, "task"))}


EXPERIMENT = "salchow2019"
SUBJECTS = 50
SUBJECTS_OF_SWEEPS = 10
TIPS = ("A-F1", "A-F2", "A-F3", "AF-F1", "AF-F2", "AF-F3", "F-F2", "F-F3")
"""Movements of table 6."""
DISTANCES = tuple((motion, f"{first[:2]}-{second[:2]}")
                  for motion, pairs in PAIRS.items() for first, second, _ in pairs)
"""Movements and pairs of fingers of table 7."""


def tip_key(motion: str, method: str) -> str:
    """Key of a figure of table 6: RMSE of the fingertip, cm; one subject."""
    return f"Table 6: {motion}, {method}"


def distance_key(motion: str, pair: str, method: str) -> str:
    """Key of a figure of table 7: RMSE of the distance, cm; mean over four subjects."""
    return f"Table 7: {motion} {pair}, {method}, mean of four"


FIGURES = published(EXPERIMENT, [*(tip_key(motion, method) for motion in TIPS for method in METHODS),
                                 *(distance_key(*each, method) for each in DISTANCES for method in METHODS)])
_ABOUT = 1.25
"""Ratio up to which M1 and M2 count as "very similar" (section 4.1; chosen: above the paper's, 1.11)."""
MOMENTS = (0.0, 0.3, 1.0, 3.0, 10.0)
"""Moments of each piece of furniture in the sweep of setting 2, A m^2."""
_WEAKEST, _STRONGEST = 0.3, 10.0
"""Range of the furniture's moment, A m^2, log-uniform over virtual subjects (chosen; none is published).

The field is 2 to 64 uT at 0.25 m across the moment; the Earth's is 50 uT.
"""
_PIECES, _NEAREST_M, _FARTHEST_M = 3, 0.15, 0.5
_NO_TISSUE = tuple(f"blocks.{node}.soft_tissue={{share=0.0, sag_deg=0.0}}"
                   for node in ("imus", "forearm_imu"))
_BARE = ("blocks.imus.preset=ideal", "blocks.forearm_imu.preset=ideal", "blocks.hand.deviation={}",
         *(f"blocks.{node}.{triad}={{}}" for node in ("imus", "forearm_imu")
           for triad in ("gyroscope", "accelerometer")), *_NO_TISSUE)
"""A textbook hand with ideal sensors in a homogeneous field."""
_SWEPT = ("F-F2", "AF-F1", "AF-F3", "P1", "P3", "P4")
SOURCES: dict[str, tuple[str, ...]] = {
    "all": (),
    "none": _BARE,
    "sensor-to-segment, 5-10 deg": (
        *_BARE, *(f"blocks.{node}.mounting_angle_deg=[5.0, 10.0]" for node in ("imus", "forearm_imu"))),
    "joint axes, 5-10 deg": (*_BARE, "blocks.hand.deviation={axis_tilt_deg=[5.0, 10.0]}"),
    "lengths, 3 %, 3 mm": (*_BARE, "blocks.hand.deviation={length=0.03, centre_mm=3.0}"),
    "noise and bias of the sensors": (
        "blocks.hand.deviation={}",
        *(f"blocks.{node}.mounting_angle_deg=[0.0, 0.0]" for node in ("imus", "forearm_imu")), *_NO_TISSUE),
    "furniture": _BARE,
    "soft tissue": (*_BARE, *(f"blocks.{node}.soft_tissue={{outwards=[1.0, 0.0, 0.0]}}"
                              for node in ("imus", "forearm_imu"))),
    "initial pose missed by 3 deg": (*_BARE, "blocks.hand.rest_sd_deg=3.0")}
"""Settings of each error source alone; an error of the initial pose is left out, as none is published."""
_WITH_FURNITURE = ("all", "furniture")
_UNREAD = ["hand.site_orientation", "hand.site_position", "hand.site_rate", "hand.site_force", "hand.rates",
           "hand.accelerations", *(f"{node}.{kind}" for node in ("imus", "forearm_imu")
                                   for kind in ("gyr", "acc", "mag")),
           *(f"{kind}.joined" for kind in ("gyr", "acc", "mag"))]


def moment_of(seed: int) -> float:
    """Strength of the furniture around a subject, A m^2."""
    share = np.random.default_rng([seed, 2020]).uniform()
    return float(_WEAKEST * (_STRONGEST / _WEAKEST) ** share)


def furniture(seed: int, moment: float) -> tuple[str, ...]:
    """Settings that put three magnetised pieces of furniture around a subject's initial pose.

    Each is a dipole of random direction, 0.15 to 0.5 m from the wrist, beside or below it (chosen: frame and
    legs of a table, a computer).
    """
    rng = np.random.default_rng([seed, 2019])
    dipoles = []
    for _ in range(_PIECES):
        towards, direction = rng.standard_normal((2, 3))
        towards[2] = -abs(towards[2])
        place = rng.uniform(_NEAREST_M, _FARTHEST_M) * towards / np.linalg.norm(towards)
        dipoles.append({"position": place.tolist(),
                        "moment": (moment * direction / np.linalg.norm(direction)).tolist()})
    table = json.dumps(dipoles).replace('": ', '" = ')
    return tuple(f"blocks.{node}.magnetic_field.dipoles={table}" for node in ("imus", "forearm_imu"))


def settings(motion: str, seed: int, moment: float, source: str = "all") -> tuple[str, ...]:
    """Settings of the shipped experiment for a movement of a subject."""
    length = registry.find("moving_hand")(script=motion).length_s
    trials = 2 if motion in ("P1", "P2", "P3") and source == "all" else 1
    around = furniture(seed, moment) if moment else ()
    return (*SOURCES[source], f"motion={motion}", f"duration_s={length!r}", f"trials={trials}", *around,
            f"record.leave_out={json.dumps(_UNREAD)}")


def jobs(subjects: int, of_sweeps: int) -> list[Job]:
    """Jobs of every movement of every subject, of the sweeps, and of the figures."""
    def job(key: str, motion: str, seed: int, moment: float, source: str = "all") -> Job:
        return Job((key, motion, seed), EXPERIMENT, settings(motion, seed, moment, source), seed,
                   scoring_of(motion))

    every = [job("main", motion, seed, moment_of(seed) if motion in PAIRS else 0.0)
             for motion in (*TIPS, *PAIRS) for seed in range(1, subjects + 1)]
    few = range(1, of_sweeps + 1)
    alone = [job(f"source {source}", motion, seed, moment_of(seed) if source in _WITH_FURNITURE else 0.0,
                 source)
             for source in SOURCES for motion in _SWEPT for seed in few]
    field = [job(f"moment {moment:g}", motion, seed, moment)
             for moment in MOMENTS for motion in _SWEPT for seed in few]
    shown = [Job(("traces", motion, 1), EXPERIMENT, settings(motion, 1, 0.0), 1, tip_traces)
             for motion in ("A-F2", "F-F2", "AF-F2")]
    pinch = Job(("traces", "P3", 1), EXPERIMENT, settings("P3", 1, moment_of(1)), 1,
                distance_traces)
    return [*every, *alone, *field, *shown, pinch]


def run(
    subjects: int = SUBJECTS, workers: int = 1, progress: Progress | None = None
) -> Reproduction:
    """Reproduce the whole paper."""
    of_sweeps = min(subjects, SUBJECTS_OF_SWEEPS)
    kept = run_jobs(jobs(subjects, of_sweeps), workers, progress)
    main = {motion: [kept["main", motion, seed] for seed in range(1, subjects + 1)]
            for motion in (*TIPS, *PAIRS)}
    sweeps = {"sources": _sources(kept, of_sweeps), "field": _field(kept, of_sweeps)}
    traces = {motion: kept["traces", motion, 1] for motion in ("A-F2", "F-F2", "AF-F2", "P3")}
    old = baseline(EXPERIMENT)
    ours, before = (papers_of_subjects(values, FIGURES) for values in (subject_values(main), old.values))
    rows = [*figure_rows(FIGURES, ours, before), *pattern_rows(PATTERNS, ours, before)]
    return Reproduction(EXPERIMENT, subjects, rows, sweeps, {"traces": traces, "main": main}, old.commit)


def subject_values(main: dict[str, list[dict[str, Any]]]) -> dict[str, Array]:
    """Figures of each subject by key, (subjects,); `main` has each subject's scores by movement."""
    tips = {tip_key(motion, method): [each[method]["rmse"] for each in main[motion]]
            for motion in TIPS for method in METHODS}
    distances = {distance_key(motion, pair, method): [each[method][pair]["rmse"] for each in main[motion]]
                 for motion, pair in DISTANCES for method in METHODS}
    return {key: np.array(values) for key, values in {**tips, **distances}.items()}


def _tips(found: Replicates, method: str, motions: Iterable[str] = TIPS) -> Array:
    return np.array([found[tip_key(motion, method)] for motion in motions])


def _distances(found: Replicates, method: str, pairs: Iterable[tuple[str, str]] = DISTANCES) -> Array:
    return np.array([found[distance_key(*pair, method)] for pair in pairs])


def _about(found: Replicates) -> NDArray[np.bool_]:
    ratio = np.median(_tips(found, "M1") / _tips(found, "M2"), axis=0)
    return (ratio >= 1.0 / _ABOUT) & (ratio <= _ABOUT)


def _thumb_worst(found: Replicates, method: str) -> NDArray[np.bool_]:
    """Whether the thumb has the largest error of its three fingers, abducted and in opposition."""
    kinds = [_tips(found, method, [f"{kind}-{finger}" for finger in ("F1", "F2", "F3")])
             for kind in ("A", "AF")]
    return all_of(np.concatenate([thumb > others for thumb, *others in kinds]))


def _m2_at_most(found: Replicates) -> NDArray[np.bool_]:
    """Whether M2 keeps its published limits, to the rounding of the tables (2.1 cm is in table 6)."""
    fingers = [motion for motion in TIPS if not motion.endswith("F1")]
    without_thumb = [pair for pair in DISTANCES if "F1" not in pair[1]]
    return all_of(np.concatenate([
        _tips(found, "M2") < 2.15, _distances(found, "M2") < 2.15,
        _tips(found, "M2", fingers) < 1.4, _distances(found, "M2", without_thumb) < 1.4]))


def _b_worst(found: Replicates) -> NDArray[np.bool_]:
    return all_of(_tips(found, "B") > np.maximum(_tips(found, "M1"), _tips(found, "M2")))


def _m2_best(found: Replicates) -> NDArray[np.bool_]:
    return all_of(_distances(found, "M2") < np.minimum(_distances(found, "B"), _distances(found, "M1")))


def _m1_worse(found: Replicates) -> NDArray[np.bool_]:
    return np.asarray(np.sum(_distances(found, "M1") > _distances(found, "B"), axis=0) >= _M1_WORSE)


_M1_WORSE = 5
"""Rows of six in table 7 in which M1 is worse than B."""
PATTERNS = (
    Pattern(table="Table 6", statement="B worst in every row", theirs="8 of 8", occurs=_b_worst),
    Pattern(table="Table 6", statement="M1 about M2: their ratio, median over rows", theirs="1.11",
            occurs=_about),
    *(Pattern(table="Table 6", statement=f"thumb worst in A and in AF, {method}", theirs="2 of 2",
              occurs=partial(_thumb_worst, method=method)) for method in METHODS),
    Pattern(table="Table 7", statement="M2 best in every row", theirs="6 of 6", occurs=_m2_best),
    Pattern(table="Table 7", statement="M1 worse than B in at least five of six rows", theirs="5 of 6",
            occurs=_m1_worse),
    Pattern(table="Section 5", statement="M2 at most 2.1 cm in every row, below 1.4 cm without the thumb",
            theirs="14 of 14", occurs=_m2_at_most))


def _sources(kept: dict[Any, dict[str, Any]], subjects: int) -> Sweep:
    """Sweep of error sources: RMSE with each alone, median over subjects, mean over movements."""
    return _swept(kept, subjects, "What each error source contributes alone",
                  {source: f"source {source}" for source in SOURCES})


def _field(kept: dict[Any, dict[str, Any]], subjects: int) -> Sweep:
    """Sweep of the furniture's strength: RMSE in setting 2, and in setting 1, which has none by the paper."""
    return _swept(kept, subjects, "In fields of other strength",
                  {f"{moment:g} A m2": f"moment {moment:g}" for moment in MOMENTS})


def _swept(kept: dict[Any, dict[str, Any]], subjects: int, title: str, conditions: dict[str, str]) -> Sweep:
    settings_of = ([motion for motion in _SWEPT if motion not in PAIRS],
                   [motion for motion in _SWEPT if motion in PAIRS])
    table = [(name, tuple(_median(kept, key, motions, method, subjects)
                          for motions in settings_of for method in METHODS))
             for name, key in conditions.items()]
    columns = tuple(f"{what}, {method}" for what in ("tips", "distances") for method in METHODS)
    return Sweep(title=title, unit="cm", columns=columns, rows=tuple(table))


def _median(
    kept: dict[Any, dict[str, Any]], key: str, motions: Sequence[str], method: str, subjects: int
) -> float:
    """Mean over movements (and pairs) of the median over subjects, cm."""
    medians = []
    for motion in motions:
        scores = [kept[key, motion, seed][method] for seed in range(1, subjects + 1)]
        if motion in PAIRS:
            medians += [np.median([each[pair]["rmse"] for each in scores]) for pair in scores[0]]
        else:
            medians.append(np.median([each["rmse"] for each in scores]))
    return float(np.mean(medians))
