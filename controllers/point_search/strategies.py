"""The strategies by name, each with a table of its own."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from controllers.point_search.contract import Strategy
from controllers.point_search.exhaustive import Exhaustive, Listed, Random
from controllers.point_search.gaussian_process import GaussianProcess
from controllers.point_search.optuna_search import OptunaSearch
from controllers.point_search.semi_automatic import SemiAutomatic
from controllers.point_search.two_phase import TwoPhase

StrategyName = Literal["exhaustive", "listed", "random", "two_phase", "semi_automatic", "gaussian_process",
                       "optuna"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Strategies:
    """Parameters of each strategy; those of the ones that are not chosen are left alone."""

    exhaustive: Exhaustive = field(default_factory=Exhaustive)
    listed: Listed = field(default_factory=Listed)
    random: Random = field(default_factory=Random)
    two_phase: TwoPhase = field(default_factory=TwoPhase)
    semi_automatic: SemiAutomatic = field(default_factory=SemiAutomatic)
    gaussian_process: GaussianProcess = field(default_factory=GaussianProcess)
    optuna: OptunaSearch = field(default_factory=OptunaSearch)

    def named(self, name: StrategyName) -> Strategy:
        """The one of a name."""
        strategy: Strategy = getattr(self, name)
        return strategy
