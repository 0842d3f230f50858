"""Metrics of a point search: its queries, its result, and the minutes that it took."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.experiment.recording.reading import Recording
from fesloop.hand.movements import FREEDOMS, Movement, MovementName, Verdict, movement_of
from fesloop.loop.clock import NS_PER_S

Array = NDArray[np.float64]
Stamps = NDArray[np.int64]
BASELINE, MEASURE, ENDED = 2, 5, 6
"""Phases in a search's output `phase`: measurement at rest, measurement under stimulation, end."""
_SIGNALS = ("query", "phase", "quality", "stimulation", "multiplexing", "best_stimulation",
            "best_multiplexing")


@dataclass(frozen=True, slots=True, kw_only=True)
class SearchScore:
    """Score of a search for elements that cause a movement, by the true movement of the hand.

    Attributes
    ----------
    search: node that searches (`point_search`).
    truth: angles of the hand, (23,), rad.
    movement: the movement that it searches for, or the name of a shipped one.
    optimum: greatest possible quality, from an exhaustive search without noise; None: unknown.
    """

    search: str
    truth: str
    movement: MovementName | Movement
    optimum: float | None = None

    def __post_init__(self) -> None:
        movement_of(self.movement)
        if self.optimum is not None and not (math.isfinite(self.optimum) and self.optimum > 0.0):
            raise InputError("optimum", f"{self.optimum}", "a finite quality above 0")

    @property
    def signals(self) -> tuple[str, ...]:
        """Names of the signals that are read."""
        return (*(f"{self.search}.{name}" for name in _SIGNALS), self.truth)

    def faults(self, shapes: Mapping[str, tuple[int | None, ...]]) -> Iterator[InputError]:
        """Faults: signals that do not exist or do not fit; `shapes` are those of all outputs."""
        if any(name not in shapes for name in self.signals[:-1]):
            yield InputError("score.search.search", f"{self.search!r} is no point search",
                             "a node of that kind")
        if shapes.get(self.truth) != (len(FREEDOMS),):
            yield InputError("score.search.truth", f"{self.truth!r}", "angles of the hand, (23,)")


class Asked(NamedTuple):
    """A query, and the true movement of the hand.

    Attributes
    ----------
    elements, current_ma: elements and current that were tried.
    movement: (23,), rad, from rest. verdict: on it.
    quality: as the search estimated it.
    best: elements and current that it recommended afterwards.
    told_s: instant at which it received the response.
    """

    elements: tuple[int, ...]
    current_ma: float
    movement: Array
    verdict: Verdict
    quality: float
    best: tuple[tuple[int, ...], float]
    told_s: float


class Answered(NamedTuple):
    """A query that was answered.

    Attributes
    ----------
    elements, current_ma: elements and current that were tried.
    quality: as the search estimated it.
    best: elements and current that it recommended afterwards.
    rest_ns, measured_ns: (2,), when the postures at rest and under stimulation were measured; the end of the
        latter is when the search received the response.
    """

    elements: tuple[int, ...]
    current_ma: float
    quality: float
    best: tuple[tuple[int, ...], float]
    rest_ns: tuple[int, int]
    measured_ns: tuple[int, int]


def answered(recording: Recording, search: str, trial: int = 0) -> Iterator[Answered]:
    """Every answered query of the node that searches, in order."""
    kept = {name: recording.signal(f"{search}.{name}", trial) for name in _SIGNALS}
    times, values = kept["query"].times_ns, {name: signal.values for name, signal in kept.items()}
    if not times.size:
        return
    states = np.column_stack((values["query"], values["phase"]))
    starts = np.flatnonzero(np.append(True, (states[1:] != states[:-1]).any(axis=1)))
    rest: tuple[int, int] | None = None
    for first, after in pairwise(starts):
        phase, window = int(values["phase"][first]), (int(times[first]), int(times[after]))
        if phase == BASELINE:
            rest = window
        elif phase == MEASURE and rest is not None:
            best = values["best_multiplexing"][after], values["best_stimulation"][after, 0]
            yield Answered(
                _elements(values["multiplexing"][first, 0]), 1e3 * float(values["stimulation"][first, 0, 0]),
                float(values["quality"][after]), (_elements(best[0]), 1e3 * float(best[1])), rest, window)


