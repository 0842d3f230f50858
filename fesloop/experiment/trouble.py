"""What went wrong in a run, the most important first: how every summary and every report of it begins."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from fesloop.experiment.metrics.grasp_outcome import OUTCOMES
from fesloop.experiment.recording.recorded import Event

_STATUSES = {"running": "the run is not over, or was killed", "damaged": "the file of the run is damaged",
             "failed": "the run failed", "interrupted": "the run was interrupted"}
_WATCHDOG = "posture_"
"""How statuses begin by which a safety block says that it takes stimulation away."""
_STOPPED = ("stopped", "budget_spent")
"""Its statuses after which there is no stimulation for the rest of the run."""
_FAILED = ("_failed", "non_finite")
"""How statuses end after which a run's figures are not what they seem."""
_ALIGNING, _ALIGNED = "aligning", "aligned"
_MOVES_DEG = 1.0
"""Chosen: a reference that stays nearer than this to where the joints are asks for no motion."""
_ROSE = 1.1
"""Chosen: what noise changes from trial to trial is less."""


class Recorded(Protocol):
    """What is read of a recording."""

    @property
    def status(self) -> str:
        """How the run ended."""

    @property
    def trials(self) -> int:
        """How many were begun."""

    @property
    def events(self) -> Sequence[Event]:
        """Everything that was reported, in order of time."""

    @property
    def experiment(self) -> Mapping[str, Any]:
        """The document of the experiment."""


@dataclass(frozen=True, slots=True)
class Trouble:
    """Something that went wrong: a word of `KINDS`, and half a sentence."""

    kind: str
    text: str

    @property
    def sentence(self) -> str:
        """As a sentence."""
        return f"{self.text[:1].upper()}{self.text[1:]}."


KINDS = ("broken_off", "safety", "failed", "noted", "not_held", "no_better", "rose")
"""What goes wrong, the most important first.

broken_off: the run did not get to its end. safety: the safety block took stimulation away. failed: a part
failed, such as a tracker that never took its initial pose. noted: what the experiment says of itself
(`notes`), such as that a model is poor. not_held: the object, in the last trial. no_better: joints followed
worse than had they not moved. rose: the error did, over the trials, by more than a tenth.
"""


def troubles(recording: Recorded, metrics: Mapping[str, Any], cause: str = "") -> list[Trouble]:
    """What went wrong in a run, the most important first; `cause`: why it failed, where that is known."""
    found = (_broken_off(recording, cause), _safety(recording), _failures(recording), _notes(recording),
             _not_held(metrics), _no_better(metrics), _rose(metrics))
    return [Trouble(kind, text) for kind, texts in zip(KINDS, found, strict=True) for text in texts]


def _broken_off(recording: Recorded, cause: str) -> Iterator[str]:
    status = recording.status
    if status != "done":
        words = _STATUSES.get(status, f"the run ended as {status!r}")
        yield f"{words}: {cause}" if cause else words


def _safety(recording: Recorded) -> Iterator[str]:
    """Stimulation that was taken away, but for a watchdog that sees a tracker stand still as it aligns."""
    blocks = _of_kind(recording, "safety")
    told = [event for event in recording.events if event.where in blocks]
    stopped = [event for event in told if event.status in _STOPPED]
    if stopped:
        first = stopped[0]
        yield f"stimulation ended for good{_when(recording, first)}: {first.where}: {first.detail}"
    aligning = {event.trial for event in recording.events if event.status == _ALIGNING}
    aligned = {event.trial: event.time_ns for event in recording.events if event.status == _ALIGNED}
    frozen = f"{_WATCHDOG}frozen"
    ramped = [event for event in told if event.status.startswith(_WATCHDOG) and not (
        event.status == frozen and event.trial in aligning
        and event.time_ns <= aligned.get(event.trial, math.inf))]
    if ramped:
        first = ramped[0]
        again = f", {len(ramped)} times in all" if len(ramped) > 1 else ""
        yield (f"stimulation was taken away{_when(recording, first)}{again}: {first.where}: {first.status}: "
               f"{first.detail}")


