"""Search by a Gaussian process over the forearm's skin and current (scikit-learn's)."""

from __future__ import annotations

import importlib
from dataclasses import dataclass, field
from math import erf, isfinite, pi, sqrt
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from controllers.point_search.contract import Found, Query, Response
from controllers.point_search.exhaustive import candidates
from controllers.point_search.prior_zones import expectation
from controllers.point_search.space import SearchSpace
from fesloop.errors import InputError

Array = NDArray[np.float64]
_FAR = 1e6
"""Distance in kernel lengths at which nothing is shared."""
_QUERIES = 74
"""Queries without a stated number (chosen: three and a half minutes of the patient's time)."""


@dataclass(slots=True, eq=False)
class GaussianProcessState:
    """Candidates and the responses to them.

    Attributes
    ----------
    queries: all candidates, constant.
    points: (n, 5), their places, scaled so that quality changes over a distance of 1; constant.
    expected: (n,), prior mean m; constant.
    asked: indices of the queries so far, in order, those of the earlier search first.
    quality: quality of each.
    earlier: number of responses of the earlier search among them.
    """

    queries: list[Query]
    points: Array
    expected: Array
    asked: list[int] = field(default_factory=list)
    quality: list[float] = field(default_factory=list)
    earlier: int = 0

    @property
    def today(self) -> list[int]:
        """Indices of the queries of this search."""
        return self.asked[self.earlier:]


