"""From a person's intention to the movement of their hand: latencies, triggers missed and false."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.experiment.recording.reading import Recording
from fesloop.experiment.score_spec import IntentionScore
from fesloop.loop.clock import FOREVER, NS_PER_S

Instants = NDArray[np.int64]


class Answers(NamedTuple):
    """Attempts of a trial and what followed them.

    Attributes
    ----------
    onsets_ns: (attempts,), onset of each effort.
    triggers_ns: (attempts,), first trigger between onset and the end of the effort plus the grace; -1: none.
    false: number of triggers that answer no attempt, or one that has its trigger already.
    """

    onsets_ns: Instants
    triggers_ns: Instants
    false: int


def answers(times_ns: Instants, attempts: NDArray[np.float64], triggers_ns: Instants, after_ns: int,
            grace_ns: int) -> Answers:
    """Match triggers with attempts.

    Parameters
    ----------
    times_ns, attempts: (n,) instants and numbers of the attempt under way, 0 for none.
    triggers_ns: instants of all triggers.
    after_ns: attempts with an onset before, and triggers before, do not count.
    grace_ns: time after the end of an effort in which a trigger still answers it.
    """
    begins: Instants = np.flatnonzero((attempts > 0.0) & (np.diff(attempts, prepend=0.0) != 0.0))
    onsets, ends = [], []
    for first in begins:
        over = np.flatnonzero(attempts[first:] != attempts[first])
        if times_ns[first] >= after_ns:
            onsets.append(times_ns[first])
            ends.append(times_ns[first + over[0]] if over.size else times_ns[-1])
    counted = triggers_ns[triggers_ns >= after_ns]
    found = np.full(len(onsets), -1, np.int64)
    for number, (onset, end) in enumerate(zip(onsets, ends, strict=True)):
        before = onsets[number + 1] if number + 1 < len(onsets) else FOREVER
        inside = counted[(counted >= onset) & (counted <= end + grace_ns) & (counted < before)]
        if inside.size:
            found[number] = inside[0]
    return Answers(np.array(onsets, np.int64), found, counted.size - int((found >= 0).sum()))


def intention_metrics(recording: Recording, score: IntentionScore) -> dict[str, Any]:
    """Latencies in s and counts, one a trial."""
    found: dict[str, list[Any]] = {name: [] for name in (
        "intention_to_reference_s", "intention_to_movement_s", "false_triggers", "missed_triggers")}
    for trial in range(recording.trials):
        attempt, phase = recording.signal(score.attempt, trial), recording.signal(score.phase, trial)
        numbers = phase.values.reshape(-1)
        begun = (np.diff(numbers, prepend=numbers[:1]) != 0.0) & (numbers > 0.0)
        each = answers(attempt.times_ns, attempt.values.reshape(-1), phase.times_ns[begun],
                       round(score.after_s * NS_PER_S), round(score.grace_s * NS_PER_S))
        answered = each.triggers_ns >= 0
        onsets, triggers = each.onsets_ns[answered], each.triggers_ns[answered]
        moved = np.array([_moved_ns(recording, score, trial, at) for at in triggers.tolist()], np.int64)
        found["intention_to_reference_s"].append(_mean_s(triggers - onsets))
        found["intention_to_movement_s"].append(_mean_s((moved - onsets)[moved >= 0]))
        found["false_triggers"].append(each.false)
        found["missed_triggers"].append(int((~answered).sum()))
    return dict(found)


def _mean_s(latencies_ns: Instants) -> float:
    """Mean of latencies, s; NaN without any."""
    return float(latencies_ns.mean()) / NS_PER_S if latencies_ns.size else float("nan")


def _moved_ns(recording: Recording, score: IntentionScore, trial: int, trigger_ns: int) -> int:
    """First instant after a trigger at which an angle is `move_deg` from where it was then; -1 for none."""
    times, column = recording.column(score.angles, trial, trigger_ns)
    if not len(times):
        return -1
    angles = column[:].reshape(len(times), -1)
    far = np.abs(angles - angles[0]).max(axis=1) >= np.radians(score.move_deg)
    return int(times[np.argmax(far)]) if far.any() else -1
