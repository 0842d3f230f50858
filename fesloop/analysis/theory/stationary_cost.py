"""Exact error of a linear loop at rest under noise, latency, jitter and loss."""

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
from fesloop.experiment.running import Experiment

Array = NDArray[np.float64]
_ROUNDING = 1e-10
"""Distance from 1 below which a computed spectral radius does not decide stability."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StationaryCost:
    """Error of a linear loop at rest.

    Attributes
    ----------
    names, unit: of the outputs.
    rms: (outputs,), root mean square of each output about its mean, over the recorder's instants; infinite
        where the loop is not mean-square stable.
    spectral_radius: factor by which second moments grow per period in the long run.
    period_s: common period of all clocks.
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
        """Factor by which second moments grow per second in the long run; infinite beyond floats."""
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
        """Root mean square over all outputs, deg: the limit of the metric joint_rmse_deg in a long run, at a
        reference that the loop holds on average."""
        return math.sqrt(float(np.mean(np.square(self.rms_deg))))


def stationary_cost(loop: Experiment | LinearLoop) -> StationaryCost:
    """The stationary cost of an experiment's linear loop.

    Raises InputError as `linear_loop` does, for rates with a long common period, and for a loop whose noise
    often takes it to a limit.
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
    """Standard deviation of a block's outputs in a mean-square stable loop."""
    recursion = SecondMoments(period_map(loop, watched=block))
    return np.asarray(np.sqrt(recursion.variance(recursion.at_rest())))
