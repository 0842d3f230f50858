"""What is kept of each virtual subject's run in the experiments of Kortier et al. 2014."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.apps.reproduce.hand_recording import (
    HAND,
    Seen,
    contact_points_of,
    each_trial,
    palm_error,
    seen,
    size_of,
    spans,
    within,
)
from fesloop.experiment.recording.reading import Recording
from fesloop.hand.kinematics import segment_poses
from fesloop.hand.skeleton import hand_tree
from fesloop.loop.clock import NS_PER_S

Array = NDArray[np.float64]
_INDEX = 1
_SETTLING_S = 1.0
"""Of each hold is left out, so that what is compared stands still."""


def index_tip(recording: Recording) -> dict[str, Any]:
    """RMS error of the index finger's tip in the hand's frame, mm: x, y, z and distance, by trial, (4,).

    The wrist rests in these experiments, so that the hand's frame is the wrist's, a palm further.
    """
    trials, palm = [], palm_error(recording)
    for trial in each_trial(recording):
        rows = _task(recording, "fingertips", trial)
        error = 1e3 * (rows.estimate[:, _INDEX] - rows.truth[:, _INDEX] + palm)
        trials.append([*np.sqrt(np.mean(error ** 2, axis=0)), np.sqrt(np.mean((error ** 2).sum(axis=1)))])
    return {"rms_mm": np.array(trials)}


def pinch(recording: Recording) -> dict[str, Any]:
    """Distance between touching tips as estimated: RMS of each contact, mm, and over the widest opening."""
    size = size_of(recording)
    contacts, widest = [], []
    for trial in each_trial(recording):
        rows = seen(recording, "tracker.angles", f"{HAND}.angles", trial)
        poses = segment_poses(hand_tree(size), rows.estimate)
        ends = contact_points_of(size, poses, ("F1 distal", "F2 distal"))
        apart = 1e3 * np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
        touching = spans(recording, "task", trial)
        for start, stop in touching:
            inside = (rows.times_s >= start) & (rows.times_s <= stop)
            contacts.append(float(np.sqrt(np.mean(apart[inside] ** 2))))
        moving = (rows.times_s >= touching[0][0]) & (rows.times_s <= touching[-1][1])
        widest.append(float(apart[moving].max()))
    return {"rms_mm": np.array(contacts), "share": float(np.mean(contacts) / np.mean(widest))}


def rapid(recording: Recording) -> dict[str, Any]:
    """Range of the index finger's PIP angle in each cycle, deg: estimated and true, medians over cycles."""
    pip = hand_tree(size_of(recording)).freedom("F2_pip_flexion")
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
    seen_joints = np.array([not name.startswith("wrist") for name in hand_tree(size_of(recording)).freedoms])
    for trial in each_trial(recording):
        rows = seen(recording, "tracker.angles", f"{HAND}.angles", trial)
        (start, stop), = spans(recording, "task", trial)
        # A cycle: a move, a hold there, a move back, a hold here.
        cycle = (stop - start) / 10
        means = []
        for k in range(10):
            end = start + k * cycle + (0.5 * cycle if which else cycle)
            hold = within(rows, (end - 6.0 + _SETTLING_S, end))
            means.append(np.degrees(hold.estimate[:, seen_joints]).mean(axis=0))
        ranges.append(np.ptp(means, axis=0).mean())
        deviations.append(np.std(means, axis=0, ddof=1).mean())
    return {"range_deg": float(np.mean(ranges)), "sd_deg": float(np.mean(deviations))}


def flat_phase(recording: Recording) -> dict[str, Any]:
    """Repeatability of the flat hand."""
    return repeatability(recording, 0)


def clenched_phase(recording: Recording) -> dict[str, Any]:
    """Repeatability of the hand around the mould."""
    return repeatability(recording, 1)


def traces(recording: Recording) -> dict[str, Any]:
    """Index tip, mm, and PIP angle, deg, as estimated and in truth, for figures; with rates, deg/s."""
    pip = hand_tree(size_of(recording)).freedom("F2_pip_flexion")
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
    (span,) = spans(recording, "task", trial)
    return within(rows, span)
