"""Strategies that do not learn: all candidates in order, a list, and random order."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from controllers.point_search.contract import Found, History, Query, Response, best_told
from controllers.point_search.space import SearchSpace
from fesloop.errors import InputError


def candidates(space: SearchSpace) -> list[Query]:
    """Every virtual electrode of the space at every current."""
    return [Query(elements=electrode, current_ma=current, width_us=space.width_us)
            for electrode in space.electrodes for current in space.currents_ma]


@dataclass(frozen=True, slots=True, kw_only=True)
class Exhaustive:
    """Every virtual electrode at every current, once: the reference for other strategies."""

    def start(self, space: SearchSpace, key: int) -> History:
        """State without responses."""
        return History(space, key, [])

    def ask(self, state: History) -> Query | None:
        """Next candidate in order."""
        turn, space = len(state.told), state.space
        electrode, level = divmod(turn, len(space.currents_ma))
        if electrode >= len(space.electrodes):
            return None
        return Query(elements=space.electrodes[electrode], current_ma=space.currents_ma[level],
                     width_us=space.width_us)

    def tell(self, state: History, query: Query, response: Response) -> None:
        """Record the response."""
        state.told.append((query, response))

    def recommend(self, state: History) -> Found | None:
        """Query of the best measured quality."""
        return best_told(state.told)


@dataclass(frozen=True, slots=True, kw_only=True)
class Listed:
    """Given queries in order, such as the recommendations of other searches.

    Attributes
    ----------
    elements: elements of each query.
    current_ma: current of each query.
    """

    elements: tuple[tuple[int, ...], ...] = ()
    current_ma: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        if len(self.elements) != len(self.current_ma):
            raise InputError("listed", f"{len(self.elements)} electrodes and {len(self.current_ma)} currents",
                             "equally many")

    def start(self, space: SearchSpace, key: int) -> History:
        """State without responses. Raises InputError for a query that is not in the space."""
        for electrode, current in zip(self.elements, self.current_ma, strict=True):
            if not electrode or not set(space.usable).issuperset(electrode) or (
                    len(set(electrode)) < len(electrode)):
                raise InputError("listed.elements", f"{electrode}", "elements of the space, each once")
            if not 0.0 < current <= space.current_max_ma:
                raise InputError("listed.current_ma", f"{current:g}", f"above 0, to {space.current_max_ma:g}")
        return History(space, key, [])

    def ask(self, state: History) -> Query | None:
        """Next query of the list."""
        turn = len(state.told)
        if turn >= len(self.elements):
            return None
        return Query(elements=tuple(sorted(self.elements[turn])), current_ma=self.current_ma[turn],
                     width_us=state.space.width_us)

    def tell(self, state: History, query: Query, response: Response) -> None:
        """Record the response."""
        state.told.append((query, response))

    def recommend(self, state: History) -> Found | None:
        """Query of the best measured quality."""
        return best_told(state.told)


@dataclass(frozen=True, slots=True, kw_only=True)
class Random:
    """Candidates of the exhaustive search in random order, none twice: a baseline for any method.

    Attributes
    ----------
    queries: number of queries, limited by the number of candidates.
    """

    queries: int = 100

    def __post_init__(self) -> None:
        if self.queries < 1:
            raise InputError("random.queries", f"{self.queries}", "1 or more")

    def start(self, space: SearchSpace, key: int) -> History:
        """State without responses."""
        return History(space, key, [])

    def ask(self, state: History) -> Query | None:
        """Next candidate of the random order."""
        turn, every = len(state.told), candidates(state.space)
        if turn >= min(self.queries, len(every)):
            return None
        order = np.random.Generator(np.random.Philox(key=state.key)).permutation(len(every))
        return every[int(order[turn])]

    def tell(self, state: History, query: Query, response: Response) -> None:
        """Record the response."""
        state.told.append((query, response))

    def recommend(self, state: History) -> Found | None:
        """Query of the best measured quality."""
        return best_told(state.told)
