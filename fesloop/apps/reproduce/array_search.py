"""`fesloop reproduce array_search`: elements for a movement are found with a twelfth of the queries.

Searches for finger opening run in the whole loop, with tracker, fatigue and rests, on members of a cohort of
`sci_c6` on whom the search was not tuned. Their anatomy lies up to 30 deg around and 30 mm along the forearm
from where the search expects it. On the next day the arrays are put on anew, and a second search begins with
what the first found out. A recommendation is scored on the rested hand without noise, relative to the best of
an exhaustive search there. Published times are those of the semi-automatic and the
automatic search over 59 elements (doi 10.1186/s12984-018-0460-1).
"""

from __future__ import annotations

import copy
import math
from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.apps.reproduce.cohort import Job, Progress, run_jobs
from fesloop.apps.reproduce.comparison import Band, Row, band, compared
from fesloop.apps.reproduce.result import Reproduction, Sweep
from fesloop.experiment.files.parse import load
from fesloop.experiment.metrics.search import SearchScore, asked_of, search_metrics
from fesloop.experiment.recording.reading import Recording
from fesloop.experiment.running import Experiment
from fesloop.hand.movements import MUSCLES, MovementName, movement_of
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_S, RateClock
from fesloop.loop.signals import Sample, Value

Array = NDArray[np.float64]
Key = tuple[tuple[int, ...], float]
"""Elements, and their current, mA."""
SETTLE_S = 6.0
"""Time after which the hand rests under gravity (chosen: several time constants of the wrist)."""
_TICK_RATE = 40
_STEP_NS = 1_000_000


class RestedHand:
    """The hand of an experiment with nodes `electrodes`, `muscles`, `hand` and `search`, at rest.

    Attributes
    ----------
    space, timetable: of the search. rest: (23,), rad, its posture.
    """

    __slots__ = ("_body", "_electrodes", "_hand", "_muscles", "_none", "_seed", "rest", "space", "timetable")

    def __init__(self, experiment: Experiment) -> None:
        parts: dict[str, Any] = {node.name: node.part for node in experiment.nodes}
        self.space, self.timetable = parts["search"].space, parts["search"].timetable
        self._electrodes, self._hand = parts["electrodes"], parts["hand"]
        self._muscles = replace(parts["muscles"], fatigue=None)
        self._seed = experiment.seed
        self._none = np.zeros(len(MUSCLES))
        self._body = self._hand.init(Context("hand", self._seed))
        for now in range(0, int(SETTLE_S * NS_PER_S), _STEP_NS):
            self._hand.advance(self._body, [self._none], now, now + _STEP_NS)
        self.rest: Array = self._hand.glance(self._body)[0]

    def responses(self, queries: Iterable[Key]) -> dict[Key, Array]:
        """Movement from rest, (23,), rad, for each query."""
        return {query: self.response(*query) for query in queries}

    def response(self, elements: tuple[int, ...], current_ma: float) -> Array:
        """Movement from rest, (23,), rad, during the measurement of a query; zeros if it excites no axon."""
        times = self.timetable
        ticks = [round(seconds * _TICK_RATE) for seconds in (times.ramp_s, times.settle_s, times.measure_s)]
        shares = [*(0.5 + 0.5 * k / ticks[0] for k in range(ticks[0])), *(1.0,) * sum(ticks[1:])]
        whole = self._recruited(elements, current_ma, 1.0)
        if not whole[0].any():
            return np.zeros_like(self.rest)
        drives = {share: self._recruited(elements, current_ma, share) for share in dict.fromkeys(shares)}
        muscles, hand = self._muscles.init(Context("muscles", self._seed)), copy.deepcopy(self._body)
        now, per_tick, seen = int(SETTLE_S * NS_PER_S), NS_PER_S // _TICK_RATE // _STEP_NS, []
        for share in shares:
            for _ in range(per_tick):
                velocity = self._hand.glance(hand)[9] if self._muscles.reflex is not None else self._none
                inputs = [*drives[share], velocity, self._none]
                activation = self._muscles.read(muscles, inputs)[0]
                self._hand.advance(hand, [activation], now, now + _STEP_NS)
                self._muscles.advance(muscles, inputs, now, now + _STEP_NS)
                now += _STEP_NS
            seen.append(self._hand.glance(hand)[0])
        mean: Array = np.mean(seen[-ticks[2]:], axis=0)
        return mean - self.rest

    def _recruited(self, elements: tuple[int, ...], current_ma: float, share: float) -> tuple[Array, Array]:
        """Recruitment and frequency, (29,) each, at a share of the pulse width."""
        clock, tick = RateClock.from_rate(_TICK_RATE), Tick()
        state = self._electrodes.init(Context("electrodes", self._seed, 0, clock))
        pulses = np.zeros((self._electrodes.elements, 3))
        pulses[list(elements)] = (1e-3 * current_ma / len(elements), 1e-6 * share * self.space.width_us,
                                  float(_TICK_RATE))
        values: tuple[Value, ...] = (pulses, 0.0, np.ones(len(pulses)), np.zeros(2))
        stamps = (0, -1, -1, -1)
        recruitment, frequency = self._electrodes.step(
            state, [Sample(value, at, at, at) for value, at in zip(values, stamps, strict=True)], tick)
        return recruitment, frequency


