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


@dataclass(slots=True, eq=False)
class GaussianProcessState:
    """Candidates and the responses to them.

    Attributes
    ----------
    queries: all candidates, constant.
    points: (n, 5), their places, scaled so that quality changes over a distance of 1; constant.
    expected: (n,), prior mean m; constant.
    asked: indices of the queries so far, in order.
    quality: quality of each.
    """

    queries: list[Query]
    points: Array
    expected: Array
    asked: list[int] = field(default_factory=list)
    quality: list[float] = field(default_factory=list)


@dataclass(frozen=True, slots=True, kw_only=True)
class GaussianProcess:
    """Queries where quality is expected to be high or uncertain, by a model that generalises to neighbours.

    Quality of a query x = (place on the forearm, current i, number n of elements) is

        q(x) = m(x) + g(x) + noise,    m(x) = zone_height z(x) i / i_max
        cov(g(x), g(x')) = spread^2 (1 + r + r^2 / 3) exp(-r),    r = sqrt(5) d    (Matern, nu = 5/2)
        d^2 = (|place - place'| / place_mm)^2 + ((i - i') / current_ma)^2 + ((n - n') / elements)^2

    with z from 0 to 1, high where anatomy suggests the movement (`prior_zones`).
    The next query is the new candidate with the greatest

        ucb:  mu + kappa sd
        ei:   (mu - best) Phi(u) + sd phi(u),  u = (mu - best) / sd,  best = greatest mu of the queries so far

    It recommends the query so far with the greatest mu, on which noise has less influence than on the
    greatest measurement. It ends when this has not improved by `least_gain` for `patience` queries, or after
    `queries`. Its numbers are chosen on other patients than those on whom it is demonstrated.

    Attributes
    ----------
    acquisition, kappa: "ucb" or "ei", and the weight of the sd in "ucb".
    zone_height: expected quality in a zone's middle at the greatest current; 0: no use of anatomy.
    spread, noise: standard deviations of quality about its prior mean, and of its measurement.
    place_mm, current_ma, elements: distance, current and number of elements over which quality changes.
    queries: greatest number of queries.
    patience, least_gain: queries without an improvement by `least_gain` after which the search ends.
    """

    acquisition: Literal["ucb", "ei"] = "ucb"
    kappa: float = 2.0
    zone_height: float = 0.3
    spread: float = 0.5
    noise: float = 0.05
    place_mm: float = 18.0
    current_ma: float = 6.0
    elements: float = 1.0
    queries: int = 150
    patience: int = 60
    least_gain: float = 0.01

    def __post_init__(self) -> None:
        if self.acquisition not in ("ucb", "ei"):
            raise InputError("gaussian_process.acquisition", f"{self.acquisition!r}", "ucb, ei")
        for key in ("spread", "noise", "place_mm", "current_ma", "elements"):
            value = getattr(self, key)
            if not (isfinite(value) and value > 0.0):
                raise InputError(f"gaussian_process.{key}", f"{value}", "a finite number above 0")
        for key in ("kappa", "zone_height", "least_gain"):
            value = getattr(self, key)
            if not (isfinite(value) and value >= 0.0):
                raise InputError(f"gaussian_process.{key}", f"{value}", "a finite number, 0 or more")
        for key in ("queries", "patience"):
            if getattr(self, key) < 1:
                raise InputError(f"gaussian_process.{key}", f"{getattr(self, key)}", "1 or more")

    def start(self, space: SearchSpace, key: int) -> GaussianProcessState:
        """State without responses. Raises InputError where scikit-learn is missing."""
        _scikit_learn()
        queries = candidates(space)
        positions = np.array([space.position(query.elements) for query in queries])
        current_ma = np.array([query.current_ma for query in queries])
        elements = np.array([len(query.elements) for query in queries])
        points = np.column_stack((positions / self.place_mm, current_ma / self.current_ma,
                                  elements / self.elements))
        near = expectation(space.zones, positions, space.radius_mm)
        return GaussianProcessState(
            queries, points, self.zone_height * near * current_ma / space.current_max_ma)

    def ask(self, state: GaussianProcessState) -> Query | None:
        """Candidate with the greatest acquisition value."""
        left = np.setdiff1d(np.arange(len(state.queries)), state.asked)
        if not left.size or len(state.asked) >= self.queries:
            return None
        if not state.asked:
            return state.queries[int(np.argmax(state.expected))]
        mean, sd = self._foresee(state)
        known = mean[state.asked]
        before = len(known) - self.patience
        if before > 0 and known[before:].max() < known[:before].max() + self.least_gain:
            return None
        if self.acquisition == "ucb":
            promise = mean[left] + self.kappa * sd[left]
        else:
            promise = expected_improvement(mean[left], sd[left], float(known.max()))
        return state.queries[int(left[np.argmax(promise)])]

    def tell(self, state: GaussianProcessState, query: Query, response: Response) -> None:
        """Record the response."""
        state.asked.append(state.queries.index(query))
        state.quality.append(response.quality)

    def recommend(self, state: GaussianProcessState) -> Found | None:
        """Query so far with the greatest expected quality."""
        if not state.asked:
            return None
        known = self._foresee(state)[0][state.asked]
        return Found(state.queries[state.asked[int(np.argmax(known))]], float(known.max()))

    def _foresee(self, state: GaussianProcessState) -> tuple[Array, Array]:
        """Posterior mean and standard deviation of the quality of all candidates, (n,) each."""
        learn, kernels = _scikit_learn()
        kernel = kernels.ConstantKernel(self.spread**2, "fixed") * kernels.Matern(1.0, "fixed", nu=2.5)
        process = learn.GaussianProcessRegressor(kernel, alpha=self.noise**2, optimizer=None)
        process.fit(state.points[state.asked], np.array(state.quality) - state.expected[state.asked])
        mean, sd = process.predict(state.points, return_std=True)
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
