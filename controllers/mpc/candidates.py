"""The plant as it may be: the model as it stands, and as much faster, slower or later as the patient may be.

Every candidate follows the measurements with an observer and an adaptation of its own, all under the same
recorded drives. Control goes by the one that has lately predicted best, which multiple-model adaptive
estimation does (Maybeck and Stevens 1991, doi 10.1109/7.104266, for moving between the models of a bank).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from controllers.mpc.observer import Observer, ObserverState
from controllers.mpc.plan import Plan
from controllers.mpc.strength_adaptation import StrengthAdaptation, StrengthState
from controllers.qp.dense import Qp
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
