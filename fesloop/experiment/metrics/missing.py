"""Why a metric is not known: every number that is none has its reason in words."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

MISSING = "missing"
"""Name under which metrics keep their reasons: path of a metric, dots between its parts, to its reason, or
to a list of them, one a trial, None where it is known."""
_OVERFLOW = "its squares are beyond floating point: the loop is unstable"
_TRIAL = "nothing that it is computed from was recorded in the scored part of this trial"
_REASONS = (
    ("split_", "nothing of the tracker had arrived at the controller in the scored part of this trial, "
     "as far as it is recorded"),
    ("minutes", "the search had not ended"),
    ("found", "the search had found nothing by the end"),
    ("optimum_share", "the search had found nothing by the end"),
    ("decline_pct", "the trial ended before the last cycle, or the first cycle has no peak"),
    ("orientation", "the tracker gave no orientation while the reference had one"),
    ("relative_angle", "the tracker gave no orientation while the reference had one"),
)


def put(metrics: dict[str, Any], path: Sequence[str], value: Any) -> None:
    """Add a trial's value to the list at a path."""
    for part in path[:-1]:
        metrics = metrics.setdefault(part, {})
    metrics.setdefault(path[-1], []).append(value)


def note(metrics: dict[str, Any], path: Sequence[str], trial: int, trials: int, why: str | None) -> None:
    """Keep why the metric at a path is not known in a trial; nothing where it is."""
    if why is not None:
        metrics.setdefault(MISSING, {}).setdefault(".".join(path), [None] * trials)[trial] = why


def give_reasons(metrics: dict[str, Any]) -> None:
    """Add a reason for every number that is none and has none yet."""
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
    """Each reason once, with the metric and the trials that it is about: ("held, trials 0 and 2", "...")."""
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
    """Paths and values of all metrics that are a number, or a list of one a trial."""
    for name, value in metrics.items():
        if isinstance(value, dict):
            if name != MISSING:
                yield from numbers(value, (*path, str(name)))
        elif not isinstance(value, str) and not (
                isinstance(value, list) and any(isinstance(item, (list, dict, str)) for item in value)):
            yield (*path, str(name)), value


def _none(value: Any) -> bool:
    return value is None or (isinstance(value, float) and not math.isfinite(value))


_PORT = "stimulation"


class Rows(Protocol):
    """What is read of a recording."""

    @property
    def signals(self) -> Sequence[str]:
        """Names of what is recorded."""

    @property
    def experiment(self) -> Mapping[str, Any]:
        """The document of the experiment."""

    def tables(self, names: Sequence[str], trial: int = 0) -> Sequence[Any]:
        """Signals of a trial, read in pieces."""


@dataclass(frozen=True, slots=True)
class Stimulated:
    """Of one trial: charge per phase, the mean of all channels and rows, C.

    Attributes
    ----------
    asked: into the safety block; 0 where that is not recorded.
    passed: out of it.
    given: by the device, where it says so; else as `passed`.
    """

    asked: float
    passed: float
    given: float


def commanded_signal(recording: Rows, safety: str) -> str:
    """What is wired into a safety block as stimulation; "" where nothing is."""
    return next((str(wire["from"]) for wire in recording.experiment.get("wires", ())
                 if wire["to"] == f"{safety}.{_PORT}"), "")


def given_signal(recording: Rows, commanded: str) -> str | None:
    """The recorded `charge` of the device that a signal of pulses commands; None where there is none."""
    for wire in recording.experiment.get("wires", ()):
        charge = f"{wire['to'].partition('.')[0]}.charge"
        if wire["from"] == commanded and wire["to"].endswith(f".{_PORT}") and charge in recording.signals:
            return charge
    return None


def stimulated(recording: Rows, safety: str, trial: int, from_ns: int = 0) -> Stimulated | None:
    """What went through a safety block in a trial from an instant on; None where no row is."""
    passed = f"{safety}.{_PORT}"
    if passed not in recording.signals:
        return None
    source = commanded_signal(recording, safety)
    asked = _mean(recording, source, trial, from_ns) if source in recording.signals else 0.0
    let_through = _mean(recording, passed, trial, from_ns)
    given = _mean(recording, given_signal(recording, passed) or passed, trial, from_ns)
    if asked is None or let_through is None or given is None:
        return None
    return Stimulated(asked, let_through, given)


def _mean(recording: Rows, name: str, trial: int, from_ns: int) -> float | None:
    """Charge per phase, C: the mean of the rows from an instant on; None where there are none."""
    total, count = 0.0, 0
    for piece in recording.tables([name], trial)[0].pieces():
        rows = piece.values[0][piece.times_ns >= from_ns]
        charges = rows[..., 0] * rows[..., 1] if rows.ndim == 3 else rows
        total += float(np.nansum(charges))
        count += charges.size
    return total / count if count else None
