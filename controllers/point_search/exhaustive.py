"""Strategies that do not learn: everything in turn, a list, and at random."""

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
    """Every virtual electrode at every current, once: the yardstick of what there is to be found."""

    def start(self, space: SearchSpace, key: int) -> History:
        """Nothing told yet."""
        return History(space, key, [])

    def ask(self, state: History) -> Query | None:
        """The next in turn."""
        turn, space = len(state.told), state.space
        electrode, level = divmod(turn, len(space.currents_ma))
        if electrode >= len(space.electrodes):
            return None
        return Query(elements=space.electrodes[electrode], current_ma=space.currents_ma[level],
                     width_us=space.width_us)

    def tell(self, state: History, query: Query, response: Response) -> None:
        """Keep it."""
        state.told.append((query, response))

    def recommend(self, state: History) -> Found | None:
        """The best measured."""
        return best_told(state.told)


@dataclass(frozen=True, slots=True, kw_only=True)
class Listed:
    """Queries that are known beforehand, in turn, such as those that another search has ended with.

    Attributes
    ----------
    elements: of each query. current_ma: of each.
    """

    elements: tuple[tuple[int, ...], ...] = ()
    current_ma: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        if len(self.elements) != len(self.current_ma):
            raise InputError("listed", f"{len(self.elements)} electrodes and {len(self.current_ma)} currents",
                             "equally many")

    def start(self, space: SearchSpace, key: int) -> History:
        """Nothing told yet. Raises InputError for a query that is not in the space."""
        for electrode, current in zip(self.elements, self.current_ma, strict=True):
            if not electrode or not set(space.usable).issuperset(electrode) or (
                    len(set(electrode)) < len(electrode)):
                raise InputError("listed.elements", f"{electrode}", "elements of the space, each once")
            if not 0.0 < current <= space.current_max_ma:
                raise InputError("listed.current_ma", f"{current:g}", f"above 0, to {space.current_max_ma:g}")
        return History(space, key, [])

    def ask(self, state: History) -> Query | None:
        """The next of the list."""
        turn = len(state.told)
        if turn >= len(self.elements):
            return None
        return Query(elements=tuple(sorted(self.elements[turn])), current_ma=self.current_ma[turn],
                     width_us=state.space.width_us)

    def tell(self, state: History, query: Query, response: Response) -> None:
        """Keep it."""
        state.told.append((query, response))

    def recommend(self, state: History) -> Found | None:
        """The best measured."""
        return best_told(state.told)


@dataclass(frozen=True, slots=True, kw_only=True)
class Random:
    """Candidates of the exhaustive search in random order, none twice: what any method must beat.

    Attributes
    ----------
    queries: how many; fewer where there are not as many.
    """

    queries: int = 100

    def __post_init__(self) -> None:
        if self.queries < 1:
            raise InputError("random.queries", f"{self.queries}", "1 or more")

    def start(self, space: SearchSpace, key: int) -> History:
        """Nothing told yet."""
        return History(space, key, [])

    def ask(self, state: History) -> Query | None:
        """The next of the order that the key draws."""
        turn, every = len(state.told), candidates(state.space)
        if turn >= min(self.queries, len(every)):
            return None
        order = np.random.Generator(np.random.Philox(key=state.key)).permutation(len(every))
        return every[int(order[turn])]

    def tell(self, state: History, query: Query, response: Response) -> None:
        """Keep it."""
        state.told.append((query, response))

    def recommend(self, state: History) -> Found | None:
        """The best measured."""
        return best_told(state.told)
