"""Coefficients of a predictive controller from its parameters and its clock."""

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
from controllers.quadratic_programme import Qp
from fesloop.loop.clock import NS_PER_MS, duration_ns
from fesloop.models.linear_model import LinearModel

Array = NDArray[np.float64]
LEAD = 0.3
"""Lead in log-likelihood by which another candidate replaces the chosen one (chosen: 2 is too late for the
first movement)."""


@dataclass(slots=True, eq=False)
class Candidate:
    """One hypothesis of the plant's speed and delay, with the controller for it.

    Attributes
    ----------
    speed: ratio to the model's speed.
    delay_ns: delay beyond the model's.
    plan, observer: constant coefficients.
    estimate: estimate of the plant; all candidates share its recorded drives.
    strength: estimate of the muscles' strengths; None without adaptation.
    qp: the programme, warm-started.
    likelihood: log-likelihood of the recent measurements.
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
    """The model with `speed` times its speed and `delay_ns` more delay."""
    return replace(model, a=speed * model.a, b=speed * model.b, delay_ns=model.delay_ns + delay_ns)


def nominal(candidates: Sequence[Candidate]) -> int:
    """Index of the candidate with the speed and the delay of the model."""
    return [(candidate.speed, candidate.delay_ns) for candidate in candidates].index((1.0, 0))


def compare(
    candidates: Sequence[Candidate], chosen: int, adaptation: StrengthAdaptation, captured_ns: int,
    measured: Array, touching: bool = False,
) -> int:
    """Correct every candidate by outputs (outputs,), rad, of `captured_ns`; return the index of the best.

    While the hand touches something, outputs change neither strengths nor likelihoods.
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
    """Copy strengths and likelihoods from the candidates of the trial before."""
    for old, new in zip(before, fresh, strict=True):
        new.likelihood = old.likelihood
        new.estimate.strength[:] = old.estimate.strength
        if old.strength is not None:
            new.strength = adaptation.carried(old.strength, new.observer)


_TYPICAL_SHARE = 0.5
"""Fraction of maximum drive at which charge per drive is linearised (chosen)."""

_KEPT = 32
"""Number of candidates whose coefficients are cached: those of a few controllers."""


def candidates_of(mpc: MpcParameters, period_ns: int) -> tuple[Candidate, ...]:
    """One candidate for each speed and delay, with shared records of the drives."""
    speeds = mpc.adaptation.speeds if mpc.adaptation else (1.0,)
    delays = mpc.adaptation.delays_ns() if mpc.adaptation else (0,)
    made = tuple(_candidate(mpc, period_ns, speed, later, max(delays))
                 for speed in speeds for later in delays)
    shared = made[0].estimate
    for candidate in made[1:]:
        candidate.estimate.stamps, candidate.estimate.inputs = shared.stamps, shared.inputs
    return made


def _candidate(mpc: MpcParameters, period_ns: int, speed: float, later_ns: int, latest_ns: int) -> Candidate:
    """One candidate; it keeps drives for as long as the candidate with the longest delay."""
    plan, observer = _coefficients(mpc, period_ns, speed, later_ns, latest_ns)
    return Candidate(speed, later_ns, plan, observer, observer.init(),
                     mpc.adaptation.init(observer) if mpc.adaptation else None,
                     Qp(plan.hessian, plan.rows, solver=mpc.solver, centred=True))


@lru_cache(maxsize=_KEPT)
def _coefficients(
    mpc: MpcParameters, period_ns: int, speed: float, later_ns: int, latest_ns: int
) -> tuple[Plan, Observer]:
    """Constant coefficients of a candidate, cached because every trial begins with the same."""
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