def asked_of(recording: Recording, score: SearchScore, trial: int = 0) -> list[Asked]:
    """Every answered query, in order, with the true movement of the hand."""
    truth = recording.signal(score.truth, trial)
    movement = movement_of(score.movement)
    queries: list[Asked] = []
    for each in answered(recording, score.search, trial):
        rest, posture = (_mean(truth.times_ns, truth.values, *window)
                         for window in (each.rest_ns, each.measured_ns))
        moved = posture - rest
        queries.append(Asked(each.elements, each.current_ma, moved, movement.judge(moved), each.quality,
                             each.best, each.measured_ns[1] / NS_PER_S))
    return queries


def _mean(times: Stamps, values: Any, start_ns: int, stop_ns: int) -> Array:
    """Mean posture between two instants; the last one before them if none was recorded in between."""
    first, after = np.searchsorted(times, [start_ns, stop_ns], side="right")
    return np.asarray(values[min(first, after - 1):after].mean(axis=0))


def _elements(shares: Array) -> tuple[int, ...]:
    return tuple(np.flatnonzero(shares).tolist())


def search_metrics(recording: Recording, score: SearchScore) -> dict[str, Any]:
    """Metrics of all trials, in lists of one value per trial.

    `queries`; `minutes` until the search had ended, nan where it had not; of what it recommends
    `found_elements`, `found_ma`; `found_measured_quality`, which the tracker saw in that query, and
    `found_predicted_quality` with `found_predicted_sd`, nan where the strategy predicts none;
    `found_true_quality` and `found_true_selectivity`, by the true movement of the hand in that query, which
    nobody knows of a person; no elements and nan where no query was answered; with an optimum,
    `optimum_share`, the share of it; and `element_quality`, for each element the best true quality of the
    queries with it, None without such a query: a map over the arrays.
    """
    metrics: dict[str, list[Any]] = {}
    for trial in range(recording.trials):
        for name, value in _of_trial(recording, score, trial).items():
            metrics.setdefault(name, []).append(value)
    return metrics


def _of_trial(recording: Recording, score: SearchScore, trial: int) -> dict[str, Any]:
    queries = asked_of(recording, score, trial)
    phase = recording.signal(f"{score.search}.phase", trial)
    over = np.flatnonzero(phase.values == ENDED)
    minutes = phase.times_ns[over[0]] / (60.0 * NS_PER_S) if over.size else math.nan
    count = recording.signal(f"{score.search}.best_multiplexing", trial).values.shape[1]
    elements, current_ma = queries[-1].best if queries else ((), math.nan)
    chosen = next((one for one in reversed(queries)
                   if one.elements == elements and math.isclose(one.current_ma, current_ma)), None)
    quality = chosen.verdict.quality if chosen else math.nan
    predicted, sd = _predicted(recording, score, trial) if queries else (math.nan, math.nan)
    found = {"queries": len(queries), "minutes": float(minutes), "found_elements": list(elements),
             "found_ma": current_ma,
             "found_measured_quality": chosen.quality if chosen else math.nan,
             "found_predicted_quality": predicted, "found_predicted_sd": sd,
             "found_true_quality": quality,
             "found_true_selectivity": chosen.verdict.selectivity if chosen else math.nan}
    if score.optimum is not None:
        found["optimum_share"] = quality / score.optimum
    return found | {"element_quality": element_quality(queries, count)}


def _predicted(recording: Recording, score: SearchScore, trial: int) -> tuple[float, float]:
    """Quality that a search predicts of what it recommends, with its sd; nan where it predicts none."""
    names = [f"{score.search}.best_quality", f"{score.search}.best_quality_sd"]
    if any(name not in recording.signals for name in names):  # recorded before there was one, or left out
        return math.nan, math.nan
    quality, sd = (float(recording.signal(name, trial).values[-1]) for name in names)
    return (quality, sd) if sd > 0.0 else (math.nan, math.nan)


def element_quality(asked: list[Asked], count: int) -> list[float | None]:
    """Best true quality of the queries that each of `count` elements took part in; None without any."""
    best: list[float | None] = [None] * count
    for one in asked:
        for element in one.elements:
            known = best[element]
            best[element] = one.verdict.quality if known is None else max(known, one.verdict.quality)
    return best
