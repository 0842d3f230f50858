"""Reasons, in words, of metrics that are missing: None, NaN or infinite."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

MISSING = "missing"
"""Key of the reasons among the metrics: dotted path of a metric to its reason, or to a list of one per trial,
None where the metric is known."""
_OVERFLOW = "its squares are beyond floating point: the loop is unstable"
_TRIAL = "nothing that it is computed from was recorded in the scored part of this trial"
_REASONS = (
    ("split_", "nothing of the tracker had arrived at the controller in the scored part of this trial, "
     "as far as it is recorded"),
    ("minutes", "the search had not ended"),
    ("found_predicted", "the search had found nothing by the end, or its strategy predicts no quality"),
    ("found", "the search had found nothing by the end"),
    ("optimum_share", "the search had found nothing by the end"),
    ("decline_pct", "the trial ended before the last cycle, or the first cycle has no peak"),
    ("intention_to_reference", "no attempt was answered by a trigger"),
    ("intention_to_movement", "no attempt was answered by a trigger, or the hand did not move after it"),
    ("raised", "no element raised the angle"),
    ("lowered", "no element lowered the angle"),
    ("orientation", "the tracker gave no orientation while the reference had one"),
    ("relative_angle", "the tracker gave no orientation while the reference had one"),
)


def put(metrics: dict[str, Any], path: Sequence[str], value: Any) -> None:
    """Add a trial's value to the list at a path."""
    for part in path[:-1]:
        metrics = metrics.setdefault(part, {})
    metrics.setdefault(path[-1], []).append(value)


def note(metrics: dict[str, Any], path: Sequence[str], trial: int, trials: int, why: str | None) -> None:
    """Add the reason why the metric at a path is missing in a trial, if there is one."""
    if why is not None:
        metrics.setdefault(MISSING, {}).setdefault(".".join(path), [None] * trials)[trial] = why


def give_reasons(metrics: dict[str, Any]) -> None:
    """Add a reason for every missing number that has none yet."""
    noted: dict[str, Any] = metrics.get(MISSING, {})
    for path, value in list(numbers(metrics)):
        missing = [_none(item) for item in value] if isinstance(value, list) else [_none(value)]
        name = ".".join(path)
        if any(missing) and name not in noted:
            why = next((words for start, words in _REASONS if path[0].startswith(start)
                        or path[-1].startswith(start)), _TRIAL)
            values = value if isinstance(value, list) else [value]
            reasons = [(_OVERFLOW if item is not None and math.isinf(item) else why) if none else None
                       for item, none in zip(values, missing, strict=True)]
            why = reasons[0] or why
            noted[name] = reasons if isinstance(value, list) else why
    if noted:
        metrics[MISSING] = noted


def reasons_of(metrics: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Each reason once, after its metric and trials: ("held, trials 0 and 2", "...")."""
    for name, reasons in metrics.get(MISSING, {}).items():
        if isinstance(reasons, str):
            yield name, reasons
            continue
        for why in dict.fromkeys(each for each in reasons if each is not None):
            trials = [number for number, each in enumerate(reasons) if each == why]
            if len(reasons) == 1:
                yield name, why
            elif len(trials) == len(reasons):
                yield f"{name}, every trial", why
            else:
                number = ", ".join(map(str, trials))
                yield f"{name}, trial{'s' if len(trials) > 1 else ''} {number}", why


def numbers(metrics: dict[str, Any], path: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Any]]:
    """Paths and values of all metrics that are a number, or a list of one per trial."""
    for name, value in metrics.items():
        if isinstance(value, dict):
            if name != MISSING:
                yield from numbers(value, (*path, str(name)))
        elif not isinstance(value, str) and not (
                isinstance(value, list) and any(isinstance(item, (list, dict, str)) for item in value)):
            yield (*path, str(name)), value


def _none(value: Any) -> bool:
    return value is None or (isinstance(value, float) and not math.isfinite(value))