def _failures(recording: Recorded) -> Iterator[str]:
    """Parts that failed, samples that a recording lacks, and trackers that never aligned."""
    done: set[tuple[str, str]] = set()
    events = recording.events
    yield from dict.fromkeys(f"the recording played by `{event.where}` lacks samples: {event.detail}"
                             for event in events if event.status == "recording_incomplete")
    for event in events:
        if not event.status.endswith(_FAILED) or event.status.startswith(_WATCHDOG):
            continue
        if (event.where, event.status) in done:
            continue
        done.add((event.where, event.status))
        later = next((each for each in events if each.where == event.where and each.trial == event.trial
                      and each.status == _ALIGNED and each.time_ns > event.time_ns), None)
        never = "" if later is None else f"; aligned{_when(recording, later)} only"
        if later is None and event.status.startswith("initial_pose"):
            never = "; never aligned in that trial"
        yield f"{event.where}: {event.status}{_when(recording, event)}: {event.detail}{never}"
    aligned = {(event.where, event.trial) for event in events if event.status == _ALIGNED}
    blocks = recording.experiment.get("blocks", {})
    for event in events:
        knows = "initial_pose_s" in blocks.get(event.where, ()) \
            or any(where == event.where for where, _ in aligned)
        failed = any(where == event.where for where, _ in done)
        if event.status == _ALIGNING and knows and not failed and (event.where, event.trial) not in aligned:
            yield f"{event.where}: never aligned in trial {event.trial}"
            return


def _notes(recording: Recorded) -> Iterator[str]:
    about = recording.experiment.get("experiment", {})
    yield from (str(note) for note in about.get("notes", ()) if note)


def _not_held(metrics: Mapping[str, Any]) -> Iterator[str]:
    """The last trial that says so."""
    held = metrics.get("held")
    if not isinstance(held, list) or not held or held[-1] is not False:
        return
    outcomes = metrics.get("object_outcome") or [""]
    why = f": {OUTCOMES[outcomes[-1]]}" if outcomes[-1] in OUTCOMES else ""
    which = f" in the last of {len(held)} trials" if len(held) > 1 else ""
    yield f"the object was not held{which}{why}"


def _no_better(metrics: Mapping[str, Any]) -> Iterator[str]:
    """Joints that followed worse than if they had stayed where they were."""
    errors, still = metrics.get("joint_rmse_deg"), metrics.get("unmoved_rmse_deg")
    if not (isinstance(errors, list) and isinstance(still, list) and errors and len(still) == len(errors)):
        return
    if _finite(errors[-1]) and _finite(still[-1]) and errors[-1] > still[-1] > _MOVES_DEG:
        which = f" in the last of {len(errors)} trials" if len(errors) > 1 else ""
        yield (f"the joints followed worse{which} than if they had not moved ({errors[-1]:.3g} deg RMS; "
               f"{still[-1]:.3g} deg had they stayed where they were)")


def _rose(metrics: Mapping[str, Any]) -> Iterator[str]:
    errors = metrics.get("joint_rmse_deg")
    if isinstance(errors, list) and len(errors) > 1 and _finite(errors[0]) and _finite(errors[-1]) \
            and errors[-1] > _ROSE * errors[0]:
        yield (f"the tracking error rose from {errors[0]:.3g} deg RMS in the first of {len(errors)} trials "
               f"to {errors[-1]:.3g} deg in the last")


def _finite(value: Any) -> bool:
    return isinstance(value, (int, float)) and bool(np.isfinite(value))


def _of_kind(recording: Recorded, kind: str) -> set[str]:
    blocks = recording.experiment.get("blocks", {})
    return {name for name, table in blocks.items() if isinstance(table, dict) and table.get("kind") == kind}


def _when(recording: Recorded, event: Event) -> str:
    trial = f" of trial {event.trial}" if recording.trials > 1 else ""
    return f" at {event.time_ns / 1e9:.3g} s{trial}"
