"""What noise, latency, jitter and loss cost a linear loop at rest, exactly."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fesloop.analysis.theory.linear_loop import linear_loop
from fesloop.analysis.theory.loop import LinearLoop
from fesloop.analysis.theory.period_map import period_map
from fesloop.analysis.theory.rest import require_room
from fesloop.analysis.theory.second_moments import SecondMoments
from fesloop.experiment.experiment import Experiment

Array = NDArray[np.float64]
_ROUNDING = 1e-10
"""Nearer to 1 than this a computed spectral radius does not tell whether second moments stay bounded."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StationaryCost:
    """A linear loop at rest.

    Attributes
    ----------
    names, unit: of the outputs.
    rms: (outputs,), root mean square of each output about its mean, over the recorder's instants; infinite
        where the loop is not mean-square stable.
    spectral_radius: factor by which second moments grow in a period, in the long run.
    period_s: of everything on the loop together.
    """

    names: tuple[str, ...]
    unit: str
    rms: Array
    spectral_radius: float
    period_s: float

    @property
    def stable(self) -> bool:
        """Whether second moments stay bounded (mean-square stability)."""
        return self.spectral_radius < 1.0 - _ROUNDING

    @property
    def growth_per_s(self) -> float:
        """Factor by which second moments grow in a second, in the long run; infinite beyond floats."""
        try:
            return float(self.spectral_radius ** (1.0 / self.period_s))
        except OverflowError:
            return math.inf

    @property
    def rms_deg(self) -> Array:
        """`rms` of angles, (outputs,), deg."""
        return np.degrees(self.rms)

    @property
    def joint_rms_deg(self) -> float:
        """Over all outputs, deg: what the metric joint_rmse_deg comes to in a long run, at a reference that
        the loop holds on average."""
        return math.sqrt(float(np.mean(np.square(self.rms_deg))))


def stationary_cost(loop: Experiment | LinearLoop) -> StationaryCost:
    """The stationary cost of an experiment's linear loop.

    Raises InputError as `linear_loop` does, for rates that do not soon come together, and for a loop whose
    noise takes it to a limit again and again.
    """
    loop = loop if isinstance(loop, LinearLoop) else linear_loop(loop)
    period = period_map(loop)
    recursion = SecondMoments(period)
    radius = recursion.spectral_radius()
    cost = StationaryCost(names=loop.truth_names, unit=loop.truth_unit, spectral_radius=radius,
                          rms=np.full(len(loop.truth), math.inf), period_s=period.period_s)
    if not cost.stable:
        return cost
    require_room(loop, lambda name: _spread(loop, name))
    return replace(cost, rms=np.sqrt(recursion.variance(recursion.at_rest())))


def _spread(loop: LinearLoop, block: str) -> Array:
    """Standard deviation of all that a block puts out, of a loop that is mean-square stable."""
    recursion = SecondMoments(period_map(loop, watched=block))
    return np.asarray(np.sqrt(recursion.variance(recursion.at_rest())))
