"""What a predictive controller is made of, from its parameters and its clock."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from controllers.mpc.candidates import Candidate, altered
from controllers.mpc.observer import Observer
from controllers.mpc.plan import Limits, Plan, Weights, make_plan
from controllers.qp.dense import Qp
from fesloop.loop.clock import NS_PER_MS, duration_ns
from fesloop.models.linear_model import LinearModel

if TYPE_CHECKING:
    from controllers.mpc.block import Mpc

Array = NDArray[np.float64]
_TYPICAL_SHARE = 0.5
"""Of a channel's reach, at which its charge per drive is taken, to be corrected from there (chosen)."""

_KEPT = 32
"""Candidates whose coefficients are kept, the last used: those of a few controllers."""


def candidates_of(mpc: Mpc, period_ns: int) -> tuple[Candidate, ...]:
    """The plant at every speed and delay that it may have, under drives recorded once."""
    speeds = mpc.adaptation.speeds if mpc.adaptation else (1.0,)
    delays = mpc.adaptation.delays_ns() if mpc.adaptation else (0,)
    made = tuple(_candidate(mpc, period_ns, speed, later, max(delays))
                 for speed in speeds for later in delays)
    shared = made[0].estimate
    for candidate in made[1:]:
        candidate.estimate.stamps, candidate.estimate.inputs = shared.stamps, shared.inputs
    return made


def _candidate(mpc: Mpc, period_ns: int, speed: float, later_ns: int, latest_ns: int) -> Candidate:
    """One of them; all keep drives for as long as the one with the longest delay does."""
    plan, observer = _coefficients(mpc, period_ns, speed, later_ns, latest_ns)
    return Candidate(speed, later_ns, plan, observer, observer.init(),
                     mpc.adaptation.init(observer) if mpc.adaptation else None,
                     Qp(plan.hessian, plan.rows, solver=mpc.solver, centred=True))


@lru_cache(maxsize=_KEPT)
def _coefficients(
    mpc: Mpc, period_ns: int, speed: float, later_ns: int, latest_ns: int
) -> tuple[Plan, Observer]:
    """What of a candidate nothing changes; kept, for every trial of every run begins with the same."""
    model = altered(mpc.model, speed, later_ns)
    delay_ns = model.delay_ns + duration_ns(mpc.actuation_delay_ms, NS_PER_MS, "actuation_delay_ms")
    reach_ns = duration_ns(mpc.max_age_ms, NS_PER_MS, "max_age_ms") + latest_ns - later_ns
    observer = Observer.design(
        model, period_ns=period_ns, delay_ns=delay_ns, reach_ns=reach_ns, drive_noise=mpc.drive_noise,
        disturbance_walk=math.radians(mpc.disturbance_deg),
        measurement_noise=math.radians(mpc.measurement_deg),
        unseen=mpc.grasping_outputs or range(model.outputs), touching_s=mpc.touching_s)
    return _plan(mpc, model, period_ns, delay_ns - model.delay_ns), observer


def _plan(mpc: Mpc, model: LinearModel, period_ns: int, actuation_ns: int) -> Plan:
    weights = Weights(np.array(mpc.output_weight or (1.0,) * model.outputs), mpc.move_weight,
                      mpc.effort_weight, mpc.cocontraction_weight)
    slopes = np.empty(0)
    if math.isfinite(mpc.horizon_charge_max_uc):
        typical = _TYPICAL_SHARE * mpc.reach()
        slopes = 1e6 * mpc.allocation().charge(typical) / typical / mpc.horizon_charge_max_uc
    return make_plan(model.sampled(period_ns, actuation_ns), mpc.horizon, weights,
                     Limits(*mpc.boxes(), slopes))
