"""What a predictive controller is made of, from its parameters and its clock."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from controllers.mpc.observer import Observer, ObserverState
from controllers.mpc.parameters import MpcParameters
from controllers.mpc.plan import Limits, Plan, Weights, make_plan
from controllers.mpc.strength_adaptation import StrengthAdaptation, StrengthState
from controllers.qp.dense import Qp
from fesloop.loop.clock import NS_PER_MS, duration_ns
from fesloop.models.linear_model import LinearModel

Array = NDArray[np.float64]
LEAD = 0.3
"""Lead in log-likelihood by which another candidate takes over (chosen: 2 costs the first movement)."""


@dataclass(slots=True, eq=False)
class Candidate:
    """The plant as it may be, and control of it.

    Attributes
    ----------
    speed, delay_ns: over the model's, and beyond it.
    plan, observer: coefficients; never written to.
    estimate: of the plant; the recorded drives in it are shared by all candidates.
    strength: of the muscles, where it is adapted.
    qp: the programme, warm.
    likelihood: logarithm, of what was measured of late.
    """

    speed: float
    delay_ns: int
    plan: Plan
    observer: Observer
    estimate: ObserverState
    strength: StrengthState | None
    qp: Qp
    likelihood: float = 0.0


def altered(model: LinearModel, speed: float, delay_ns: int) -> LinearModel:
    """A model that goes through the same motion `speed` times as fast, and begins `delay_ns` later."""
    return replace(model, a=speed * model.a, b=speed * model.b, delay_ns=model.delay_ns + delay_ns)


def nominal(candidates: Sequence[Candidate]) -> int:
    """Number of the candidate that is the model as it stands."""
    return [(candidate.speed, candidate.delay_ns) for candidate in candidates].index((1.0, 0))


def compare(
    candidates: Sequence[Candidate], chosen: int, adaptation: StrengthAdaptation, captured_ns: int,
    measured: Array, touching: bool = False,
) -> int:
    """Let every candidate take in outputs (outputs,) rad as they were at `captured_ns`; the one to go by.

    While the hand touches something, that neither tells of strengths nor of which is right.
    """
    for candidate in candidates:
        estimate, observer = candidate.estimate, candidate.observer
        if captured_ns <= estimate.at_ns or candidate.strength is None:
            return chosen
        if touching:
            adaptation.follow(candidate.strength, observer, estimate, captured_ns)
        else:
            kept = math.exp(-observer.period_ns / 1e9 / adaptation.memory_s)
            candidate.likelihood = kept * candidate.likelihood + adaptation.correct(
                candidate.strength, observer, estimate, captured_ns, measured)
        if len(candidates) > 1:
            observer.correct(estimate, captured_ns, measured, touching)
    best = max(range(len(candidates)), key=lambda i: candidates[i].likelihood)
    return best if candidates[best].likelihood > candidates[chosen].likelihood + LEAD else chosen


def carry_over(
    adaptation: StrengthAdaptation, before: Sequence[Candidate], fresh: Sequence[Candidate]
) -> None:
    """Tell fresh candidates what those of the trial before have learnt."""
    for old, new in zip(before, fresh, strict=True):
        new.likelihood = old.likelihood
        new.estimate.strength[:] = old.estimate.strength
        if old.strength is not None:
            new.strength = adaptation.carried(old.strength, new.observer)


_TYPICAL_SHARE = 0.5
"""Of a channel's reach, at which its charge per drive is taken, to be corrected from there (chosen)."""

_KEPT = 32
"""Candidates whose coefficients are kept, the last used: those of a few controllers."""


def candidates_of(mpc: MpcParameters, period_ns: int) -> tuple[Candidate, ...]:
    """The plant at every speed and delay that it may have, under drives recorded once."""
    speeds = mpc.adaptation.speeds if mpc.adaptation else (1.0,)
    delays = mpc.adaptation.delays_ns() if mpc.adaptation else (0,)
    made = tuple(_candidate(mpc, period_ns, speed, later, max(delays))
                 for speed in speeds for later in delays)
    shared = made[0].estimate
    for candidate in made[1:]:
        candidate.estimate.stamps, candidate.estimate.inputs = shared.stamps, shared.inputs
    return made


def _candidate(mpc: MpcParameters, period_ns: int, speed: float, later_ns: int, latest_ns: int) -> Candidate:
    """One of them; all keep drives for as long as the one with the longest delay does."""
    plan, observer = _coefficients(mpc, period_ns, speed, later_ns, latest_ns)
    return Candidate(speed, later_ns, plan, observer, observer.init(),
                     mpc.adaptation.init(observer) if mpc.adaptation else None,
                     Qp(plan.hessian, plan.rows, solver=mpc.solver, centred=True))


@lru_cache(maxsize=_KEPT)
def _coefficients(
    mpc: MpcParameters, period_ns: int, speed: float, later_ns: int, latest_ns: int
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


def _plan(mpc: MpcParameters, model: LinearModel, period_ns: int, actuation_ns: int) -> Plan:
    weights = Weights(np.array(mpc.output_weight or (1.0,) * model.outputs), mpc.move_weight,
                      mpc.effort_weight, mpc.cocontraction_weight)
    slopes = np.empty(0)
    if math.isfinite(mpc.horizon_charge_max_uc):
        typical = _TYPICAL_SHARE * mpc.reach()
        slopes = 1e6 * mpc.allocation().charge(typical) / typical / mpc.horizon_charge_max_uc
    return make_plan(model.sampled(period_ns, actuation_ns), mpc.horizon, weights,
                     Limits(*mpc.boxes(), slopes))
