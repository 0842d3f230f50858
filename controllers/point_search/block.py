"""`point_search`: search for elements and charge that produce a movement, by test stimulation."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, cast, get_args

import numpy as np
from numpy.typing import NDArray

from controllers.point_search.contract import Query, Response, Strategy
from controllers.point_search.earlier import EarlierSearch
from controllers.point_search.prior_zones import ZONES
from controllers.point_search.space import SearchSpace
from controllers.point_search.state import BASELINE, BEGIN, ENDED, MEASURE, Look, PointSearchState, Timetable
from controllers.point_search.strategies import Strategies, StrategyName
from fesloop.errors import InputError
from fesloop.forms.schema import plain
from fesloop.hand.movements import (
    FREEDOMS,
    Movement,
    MovementName,
    movement_label,
    movement_of,
    movement_text,
)
from fesloop.loop.abilities import Passage
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_S, duration_ns
from fesloop.loop.noise import stream_key
from fesloop.loop.signals import Port, Sample, Value, is_finite
from fesloop.models.electrode_arrays import USUAL, ElectrodeArrays

Array = NDArray[np.float64]
REPEATS = 2
"""Repetitions of a query without an observed response (chosen)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PointSearch:
    """Search for the elements of the arrays, and the current, that produce a movement.

    After a rest a query is stimulated through channel 0. The movement from the mean posture of that rest to
    the mean posture under the query is rated (`fesloop.hand.movements`). A strategy
    (`controllers.point_search.contract`) chooses the queries. When it has no more, the search has ended:
    status `search_ended` with its recommendation, and no more pulses.

    Inputs: `angles` (23,), rad, from a tracker; optional `angle_sd` (23,), rad: freedoms with an sd of pi
    (unknown), at rest or afterwards, count as not moved. Outputs: `stimulation` (1, 2), A and s;
    `multiplexing` (1, elements), share of the current that each element has; `query`, number of the
    present or last one from 0, -1 before; `phase`, of `controllers.point_search.state`; `quality`, of
    the last response; `best_quality`, `best_stimulation` (2,), `best_multiplexing` (elements,): the
    strategy's recommendation, 0 before it has one; `best_quality_sd`, the standard deviation with which
    `gaussian_process` predicts that quality, 0 for strategies that take the measured one.

    Statuses: `search_ended`; `untracked`, with the freedoms; `bad_input` for angles that are not finite and
    are ignored; `no_response` where no posture arrived in time: the query is repeated, and after two
    repetitions without a posture the search ends as `search_failed`.

    Attributes
    ----------
    movement: movement that is searched for, or the name of a shipped one. One of your own has no zones where
        anatomy suggests it, unless `space` states them.
    strategy: name of the strategy.
    strategies: parameters of each strategy.
    space: search space.
    timetable: durations.
    earlier: search of the same movement on another day, from the recording of its run; for
        `gaussian_process`.
    """

    movement: MovementName | Movement = "finger_opening"
    strategy: StrategyName = "exhaustive"
    strategies: Strategies = field(default_factory=Strategies)
    space: SearchSpace = field(default_factory=SearchSpace)
    timetable: Timetable = field(default_factory=Timetable)
    earlier: EarlierSearch = field(default_factory=EarlierSearch)

    def __post_init__(self) -> None:
        movement_of(self.movement)
        if not hasattr(self.strategies, self.strategy):
            raise InputError("strategy", f"{self.strategy!r}", ", ".join(get_args(StrategyName)))
        if not self.space.zones and isinstance(self.movement, str):
            object.__setattr__(self, "space", replace(self.space, zones=ZONES[self.movement]))
        if self.earlier.responses:
            self._require_alike()
            object.__setattr__(self, "space", replace(self.space, earlier=self.earlier))
        self.chosen.start(self.space, 0)

    def _require_alike(self) -> None:
        """Raise InputError for an earlier search of which this one makes no use."""
        if self.strategy != "gaussian_process":
            raise InputError("earlier", f"is not used by the strategy {self.strategy}", "gaussian_process",
                             "leave it out, or choose that strategy")
        own = self.movement if isinstance(self.movement, str) else plain(self.movement)
        if self.earlier.movement != movement_text(own):
            raise InputError("earlier", f"is a search for {self.earlier.movement or 'no movement'}",
                             f"one for {movement_label(self.movement)}")
        usual = tuple(array.layout for array in USUAL)
        if (self.earlier.layouts or usual) != self.space.layouts:
            raise InputError("earlier", "is a search of other arrays", "a search with the same arrays")
        electrodes = set(self.space.electrodes)
        if not any(each.elements in electrodes for each in self.earlier.responses):
            raise InputError("earlier", "tried no electrode of these arrays", "a search with the same arrays")

    @property
    def chosen(self) -> Strategy:
        """Strategy in use."""
        return self.strategies.named(self.strategy)

    @property
    def inputs(self) -> tuple[Port, ...]:
        """`angles`, `angle_sd`."""
        each = (len(FREEDOMS),)
        return Port("angles", each, "rad"), Port("angle_sd", each, "rad", optional=True)

    @property
    def outputs(self) -> tuple[Port, ...]:
        """Pulses, their elements, progress of the search, and the recommendation."""
        count = self.space.count
        return (Port("stimulation", (1, 2), "A,s"), Port("multiplexing", (1, count), "1"),
                Port("query", (), "1", -1.0), Port("phase", (), "1"), Port("quality", (), "1"),
                Port("best_quality", (), "1"), Port("best_stimulation", (2,), "A,s"),
                Port("best_multiplexing", (count,), "1"), Port("best_quality_sd", (), "1"))

    def passages(self, context: Context) -> tuple[Passage, ...]:
        """Inputs have an effect once the query is over."""
        return (Passage(inputs=("angles", "angle_sd"), later="once its query is over"),)

    @classmethod
    def for_arrays(cls, arrays: ElectrodeArrays, own: Mapping[str, Any], wired: Collection[str]
                   ) -> dict[str, Any]:
        """The places of the elements."""
        return {"space": {"layouts": [plain(array.layout) for array in arrays.arrays]}}

    def of_arrays(self) -> list[tuple[str, str]]:
        """Number of candidates of the search."""
        single = sum(len(each) == 1 for each in self.space.electrodes)
        return [("candidates", f"{single} elements and {len(self.space.electrodes) - single} pairs side by "
                 f"side, up to {self.space.current_max_ma:g} mA")]

    def init(self, context: Context) -> PointSearchState:
        """State before the first query."""
        key = stream_key(context.seed, f"{context.name}/search", context.trial)
        begin_ns = duration_ns(self.timetable.begin_s, NS_PER_S, "timetable.begin_s")
        look = Look(np.zeros(len(FREEDOMS)), np.zeros(len(FREEDOMS)))
        return PointSearchState(self.chosen.start(self.space, key), look, begin_ns)

    def step(self, state: PointSearchState, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """Observe the hand, change the phase where one is over, stimulate."""
        if state.phase in (BASELINE, MEASURE):
            self._look(state, inputs, tick)
        while state.phase != ENDED and tick.time_ns >= state.until_ns:
            self._go_on(state, tick)
        return self._outputs(state, tick.time_ns)

    def _look(self, state: PointSearchState, inputs: Sequence[Sample], tick: Tick) -> None:
        """Record the present posture."""
        angles, sd = (cast(Array, sample.value) for sample in inputs)
        arrived_ns = inputs[0].arrived_ns
        sound = is_finite(angles)
        state.latch.put(tick, "bad_input", arrived_ns >= 0 and not sound, "angles are not finite: ignored")
        unseen = sd >= math.pi
        names = ", ".join(name for name, hidden in zip(FREEDOMS, unseen, strict=True) if hidden)
        state.latch.put(tick, "untracked", bool(names), f"{names}: count as not moved")
        if arrived_ns >= 0 and sound:
            state.look.take(angles, unseen, arrived_ns)

    def _go_on(self, state: PointSearchState, tick: Tick) -> None:
        """Change to the next phase."""
        if state.phase == BASELINE:
            state.rest = state.look.end()
        if state.phase == MEASURE:
            self._hear(state, tick)
        elif state.phase == BEGIN:
            self._ask(state, tick)
        else:
            assert state.query is not None
            self._enter(state, self.timetable.after(state.phase, state.query), tick)

    def _hear(self, state: PointSearchState, tick: Tick) -> None:
        """Give the strategy the response to the query, and ask it for the next."""
        assert state.query is not None
        posture = state.look.end()
        if posture is None or state.rest is None:
            tick.report("no_response", f"query {state.number}: no posture arrived in time")
            state.repeats += 1
            if state.repeats > REPEATS:
                self._end(state, tick, "search_failed",
                      f"query {state.number} was stimulated {state.repeats} times")
            else:
                self._enter(state, self.timetable.first(state.query), tick)
            return
        movement = np.nan_to_num(posture - state.rest, nan=0.0)
        state.quality = movement_of(self.movement).judge(movement).quality
        self.chosen.tell(state.strategy, state.query, Response(state.quality, movement))
        state.best = self.chosen.recommend(state.strategy)
        self._ask(state, tick)

    def _ask(self, state: PointSearchState, tick: Tick) -> None:
        """Start the next query, or end the search."""
        query = self.chosen.ask(state.strategy)
        if query is None:
            self._end(state, tick, "search_ended", _in_words(state))
            return
        state.query, state.repeats = query, 0
        state.number += 1
        self._enter(state, self.timetable.first(query), tick)

    def _enter(self, state: PointSearchState, phase: int, tick: Tick) -> None:
        assert state.query is not None
        state.phase, state.since_ns = phase, tick.time_ns
        state.until_ns = tick.time_ns + self.timetable.lasts_ns(phase, state.query)

    def _end(self, state: PointSearchState, tick: Tick, status: str, detail: str) -> None:
        state.query, state.phase, state.since_ns = None, ENDED, tick.time_ns
        tick.report(status, detail)

    def _outputs(self, state: PointSearchState, now_ns: int) -> tuple[Value, ...]:
        pulses, shares = np.zeros((1, 2)), np.zeros((1, self.space.count))
        share = self.timetable.width_share(state.phase, now_ns - state.since_ns)
        if state.query is not None and share > 0.0:
            pulses[0], shares[0] = _pulse(state.query, share), self._shares(state.query)
        best_quality, sd, best_pulse, best_shares = 0.0, 0.0, np.zeros(2), np.zeros(self.space.count)
        if state.best is not None:
            best_quality, sd = state.best.quality, state.best.sd
            best_pulse, best_shares = _pulse(state.best.query, 1.0), self._shares(state.best.query)
        return (pulses, shares, float(state.number), float(state.phase), state.quality, best_quality,
                best_pulse, best_shares, sd)

    def _shares(self, query: Query) -> Array:
        """Share of the current that each element has, (elements,)."""
        shares = np.zeros(self.space.count)
        shares[list(query.elements)] = 1.0 / len(query.elements)
        return shares


def _pulse(query: Query, share: float) -> Array:
    """Current, A, and a share of the pulse width, s, of a query."""
    return np.array([query.current_ma / 1e3, share * query.width_us / 1e6])


def _in_words(state: PointSearchState) -> str:
    """Text of the search's result."""
    if state.best is None:
        return "there was no query"
    query, quality, sd = state.best
    elements = "+".join(map(str, query.elements))
    spread = f" +- {sd:.2f}" if sd else ""
    return (f"element {elements} at {query.current_ma:g} mA, {query.width_us:g} us: "
            f"quality {quality:.2f}{spread} by the tracker, {state.number + 1} queries")
