"""The strategies by name, each with a table of its own."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from controllers.point_search.contract import Strategy
from controllers.point_search.exhaustive import Exhaustive, Listed, Random

StrategyName = Literal["exhaustive", "listed", "random"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Strategies:
    """Parameters of each strategy; those of the ones that are not chosen are left alone."""

    exhaustive: Exhaustive = field(default_factory=Exhaustive)
    listed: Listed = field(default_factory=Listed)
    random: Random = field(default_factory=Random)

    def named(self, name: StrategyName) -> Strategy:
        """The one of a name."""
        strategy: Strategy = getattr(self, name)
        return strategy
