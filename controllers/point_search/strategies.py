"""Strategies by name with their parameters, and the two-phase staircase."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import isfinite
from typing import Literal

from controllers.point_search.contract import Found, Query, Response, Strategy
from controllers.point_search.exhaustive import Exhaustive, Listed, Random
from controllers.point_search.gaussian_process import GaussianProcess
from controllers.point_search.optuna_search import OptunaSearch
from controllers.point_search.semi_automatic import SemiAutomatic
from controllers.point_search.space import Electrode, SearchSpace, joined
from fesloop.errors import InputError


@dataclass(slots=True, eq=False)
class TwoPhaseState:
    """State of the staircases.

    Attributes
    ----------
    space: search space.
    electrodes: electrodes in the order of their staircases.
    climbed: number of finished staircases.
    stair: number of the next stair of the present one, from 0.
    second: whether the second phase has begun.
    found: best stair of each electrode.
    """

    space: SearchSpace
    electrodes: list[Electrode]
    climbed: int = 0
    stair: int = 0
    second: bool = False
    found: dict[Electrode, Found] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, kw_only=True)
class TwoPhase:
    """Staircases of charge from zero to the tolerated one, first on every element, then on combinations.

    Every stair is rated; the quality of an electrode is that of its best stair. The `best` elements of the
    first phase are combined in pairs in the second. The patient's push-button of the source is not modelled.

    Attributes
    ----------
    step_uc: charge per phase from stair to stair (the source: .01 of a normalised charge; of what is chosen:
        of 20 uC, the limit of the `safety` block).
    best: number of elements that are combined (five in the source).
    """

    step_uc: float = 0.2
    best: int = 5

    def __post_init__(self) -> None:
        if not (isfinite(self.step_uc) and self.step_uc > 0.0):
            raise InputError("two_phase.step_uc", f"{self.step_uc}", "a finite charge above 0")
        if self.best < 1:
            raise InputError("two_phase.best", f"{self.best}", "1 or more")

    def start(self, space: SearchSpace, key: int) -> TwoPhaseState:
        """State with single elements. Raises InputError where the first stair exceeds the limit of charge."""
        if self.stairs(space) < 1:
            raise InputError("two_phase.step_uc", f"{self.step_uc:g}",
                             f"at most {1e-3 * space.current_max_ma * space.width_us:g}, the tolerated one")
        return TwoPhaseState(space, [(element,) for element in space.usable])

    def stairs(self, space: SearchSpace) -> int:
        """Number of stairs of a staircase."""
        return int(1e-3 * space.current_max_ma * space.width_us / self.step_uc + 1e-9)

    def ask(self, state: TwoPhaseState) -> Query | None:
        """Next stair."""
        if state.climbed >= len(state.electrodes):
            return None
        current_ma = 1e3 * self.step_uc * (state.stair + 1) / state.space.width_us
        return Query(elements=state.electrodes[state.climbed],
                     current_ma=min(current_ma, state.space.current_max_ma), width_us=state.space.width_us,
                     rested=state.stair == 0, stair=True)

    def tell(self, state: TwoPhaseState, query: Query, response: Response) -> None:
        """Record the stair, and change to the next electrode after the last one."""
        before = state.found.get(query.elements)
        if before is None or response.quality > before.quality:
            state.found[query.elements] = Found(query, response.quality)
        state.stair += 1
        if state.stair >= self.stairs(state.space):
            state.climbed, state.stair = state.climbed + 1, 0
            if state.climbed >= len(state.electrodes) and not state.second:
                state.second = True
                state.electrodes = [*state.electrodes, *self._combined(state)]

    def best_of(self, state: TwoPhaseState) -> list[Found]:
        """Tried electrodes, best first."""
        return sorted(state.found.values(), key=lambda found: -found.quality)

    def _combined(self, state: TwoPhaseState) -> list[Electrode]:
        """Combinations of the best elements."""
        best = tuple(found.query.elements for found in self.best_of(state)[:self.best])
        return joined(best, state.space.most_elements)

    def recommend(self, state: TwoPhaseState) -> Found | None:
        """Best stair of all."""
        return next(iter(self.best_of(state)), None)


StrategyName = Literal["exhaustive", "listed", "random", "two_phase", "semi_automatic", "gaussian_process",
                       "optuna"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Strategies:
    """Parameters of each strategy; only those of the chosen one have an effect."""

    exhaustive: Exhaustive = field(default_factory=Exhaustive)
    listed: Listed = field(default_factory=Listed)
    random: Random = field(default_factory=Random)
    two_phase: TwoPhase = field(default_factory=TwoPhase)
    semi_automatic: SemiAutomatic = field(default_factory=SemiAutomatic)
    gaussian_process: GaussianProcess = field(default_factory=GaussianProcess)
    optuna: OptunaSearch = field(default_factory=OptunaSearch)

    def named(self, name: StrategyName) -> Strategy:
        """Strategy of a name."""
        strategy: Strategy = getattr(self, name)
        return strategy