SUBJECTS = 20
FIRST_MEMBER = 2
"""The Gaussian process was tuned on members of another cohort, and of this one on members 0 and 1 alone."""
_ELSEWHERE = 30.0
"""Greatest displacement of a person's anatomy, deg around the forearm and mm along it."""
MOVEMENT: MovementName = "finger_opening"
SEARCHES = {"gp": "array_search_gp", "magnets": "array_search_magnets", "two_phase": "array_search_two_phase"}
REACHED = 0.9
MOST_PCT = 8.0
"""Share of an exhaustive search that the whole search may take: less than half of the fifth at which Bayesian
optimisation in neurostimulation is published to converge."""
LEAST_THERE = 0.95
"""Share of persons in whom it gets to 90 % of the optimum."""
AGAIN_SHARE = 0.1
"""Queries to 90 % on the second day over all queries of the first."""
SEMI_AUTOMATIC_MIN, AUTOMATIC_MIN = 7.3, 10.5
_SCORE = SearchScore(search="search", truth="hand.angles", movement=MOVEMENT)


def searched(recording: Recording) -> dict[str, Any]:
    """Return what a search recommended after each query, with its quality and time.

    Under `worth` the quality of each recommendation on the rested hand, (n,); `told_min` (n,); `found`, the
    last recommendation; `minutes` until it had ended; `selectivity` of what was found; `asked`, elements of
    every query and what the search thought of it.
    """
    asked = asked_of(recording, _SCORE)
    hand = RestedHand(load(recording.path))
    judge = movement_of(MOVEMENT).judge
    verdicts = {best: judge(movement)
                for best, movement in hand.responses(dict.fromkeys(one.best for one in asked)).items()}
    found = asked[-1].best
    return {"worth": np.array([verdicts[one.best].quality for one in asked]),
            "told_min": np.array([one.told_s / 60.0 for one in asked]), "found": found,
            "minutes": search_metrics(recording, _SCORE)["minutes"][0],
            "selectivity": verdicts[found].selectivity,
            "asked": [(one.elements, one.quality) for one in asked]}


def displaced(member: int, day: int) -> tuple[str, ...]:
    """Settings of a member on a day, whose anatomy lies elsewhere; the arrays' edges stay on the forearm."""
    around, along = np.random.default_rng(member).uniform(-_ELSEWHERE, _ELSEWHERE, 2)
    usual = (f"member={member}", f"day={day}")
    parts: dict[str, Any] = {node.name: node.part for node in load("array_search_gp", usual).nodes}
    electrodes = parts["electrodes"]
    from_elbow_mm = electrodes.places[:, 1]
    along = float(np.clip(along, -from_elbow_mm.min(), electrodes.length_mm - from_elbow_mm.max()))
    return (*usual, f"blocks.electrodes.shift_deg={electrodes.shift_deg + float(around)!r}",
            f"blocks.electrodes.shift_mm={electrodes.shift_mm + along!r}")


def searched_beside_everything(recording: Recording) -> dict[str, Any]:
    """As `searched`, with the quality of every candidate on the rested hand under `everything`."""
    hand, judge = RestedHand(load(recording.path)), movement_of(MOVEMENT).judge
    every = hand.responses((electrode, current) for electrode in hand.space.electrodes
                           for current in hand.space.currents_ma)
    return searched(recording) | {
        "everything": {query: judge(moved).quality for query, moved in every.items()},
        "layouts": [(layout.rows, layout.columns) for layout in hand.space.layouts]}


def searched_on_two_days(recording: Recording) -> dict[str, Any]:
    """As `searched_beside_everything`; under `again` the same of the next day's search, which knows this."""
    settings = displaced(recording.experiment["patient"]["member"], 2)
    again = Job(("again",), "array_search_gp", (*settings, f"earlier={recording.path}"), 1,
                searched_beside_everything)
    return searched_beside_everything(recording) | {"again": again.kept()}


def run(subjects: int = SUBJECTS, workers: int = 1, progress: Progress | None = None) -> Reproduction:
    """Run every search on every patient."""
    members = range(FIRST_MEMBER, FIRST_MEMBER + subjects)
    jobs = [Job((name, member), experiment, displaced(member, 1), 1,
                searched_on_two_days if name == "gp" else searched)
            for member in members for name, experiment in SEARCHES.items()]
    kept = run_jobs(jobs, workers, progress)
    return compare([{name: kept[name, member] for name in SEARCHES} for member in members])


