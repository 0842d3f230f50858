"""What is kept of each virtual subject's run in the experiments of Salchow-Hoemmen et al. 2019."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.apps.reproduce.cohort import Scoring
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
    """Poses by joint angles, or where no joint constrains them by the segments' orientations."""
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
    """The scoring of one of the paper's movements."""
    if motion in PAIRS:
        return partial(distances, pairs=PAIRS[motion])
    return partial(tip, finger=motion[-2:])


PAIRS: dict[str, tuple[Pair, ...]] = {
    "P1": (("F1 bottom", "F2 bottom", 3.0),), "P2": (("F2 left", "F3 right", 3.0),),
    "P3": (("F1 distal", "F2 distal", 0.0),),
    "P4": (("F1 bottom", "F2 bottom", 5.3), ("F1 bottom", "F3 bottom", 4.6),
           ("F2 bottom", "F3 bottom", 2.5))}
"""Table 5; the sides by which a left hand's F2 and F3 face each other."""


def tip_traces(recording: Recording) -> dict[str, Any]:
    """Index tip, cm, as M1 has it and in truth, and its error, for figure 13."""
    (task,) = spans(recording, "task")
    rows = within(seen(recording, "salchow_m1.fingertips", f"{HAND}.fingertips"), task)
    return {"times_s": rows.times_s, "estimate_cm": 100.0 * rows.estimate[:, 1],
            "truth_cm": 100.0 * rows.truth[:, 1]}


def distance_traces(recording: Recording) -> dict[str, Any]:
    """Distance of the pinching tips, cm, as M2 has it, and when they touch, for figure 15."""
    times, poses = _poses(recording, "M2", 0)
    ends = contact_points_of(size_of(recording), poses, ("F1 distal", "F2 distal"))
    return {"times_s": times, "distance_cm": 100.0 * np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1),
            "spans": np.array(spans(recording, "task"))}