@dataclass(frozen=True, slots=True, kw_only=True)
class GaussianProcess:
    """Queries where quality is expected to be high or uncertain, by a model that generalises to neighbours.

    Quality of a query x = (place on the forearm, current i, number n of elements) is

        q(x) = m(x) + g(x) + noise,    m(x) = zone_height z(x) i / i_max
        cov(g(x), g(x')) = spread^2 (1 + r + r^2 / 3) exp(-r),    r = sqrt(5) d    (Matern, nu = 5/2)
        d^2 = (|place - place'| / place_mm)^2 + ((i - i') / current_ma)^2 + ((n - n') / elements)^2

    with z from 0 to 1, high where anatomy suggests the movement (`prior_zones`). Responses of an earlier
    search (`PointSearch.earlier`) are those of another day: their covariance with this day's is `day_share`
    of the above, so that what both days have in common counts as known, and the rest not.

    The next query is the new candidate with the greatest

        ei:   (mu - best) Phi(u) + sd phi(u),  u = (mu - best) / sd,  best = greatest mu of the queries so far
        ucb:  mu + kappa sd

    It recommends the query so far with the greatest mu, on which noise has less influence than on the
    greatest measurement. It ends when no candidate's expected improvement (ei) is `least_gain` or more, or
    after `queries`. Its numbers are chosen on other patients than those on whom it is demonstrated.

    Attributes
    ----------
    acquisition, kappa: "ei" or "ucb", and the weight of the sd in "ucb".
    zone_height: expected quality in a zone's middle at the greatest current; 0: no use of anatomy.
    spread, noise: standard deviations of quality about its prior mean, and of its measurement.
    place_mm, current_ma, elements: distance, current and number of elements over which quality changes.
    day_share: correlation of the quality of a query on two days, 0 to below 1.
    queries: greatest number of queries, at most that of the candidates; None: 74, or all candidates.
    least_gain: quality that one more query must promise.
    """

    acquisition: Literal["ei", "ucb"] = "ei"
    kappa: float = 2.0
    zone_height: float = 0.3
    spread: float = 0.5
    noise: float = 0.05
    place_mm: float = 16.0
    current_ma: float = 8.0
    elements: float = 1.0
    day_share: float = 0.9
    queries: int | None = None
    least_gain: float = 0.02

    def __post_init__(self) -> None:
        if self.acquisition not in ("ei", "ucb"):
            raise InputError("gaussian_process.acquisition", f"{self.acquisition!r}", "ei, ucb")
        for key in ("spread", "noise", "place_mm", "current_ma", "elements"):
            value = getattr(self, key)
            if not (isfinite(value) and value > 0.0):
                raise InputError(f"gaussian_process.{key}", f"{value}", "a finite number above 0")
        for key in ("kappa", "zone_height", "least_gain"):
            value = getattr(self, key)
            if not (isfinite(value) and value >= 0.0):
                raise InputError(f"gaussian_process.{key}", f"{value}", "a finite number, 0 or more")
        if not 0.0 <= self.day_share < 1.0:
            raise InputError("gaussian_process.day_share", f"{self.day_share}", "0 or more, below 1")
        if self.queries is not None and self.queries < 1:
            raise InputError("gaussian_process.queries", f"{self.queries}", "1 or more")

    def start(self, space: SearchSpace, key: int) -> GaussianProcessState:
        """State without responses of this search.

        Raises InputError where scikit-learn is missing, and for more queries than candidates.
        """
        _scikit_learn()
        queries = candidates(space)
        if self.queries is not None and self.queries > len(queries):
            raise InputError("strategies.gaussian_process.queries", f"{self.queries}",
                             f"1 to {len(queries)}, the number of candidates")
        positions = np.array([space.position(query.elements) for query in queries])
        current_ma = np.array([query.current_ma for query in queries])
        elements = np.array([len(query.elements) for query in queries])
        points = np.column_stack((positions / self.place_mm, current_ma / self.current_ma,
                                  elements / self.elements))
        near = expectation(space.zones, positions, space.radius_mm)
        state = GaussianProcessState(
            queries, points, self.zone_height * near * current_ma / space.current_max_ma)
        known = {(query.elements, round(query.current_ma, 6)): index for index, query in enumerate(queries)}
        for each in space.earlier.responses:
            # A current is stored to less than its last bit.
            index = known.get((each.elements, round(each.current_ma, 6)))
            if index is not None:
                state.asked.append(index)
                state.quality.append(each.quality)
        state.earlier = len(state.asked)
        return state

    def ask(self, state: GaussianProcessState) -> Query | None:
        """Candidate with the greatest acquisition value."""
        left = np.setdiff1d(np.arange(len(state.queries)), state.today)
        if not left.size or len(state.today) >= (self.queries or _QUERIES):
            return None
        if not state.asked:
            return state.queries[int(np.argmax(state.expected))]
        mean, sd = self._foresee(state)
        if not state.today:
            return state.queries[int(np.argmax(mean))]
        gain = expected_improvement(mean[left], sd[left], float(mean[state.today].max()))
        if gain.max() < self.least_gain:
            return None
        promise = gain if self.acquisition == "ei" else mean[left] + self.kappa * sd[left]
        return state.queries[int(left[np.argmax(promise)])]

    def tell(self, state: GaussianProcessState, query: Query, response: Response) -> None:
        """Record the response."""
        state.asked.append(state.queries.index(query))
        state.quality.append(response.quality)

    def recommend(self, state: GaussianProcessState) -> Found | None:
        """Query so far with the greatest expected quality."""
        if not state.today:
            return None
        mean, sd = self._foresee(state)
        best = state.today[int(np.argmax(mean[state.today]))]
        return Found(state.queries[best], float(mean[best]), float(sd[best]))

    def _foresee(self, state: GaussianProcessState) -> tuple[Array, Array]:
        """Posterior mean and standard deviation of the quality of all candidates on this day, (n,) each."""
        learn, kernels = _scikit_learn()
        asked = state.points[state.asked]
        day = np.zeros((len(asked), 1))
        day[:state.earlier] = 1.0
        alike = np.ones(asked.shape[1])
        # The day has no effect on the one part, and its points are far from each other in the other.
        shared, own = (kernels.ConstantKernel(share * self.spread**2, "fixed")
                       * kernels.Matern(np.append(alike, length), "fixed", nu=2.5)
                       for share, length in ((self.day_share, _FAR), (1.0 - self.day_share, 1.0 / _FAR)))
        kernel = shared + own if state.earlier and self.day_share > 0.0 else (
            kernels.ConstantKernel(self.spread**2, "fixed") * kernels.Matern(np.append(alike, 1.0 / _FAR),
                                                                            "fixed", nu=2.5))
        process = learn.GaussianProcessRegressor(kernel, alpha=self.noise**2, optimizer=None)
        process.fit(np.hstack((asked, day)), np.array(state.quality) - state.expected[state.asked])
        today = np.hstack((state.points, np.zeros((len(state.points), 1))))
        mean, sd = process.predict(today, return_std=True)
        return mean + state.expected, sd


def expected_improvement(mean: Array, sd: Array, best: float) -> Array:
    """Expected improvement of normal variables (n,) over `best`."""
    u = (mean - best) / np.maximum(sd, 1e-12)
    below = 0.5 * (1.0 + np.array([erf(value / sqrt(2.0)) for value in u]))
    improvement: Array = (mean - best) * below + sd * np.exp(-0.5 * u * u) / sqrt(2.0 * pi)
    return improvement


def _scikit_learn() -> tuple[Any, Any]:
    """Gaussian processes and kernels of scikit-learn. Raises InputError where it is missing."""
    try:
        return (importlib.import_module("sklearn.gaussian_process"),
                importlib.import_module("sklearn.gaussian_process.kernels"))
    except ImportError:
        raise InputError("strategy gaussian_process", "scikit-learn is not installed", "the extra `search`",
                         "pip install 'fesloop[search]'") from None
