"""`fesloop reproduce hour`: an hour of tracking without magnetometer and without drift, compared with M2.

Each subject is a member of the cohort of able-bodied adults, with the error sizes that doi 10.3390/s19010208
states. No paper has such an hour; that one, section 5, expects M2 to "deteriorate with time" and asks for it.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.apps.reproduce.cohort import Job, Progress, run_jobs
from fesloop.apps.reproduce.comparison import Row
from fesloop.apps.reproduce.error_model import STATED, person_settings
from fesloop.apps.reproduce.hand_recording import HAND, seen, spans
from fesloop.apps.reproduce.result import Reproduction, Sweep
from fesloop.experiment.metrics.joints import TWO_SIDED_95
from fesloop.experiment.recording.reading import Recording

Array = NDArray[np.float64]
EXPERIMENT = "tracker_hour"
SUBJECTS = 3
OURS, THEIRS, CALIBRATED = "constrained", "salchow_m2", "m2_calibrated"
_POSE_S, _MINUTE_S = 10.0, 60.0
_FINGERS = slice(1, 5)
_LAST_MINUTES = 10
_BAR_CM, _BAR_RATIO = 1.5, 1.2
_COVERAGE = (0.90, 0.99)


def minutes(recording: Recording) -> dict[str, Any]:
    """RMSE of each fingertip in each minute after the pose, cm, (minutes, 5), by tracker.

    For the constrained tracker also the coverage of its 95 % intervals and its mean standard deviation, cm,
    in the same shape; `uncertain` are the times, s, at which it reported a joint.
    """
    kept: dict[str, Any] = {}
    for tracker in (OURS, THEIRS, CALIBRATED):
        rows = seen(recording, f"{tracker}.fingertips", f"{HAND}.fingertips")
        error = rows.estimate - rows.truth
        minute = np.floor((rows.times_s - _POSE_S) / _MINUTE_S).astype(int)
        kept[tracker] = _each(minute, 1e4 * np.square(error).sum(axis=2)) ** 0.5
        if tracker == OURS:
            signal = recording.signal(f"{tracker}.fingertip_sd")
            sd = signal.values[signal.newest_ns >= 0]
            kept["inside"] = _each(minute, (np.abs(error) <= TWO_SIDED_95 * sd).mean(axis=2))
            kept["sd"] = _each(minute, 1e4 * np.square(sd).sum(axis=2)) ** 0.5
    kept["uncertain"] = np.array([event.time_ns * 1e-9 for event in recording.events
                               if event.where == OURS and event.status == "uncertain"])
    (still,) = spans(recording, "still")
    kept["still"] = np.array(still)
    return kept


def _each(minute: NDArray[np.int64], values: Array) -> Array:
    """Mean over each minute, (minutes, tips)."""
    return np.array([values[minute == k].mean(axis=0) for k in range(minute.max() + 1)])


def run(subjects: int = SUBJECTS, workers: int = 1, progress: Progress | None = None) -> Reproduction:
    """Run the hour of every subject."""
    jobs = [Job((seed,), EXPERIMENT, person_settings(STATED, seed, seed), seed, minutes)
            for seed in range(1, subjects + 1)]
    kept = list(run_jobs(jobs, workers, progress).values())
    rows = [row for number, each in enumerate(kept, 1) for row in _rows(f"subject {number}", each)]
    return Reproduction("hour", subjects, rows, {"ten_minutes": _by_ten_minutes(kept)}, {"minutes": kept})


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def _rows(subject: str, kept: dict[str, Any]) -> list[Row]:
    """Rows of the claims on a subject's hour; the thumb, without a claim, is in the sweep."""
    last = _rms(kept[OURS][-_LAST_MINUTES:, _FINGERS])
    bar = max(_BAR_RATIO * _rms(kept[THEIRS][:1, _FINGERS]), _BAR_CM)
    drifted, other = (_rms(kept[tracker][-_LAST_MINUTES:, _FINGERS]) for tracker in (THEIRS, CALIBRATED))
    inside = float(kept["inside"][-_LAST_MINUTES:, _FINGERS].mean())
    start, stop = kept["still"]
    first, end = int((start - _POSE_S) // _MINUTE_S) + 1, int((stop - _POSE_S) // _MINUTE_S) - 1
    growth = kept["sd"][end] / kept["sd"][first]
    told = int(((kept["uncertain"] > start) & (kept["uncertain"] < stop)).sum())
    return [
        Row(subject, "F2-F5, last ten minutes; at most 1.2 times M2's first minute, or 1.5 cm", f"{bar:.2f}",
            f"{last:.2f} (M2: {drifted:.2f}, calibrated {other:.2f})", last <= bar, "cm"),
        Row(subject, "95 % intervals of F2-F5, last ten minutes", "90-99", f"{100.0 * inside:.1f}",
            _COVERAGE[0] <= inside <= _COVERAGE[1], "%"),
        Row(subject, "ten still minutes: the fingertips' sd grows, or a flag rises", "yes",
            f"times {growth.min():.2f} to {growth.max():.2f}, {told} flags",
            bool(growth.min() > 1.0 or told))]


def _by_ten_minutes(kept: list[dict[str, Any]]) -> Sweep:
    """Sweep of the RMSE of the fingertips over the hour, over all subjects."""
    columns = (*(f"{tips}, {tracker}" for tips in ("F2-F5", "thumb")
                 for tracker in ("constrained", "M2", "M2 calibrated")), "inside, %")
    table = []
    for start in range(0, len(kept[0][OURS]), 10):
        part = slice(start, start + 10)
        values = [_rms(np.concatenate([each[tracker][part, tips] for each in kept]))
                  for tips in (_FINGERS, slice(0, 1)) for tracker in (OURS, THEIRS, CALIBRATED)]
        values.append(100.0 * float(np.mean([each["inside"][part, _FINGERS] for each in kept])))
        table.append((f"{start}-{start + 10} min", tuple(values)))
    return Sweep(title="Fingertips over the hour", unit="cm", columns=columns, rows=tuple(table))
