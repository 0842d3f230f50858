"""Choice of the trial that pictures, films, views and reports begin with, and of its most telling instant."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import FesloopError
from fesloop.experiment.metrics.scoring import metrics_of
from fesloop.experiment.recording.reading import Recording

Array = NDArray[np.float64]


def best_trial(recording: Recording, metrics: Mapping[str, Any] | None = None) -> int:
    """Trial that held its object, if any did, and among these the one with the least `joint_rmse_deg`.

    The last trial where none has such an error, or where none held its object and the first has the least:
    learning begins without stimulation, and what it came to is in the last. A trial that was broken off is
    passed over if there is another.

    `metrics`: of the recording; None: computed here.
    """
    last = recording.trials - 1
    complete = last + 1 if recording.status == "done" else last
    if complete < 2:
        return max(last if complete == last + 1 else 0, 0)
    try:
        found = metrics_of(recording) if metrics is None else metrics
    except (FesloopError, KeyError, TypeError):  # nothing to choose by
        return complete - 1
    errors = _by_trial(found.get("joint_rmse_deg"), complete)
    held = [each is True for each in _by_trial(found.get("held"), complete)]
    known = [trial for trial, error in enumerate(errors)
             if isinstance(error, (int, float)) and math.isfinite(error)]
    kept = [trial for trial in known if held[trial]] or known
    if not kept:
        return max((trial for trial in range(complete) if held[trial]), default=complete - 1)
    best = min(kept, key=lambda trial: float(errors[trial]))
    return best if best > 0 or held[best] else complete - 1


def _by_trial(values: Any, count: int) -> list[Any]:
    """First `count` values of a metric with one per trial; None each for another metric."""
    if not isinstance(values, list) or len(values) < count:
        return [None] * count
    return values[:count]


def telling_s(score: Mapping[str, Any], times_s: Array, positions: Array) -> float | None:
    """Instant of a trial at which most is to be seen, s; None if no posture is known.

    The middle of the time over which an object is to be held, or else the instant at which the hand is
    farthest from its first posture.

    Parameters
    ----------
    score: table [score] of the experiment.
    times_s: (t,). positions: (t, segments, 3) of a hand, m; NaN where it is not known.
    """
    known = np.flatnonzero(np.isfinite(positions).all(axis=(1, 2)))
    if not known.size:
        return None
    grasp = score.get("grasp")
    if isinstance(grasp, Mapping):
        begin, end = grasp.get("from_s"), grasp.get("until_s")
        if isinstance(begin, (int, float)) and isinstance(end, (int, float)):
            middle = 0.5 * (float(begin) + float(end))
            if times_s[known[0]] <= middle <= times_s[known[-1]]:
                return middle
    own = positions[known] - positions[known, :1]
    apart = np.square(own - own[0]).sum(axis=(1, 2))
    return float(times_s[known[int(apart.argmax())]])