def compare(patients: list[dict[str, Any]]) -> Reproduction:
    """Make rows and tables of the results of each search on each patient."""
    table = [_of_patient(patient) for patient in patients]
    columns = {name: np.array([row[name] for row in table]) for name in table[0]}
    rows = [*_of_gaussian_process(columns), *_of_others(columns)]
    each = Sweep(title="Finger opening, patient by patient", unit="as told", columns=tuple(columns),
                 rows=tuple((f"member {FIRST_MEMBER + number}", tuple(float(value) for value in row.values()))
                            for number, row in enumerate(table)))
    return Reproduction("array_search", len(patients), rows, {"patients": each}, {"patients": patients})


def _of_patient(patient: dict[str, Any]) -> dict[str, float]:
    """Figures of a patient; NaN for what was never reached."""
    everything = patient["gp"]["everything"]
    optimum = max(everything.values())
    row = {"optimum": optimum, "candidates": float(len(everything))}
    for name in SEARCHES:
        kept = patient[name]
        queries, minutes = reached(kept["worth"] / optimum, kept["told_min"])
        row |= {f"{name}: queries to 90 %": queries, f"{name}: min to 90 %": minutes,
                f"{name}: queries": float(len(kept["worth"])), f"{name}: min": kept["minutes"],
                f"{name}: found, % of optimum": 100.0 * float(kept["worth"][-1]) / optimum,
                f"{name}: selectivity": kept["selectivity"]}
    again = patient["gp"]["again"]
    shares = again["worth"] / max(again["everything"].values())
    queries, minutes = reached(shares, again["told_min"])
    return row | {
        "next day: queries to 90 %": queries, "next day: min to 90 %": minutes,
        "next day: queries": float(len(shares)), "next day: found, % of optimum": 100.0 * float(shares[-1])}


def reached(shares: Array, told_min: Array) -> tuple[float, float]:
    """Queries and minutes after which all recommendations reach 90 % of the optimum; NaN if never."""
    below = np.flatnonzero(~(shares >= REACHED))
    first = int(below[-1]) + 1 if below.size else 0
    return (math.nan, math.nan) if first >= len(shares) else (float(first + 1), float(told_min[first]))


def _of_gaussian_process(columns: dict[str, Array]) -> list[Row]:
    """Rows of queries and time; a patient in whom 90 % is never reached counts as searched exhaustively."""
    total = columns["candidates"]
    whole, minutes = band(100.0 * columns["gp: queries"] / total), band(columns["gp: min"])
    found = columns["gp: found, % of optimum"]
    there, count = int((found >= 100.0 * REACHED).sum()), len(found)
    again = columns["next day: queries to 90 %"]
    share = band(np.where(np.isnan(again), total, again) / columns["gp: queries"])
    least, gp = math.ceil(LEAST_THERE * count), "Gaussian process"
    return [
        Row(gp, "patients in whom 90 % of the optimum is found, at least", f"{least} of {count}",
            f"{there} of {count}", there >= least),
        Row(gp, "queries of the whole search, of an exhaustive one's; at most", MOST_PCT, whole,
            whole.median <= MOST_PCT, "%"),
        Row(gp, "whole search; at most the semi-automatic one's", SEMI_AUTOMATIC_MIN, minutes,
            minutes.high <= SEMI_AUTOMATIC_MIN, "min"),
        Row(gp, "found, at least 90 % of the optimum", 100.0 * REACHED, band(found),
            bool(np.median(found) >= 100.0 * REACHED), "%"),
        Row("next day", "queries to 90 % of the optimum over all of the first day's, at most", AGAIN_SHARE,
            share, share.median <= AGAIN_SHARE)]


def _of_others(columns: dict[str, Array]) -> list[Row]:
    """Rows of the published two-phase search, and of the search with a tracker near magnets."""
    ours, theirs = columns["gp: min"], columns["two_phase: min"]
    plain, magnets = columns["gp: queries to 90 %"], columns["magnets: queries to 90 %"]
    both = ~np.isnan(plain) & ~np.isnan(magnets)
    more = band(magnets[both] - plain[both]) if both.any() else Band(math.nan, math.nan, math.nan)
    faster = int((ours < theirs).sum())
    found = float(np.median(columns["gp: found, % of optimum"]))
    lost = int(np.isnan(magnets).sum())
    return [
        compared("two phases", "whole search", AUTOMATIC_MIN, band(theirs), "min"),
        Row("two phases", "patients in whom the Gaussian process is faster", "all",
            f"{faster} of {len(ours)}", faster == len(ours)),
        Row("two phases", "found, share of the optimum; beside it that of the Gaussian process", found,
            band(columns["two_phase: found, % of optimum"]),
            bool(found >= np.median(columns["two_phase: found, % of optimum"])), "%"),
        Row("magnets", "more queries to 90 % through salchow_b, and patients in whom it never gets there",
            "more", f"{more.median:.0f} ({more.low:.0f} to {more.high:.0f}), {lost} of {len(plain)}",
            bool(lost or more.median > 0.0))]
