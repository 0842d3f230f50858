"""Facts about a run that all sections of its report share."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from fesloop.errors import FesloopError
from fesloop.experiment.files.parse import document_of, from_document
from fesloop.experiment.metrics.scoring import metrics_of
from fesloop.experiment.recording.reading import Recording, reached_ns
from fesloop.experiment.running import Experiment
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.skeleton import hand_tree
from fesloop.loop.clock import NS_PER_S
from fesloop.show.best_trial import best_trial
from fesloop.show.picture.cast import Cast, cast_of
from fesloop.show.report.parts import Mark

MOST_TRIALS = 12
"""Drawn in detail (chosen: a page of more takes long to load)."""


@dataclass(frozen=True, slots=True, eq=False)
class Known:
    """A run's recording, and what was found out about it as a whole.

    Attributes
    ----------
    recording: opened.
    begun: how many trials were begun. trials: those that are drawn in detail.
    best: the one that the page opens with (`fesloop.show.best_trial`).
    cast: role of each block; None if unknown.
    metrics: by `fesloop.experiment.metrics.scoring`, as `fesloop run` prints them; none where that fails.
    score: table [score] of the experiment.
    lacks: what could not be read, a sentence each.
    signals: names of what is recorded.
    experiment: as it would be run here and now; None where it cannot, and `not_resolved` says why.
    """

    recording: Recording
    begun: int
    trials: tuple[int, ...]
    cast: Cast | None
    metrics: Mapping[str, Any]
    score: Mapping[str, Any]
    lacks: tuple[str, ...]
    signals: frozenset[str] = field(repr=False)
    experiment: Experiment | None = None
    not_resolved: str = ""
    best: int = 0

    @property
    def last(self) -> int:
        """Number of the last trial that was begun."""
        return self.begun - 1

    @property
    def duration_s(self) -> float | None:
        """Duration of a trial, s; None if the experiment does not state it."""
        found = self.recording.experiment.get("experiment", {}).get("duration_s")
        return None if found is None else float(found)

    def scored(self, key: str) -> str:
        """The signal that stands in the score under a key, if it is recorded; else empty."""
        name = self.score.get(key)
        return name if isinstance(name, str) and name in self.signals else ""

    def per_trial(self, name: str) -> list[float]:
        """A metric that has one number a trial; empty where it is not known, or is another thing."""
        values = self.metrics.get(name)
        if not isinstance(values, list) or not all(isinstance(value, (int, float)) for value in values):
            return []
        return [float(value) for value in values]

    def joints(self, count: int) -> tuple[str, ...]:
        """Names of the values of the scored signals, of which there are `count`."""
        named = tuple(self.score.get("joints") or ())
        return named if len(named) == count else row_names(count)

    def scored_while(self) -> tuple[Mark, ...]:
        """The part of each trial that joint angles are scored on, where it is not all of it."""
        after, end = self.scored_span_s()
        part = after or self.score.get("until_s")
        return (Mark(text="scored", at=after, until=end),) if end is not None and part else ()

    def scored_span_s(self) -> tuple[float, float | None]:
        """Interval over which joint angles are scored, s; it ends at `until_s` or with the trial.

        The end is None if it is unknown.
        """
        ends = (self.score.get("until_s"), self.duration_s, self._reached_s() or None)
        return self.score.get("after_s") or 0.0, min((end for end in ends if end is not None), default=None)

    def _reached_s(self) -> float:
        """Last instant with a true posture in the first trial, s; 0 if unknown."""
        truth = self.scored("truth")
        if not truth or not self.begun:
            return 0.0
        try:
            times_ns = self.recording.signal(truth, 0).times_ns
        except FesloopError:  # what cannot be read is told in `lacks`
            return 0.0
        return round(reached_ns(times_ns) / NS_PER_S, 3)


def row_names(count: int) -> tuple[str, ...]:
    """Names of a signal's components: the hand's degrees of freedom if the number fits, else numbers."""
    freedoms = hand_tree(HandSize()).freedoms
    return freedoms if count == len(freedoms) else tuple(f"joint {number}" for number in range(count))


def known_of(recording: Recording) -> Known:
    """Collect the facts about a run; what cannot be read is listed in `lacks` and raises nothing."""
    lacks: list[str] = []
    begun, cast, metrics = 0, None, {}
    try:
        begun = recording.trials
    except FesloopError as fault:
        lacks.append(f"The number of trials is unknown: {fault}")
    try:
        cast = cast_of(recording)
    except Exception as fault:  # noqa: BLE001 - as in `fesloop.show.report.run.page`
        lacks.append(f"Hand and tracker cannot be identified: {_line(fault)}")
    if begun:
        try:
            metrics = metrics_of(recording)
        except Exception as fault:  # noqa: BLE001 - as in `fesloop.show.report.run.page`
            lacks.append(f"Nothing is scored: {_line(fault)}")
    score = recording.experiment.get("score")
    experiment, not_resolved = _resolved(recording)
    best = best_trial(recording, metrics) if begun else 0
    return Known(recording, begun, _drawn(begun, best), cast, metrics,
                 score if isinstance(score, dict) else {}, tuple(lacks), frozenset(recording.signals),
                 experiment, not_resolved, best)


def _resolved(recording: Recording) -> tuple[Experiment | None, str]:
    """Experiment of a recording, or the reason for which it cannot be resolved."""
    try:
        return from_document(document_of(recording.path), recording.name), ""
    except Exception as fault:  # noqa: BLE001 - as in `fesloop.show.report.run.page`
        return None, _line(fault)


def _drawn(begun: int, best: int) -> tuple[int, ...]:
    """Trials to be shown: the first, the last, some evenly spaced between them, and the best."""
    spaced = np.linspace(0, begun - 1, min(begun, MOST_TRIALS)).round().astype(int)
    return tuple(np.union1d(spaced, [best] if begun else []).astype(int).tolist())


def _line(fault: Exception) -> str:
    """Error message in one line."""
    text = " ".join(str(fault).split())
    return text if isinstance(fault, FesloopError) else f"{type(fault).__name__}: {text}"


def seconds(time_ns: int) -> float:
    """Seconds of an instant in a trial."""
    return time_ns / NS_PER_S
