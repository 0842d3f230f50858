"""Contract between a point search and its strategies: queries, responses, recommendation.

    state = strategy.start(space, key)
    while (query := strategy.ask(state)) is not None:
        strategy.tell(state, query, response of the hand to the query)
    strategy.recommend(state)

A strategy is a frozen dataclass of parameters; its memory is in the state, which can be pickled. `ask` does
not change the state, so that equal states give equal queries; after the last query it returns None.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from controllers.point_search.space import Electrode, SearchSpace

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Query:
    """Virtual electrode and its pulses.

    Attributes
    ----------
    elements: numbers of the elements that share the current equally, ascending.
    current_ma, width_us: current and width of its pulses.
    rested: whether the hand rests before it; if not, it follows the query before at once.
    stair: whether it is one stair of a staircase, rated while the hand still moves, or a level that is held
        until the hand has settled.
    """

    elements: Electrode
    current_ma: float
    width_us: float
    rested: bool = True
    stair: bool = False


class Response(NamedTuple):
    """Response to a query by the tracker: its quality, and the movement from rest, (23,), rad."""

    quality: float
    movement: Array


class Found(NamedTuple):
    """Recommended query, and its quality: predicted with a standard deviation, or with 0 the measured one."""

    query: Query
    quality: float
    sd: float = 0.0


class Strategy(Protocol):
    """Strategy of a point search."""

    def start(self, space: SearchSpace, key: int) -> Any:
        """A new state; all randomness follows from `key`."""

    def ask(self, state: Any) -> Query | None:
        """The next query; None when the search has ended."""

    def tell(self, state: Any, query: Query, response: Response) -> None:
        """Record the response to the last query."""

    def recommend(self, state: Any) -> Found | None:
        """Recommendation from the responses so far; None without any."""


@dataclass(slots=True, eq=False)
class History:
    """State of a strategy that needs the responses alone.

    Attributes
    ----------
    space: search space.
    key: key of its randomness.
    told: queries with their responses, in order.
    """

    space: SearchSpace
    key: int
    told: list[tuple[Query, Response]]


def best_told(told: list[tuple[Query, Response]]) -> Found | None:
    """The query with the greatest measured quality; the first of several."""
    if not told:
        return None
    query, response = max(told, key=lambda pair: pair[1].quality)
    return Found(query, response.quality)
