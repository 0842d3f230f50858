"""The contract of a point search: what is asked of the patient, what is told, and who asks.

    state = strategy.start(space, key)
    while (query := strategy.ask(state)) is not None:
        strategy.tell(state, query, response of the hand to the query)
    strategy.recommend(state)

A strategy is a frozen dataclass of parameters; all that it remembers is in the state, which pickles. `ask`
changes nothing, so that the same state always asks the same, and after the last query it gives None.
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
    """A virtual electrode and what goes through it.

    Attributes
    ----------
    elements: numbers of the elements that share the current equally, ascending.
    current_ma, width_us: of its pulses.
    rested: whether the hand rests beforehand; if not, this follows the query before it at once.
    stair: whether it is one stair of a staircase, judged while the hand still moves, or a level that is held
        until the hand has settled.
    """

    elements: Electrode
    current_ma: float
    width_us: float
    rested: bool = True
    stair: bool = False


class Response(NamedTuple):
    """What the hand made of a query by the tracker: quality, and the movement from rest, (23,), rad."""

    quality: float
    movement: Array


class Found(NamedTuple):
    """The query that a strategy recommends, and the quality that it expects of it."""

    query: Query
    quality: float


class Strategy(Protocol):
    """Who asks."""

    def start(self, space: SearchSpace, key: int) -> Any:
        """A new state; `key` is all the randomness that there is."""

    def ask(self, state: Any) -> Query | None:
        """The next query; None when the search has ended."""

    def tell(self, state: Any, query: Query, response: Response) -> None:
        """Take in the response to the query that was asked."""

    def recommend(self, state: Any) -> Found | None:
        """What is recommended by what has been told; None before anything has been."""


@dataclass(slots=True, eq=False)
class History:
    """State of a strategy that needs no more than what it has been told.

    Attributes
    ----------
    space: where it searches. key: of its randomness.
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
