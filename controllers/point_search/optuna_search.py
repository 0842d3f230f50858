"""Optuna's samplers as a strategy of a point search."""

from __future__ import annotations

import importlib
import importlib.util
import warnings
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from controllers.point_search.contract import Found, History, Query, Response, best_told
from controllers.point_search.space import Electrode, SearchSpace
from fesloop.errors import InputError

SamplerName = Literal["tpe", "random", "cmaes", "qmc"]
_SAMPLERS = {"tpe": "TPESampler", "random": "RandomSampler", "cmaes": "CmaEsSampler", "qmc": "QMCSampler"}
_GOES_ON = ("cmaes", "qmc")
"""Samplers that continue from their own notes in the study."""


@dataclass(frozen=True, slots=True, kw_only=True)
class OptunaSearch:
    """Search by a sampler over the place on the forearm, the number of elements, and the current.

    The query is the virtual electrode whose middle is nearest to the place. The study is rebuilt from the
    responses at every query, so that the history is the only state: with a seed for each query, or, for
    "cmaes" and "qmc", by replaying all trials.

    Attributes
    ----------
    sampler: sampler of Optuna; "cmaes" needs the package of that name.
    queries: number of queries.
    first: number of random queries at the start, for "tpe" alone.
    """

    sampler: SamplerName = "tpe"
    queries: int = 90
    first: int = 10

    def __post_init__(self) -> None:
        if self.sampler not in _SAMPLERS:
            raise InputError("optuna.sampler", f"{self.sampler!r}", ", ".join(_SAMPLERS))
        for key in ("queries", "first"):
            if getattr(self, key) < 1:
                raise InputError(f"optuna.{key}", f"{getattr(self, key)}", "1 or more")

    def start(self, space: SearchSpace, key: int) -> History:
        """State without responses. Raises InputError where Optuna, or what its sampler needs, is missing."""
        _optuna()
        if self.sampler == "cmaes" and importlib.util.find_spec("cmaes") is None:
            raise InputError("optuna.sampler", "'cmaes' needs the package cmaes, which is not installed",
                             ", ".join(name for name in _SAMPLERS if name != "cmaes"), "pip install cmaes")
        return History(space, key, [])

    def ask(self, state: History) -> Query | None:
        """Candidate nearest to the sampler's suggestion."""
        if len(state.told) >= self.queries:
            return None
        optuna, space = _optuna(), state.space
        optuna.logging.set_verbosity(optuna.logging.ERROR)
        study = optuna.create_study(sampler=self._sampler(state), direction="maximize")
        ranges = _ranges(optuna, space)
        for query, response in state.told:
            if self.sampler in _GOES_ON:
                study.tell(study.ask(ranges), response.quality)
            else:
                study.add_trial(optuna.trial.create_trial(
                    params=_parameters(space, query), distributions=ranges, value=response.quality))
        asked = study.ask(ranges).params
        place = np.array([asked["across"], asked["up"], asked["along"]])
        electrode = _nearest(space, place, asked["elements"])
        return Query(elements=electrode, current_ma=space.currents_ma[asked["level"]],
                     width_us=space.width_us)

    def tell(self, state: History, query: Query, response: Response) -> None:
        """Record the response."""
        state.told.append((query, response))

    def recommend(self, state: History) -> Found | None:
        """Query of the best measured quality."""
        return best_told(state.told)

    def _sampler(self, state: History) -> Any:
        number = 0 if self.sampler in _GOES_ON else len(state.told)
        seed = int(np.random.Philox(key=state.key).random_raw(number + 1)[-1] % 2**31)
        own: dict[str, dict[str, Any]] = {"tpe": {"n_startup_trials": self.first}, "qmc": {"scramble": True}}
        optuna = _optuna()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", optuna.exceptions.ExperimentalWarning)  # "qmc", at every query
            return getattr(optuna.samplers, _SAMPLERS[self.sampler])(seed=seed, **own.get(self.sampler, {}))


def _ranges(optuna: Any, space: SearchSpace) -> dict[str, Any]:
    """Ranges of the suggestions: place, mm, number of elements, and level of current."""
    positions = np.array([space.position(electrode) for electrode in space.electrodes])
    real, whole = optuna.distributions.FloatDistribution, optuna.distributions.IntDistribution
    places = {name: real(float(column.min()), float(column.max()))
              for name, column in zip(("across", "up", "along"), positions.T, strict=True)}
    return {**places, "elements": whole(1, max(map(len, space.electrodes))),
            "level": whole(0, len(space.currents_ma) - 1)}


def _parameters(space: SearchSpace, query: Query) -> dict[str, Any]:
    """Suggestion that corresponds to a query."""
    across, up, along = space.position(query.elements).tolist()
    return {"across": across, "up": up, "along": along, "elements": len(query.elements),
            "level": space.currents_ma.index(query.current_ma)}


def _nearest(space: SearchSpace, place: np.ndarray[Any, Any], elements: int) -> Electrode:
    """Virtual electrode of a number of elements with its middle nearest to a place."""
    alike = [electrode for electrode in space.electrodes if len(electrode) == elements]
    return min(alike, key=lambda electrode: float(np.square(space.position(electrode) - place).sum()))


def _optuna() -> Any:
    """The package Optuna. Raises InputError where it is missing."""
    try:
        return importlib.import_module("optuna")
    except ImportError:
        raise InputError("strategy optuna", "Optuna is not installed", "the extra `search`",
                         "pip install 'fesloop[search]'") from None
