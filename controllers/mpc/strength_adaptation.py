"""Estimate of each muscle's strength, which fatigue and recovery change slowly, from measurements.

Each muscle's contribution to the outputs is simulated by the model alone, under the recorded drives and
without corrections. A measurement is the sum of the contributions, each times the muscle's strength, and of a
disturbance:

    y(t) = offset + sum_i s_i C z_i(t) + d(t)

a linear regression with parameters that drift, solved by a Kalman filter (Ljung 1999, System Identification,
section 11.2). Strengths are pulled back to 1 with the time constant of fatigue and recovery, so that the
strength of a muscle that is not used stays known. The first movement shows the common part of all strengths
(a model of another day); the individual parts show when the muscles are used.

A plant may also be faster or slower than its model: see `mpc.design.Candidate`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag

from controllers.mpc.observer import Observer, ObserverState, propagate
from fesloop.compiled import compiled
from fesloop.errors import InputError
from fesloop.loop.clock import NS_PER_MS, NS_PER_S, duration_ns

Array = NDArray[np.float64]


@dataclass(slots=True, eq=False)
class StrengthState:
    """State of the adaptation.

    Attributes
    ----------
    responses: (muscles, states), states of the model under each muscle alone at strength 1.
    mean: (muscles + outputs,), strengths, then the disturbance in rad.
    covariance: (muscles + outputs,) squared.
    """

    responses: Array
    mean: Array
    covariance: Array


@dataclass(frozen=True, slots=True, kw_only=True)
class StrengthAdaptation:
    """Parameters of the adaptation.

    Attributes
    ----------
    strength_sd: sd of strengths about 1 (chosen: the fitness equation's floor of 0.2 is then about two sd
        away).
    time_s: time constant of their drift (fatigue 18-30 s, recovery 40-50 s; `plants` has the sources).
    disturbance_deg: sd of the disturbance's walk over 1 s (chosen).
    measurement_deg: sd of a sample about the model's prediction (chosen).
    common: share of the initial variance that all muscles have in common (chosen): they tire individually.
    speeds, delays_ms: speeds of the patient relative to the model, and additional delays; 1 and 0 are among
        them. The pair with the best predictions is used. Every pair costs a filter.
    memory_s: time constant with which predictions are forgotten.
    least, greatest: bounds of a strength.
    """

    strength_sd: float = 0.4
    time_s: float = 30.0
    disturbance_deg: float = 2.0
    measurement_deg: float = 2.0
    common: float = 0.5
    speeds: tuple[float, ...] = (1.0,)
    delays_ms: tuple[float, ...] = (0.0,)
    memory_s: float = 2.0
    least: float = 0.2
    greatest: float = 1.5

    def __post_init__(self) -> None:
        for key in ("strength_sd", "time_s", "disturbance_deg", "measurement_deg", "least",
                    "memory_s"):
            if not (math.isfinite(getattr(self, key)) and getattr(self, key) > 0.0):
                raise InputError(f"adaptation.{key}", f"{getattr(self, key)}", "a finite value above 0")
        if not 0.0 <= self.common <= 1.0:
            raise InputError("adaptation.common", f"{self.common}", "0 to 1")
        if not (1.0 in self.speeds and len(set(self.speeds)) == len(self.speeds)
                and all(0.0 < speed < math.inf for speed in self.speeds)):
            raise InputError("adaptation.speeds", f"{self.speeds}", "different speeds above 0, 1 among them")
        if not (0.0 in self.delays_ms and len(set(self.delays_ms)) == len(self.delays_ms)):
            raise InputError("adaptation.delays_ms", f"{self.delays_ms}", "different delays, 0 among them")
        self.delays_ns()
        if not self.least <= 1.0 <= self.greatest < math.inf:
            raise InputError("adaptation", f"least {self.least}, greatest {self.greatest}",
                             "bounds around 1, the strength of the model")

    def delays_ns(self) -> tuple[int, ...]:
        """`delays_ms` in ns."""
        return tuple(duration_ns(delay, NS_PER_MS, "adaptation.delays_ms") for delay in self.delays_ms)

    def init(self, observer: Observer) -> StrengthState:
        """State of fresh muscles, at rest."""
        states, outputs = observer.c.shape[1], observer.c.shape[0]
        muscles = observer.ladder.shape[1] - states
        mean = np.concatenate([np.ones(muscles), np.zeros(outputs)])
        shared = self.common * np.ones((muscles, muscles)) + (1.0 - self.common) * np.eye(muscles)
        covariance = block_diag(self.strength_sd**2 * shared,
                                math.radians(self.disturbance_deg)**2 * np.eye(outputs))
        return StrengthState(np.zeros((muscles, states)), mean, covariance)

    def carried(self, state: StrengthState, observer: Observer) -> StrengthState:
        """State at rest, with the estimated strengths."""
        fresh, muscles = self.init(observer), state.responses.shape[0]
        fresh.mean[:muscles] = state.mean[:muscles]
        fresh.covariance[:muscles, :muscles] = state.covariance[:muscles, :muscles]
        return fresh

    def correct(
        self, state: StrengthState, observer: Observer, estimate: ObserverState, captured_ns: int,
        measured: Array,
    ) -> float:
        """Correct by outputs (outputs,) of `captured_ns`, before the observer does; set `estimate.strength`.

        Returns the log-likelihood of the outputs.
        """
        elapsed_s = (captured_ns - estimate.at_ns) / NS_PER_S
        self.follow(state, observer, estimate, captured_ns)
        likelihood: float = regress(
            estimate.strength, self.least, self.greatest, state.mean, state.covariance, state.responses,
            observer.c, measured - observer.offset,
            math.exp(-elapsed_s / self.time_s), self.strength_sd**2,
            math.radians(self.disturbance_deg)**2 * elapsed_s, math.radians(self.measurement_deg)**2)
        return likelihood

    def follow(
        self, state: StrengthState, observer: Observer, estimate: ObserverState, captured_ns: int
    ) -> None:
        """Propagate the responses to `captured_ns` without a correction."""
        respond(observer.ladder, state.responses, estimate.stamps, estimate.inputs, observer.period_ns,
                observer.delay_ns, estimate.at_ns, captured_ns)


@compiled
def respond(
    ladder: Array, responses: Array, stamps: NDArray[np.int64], inputs: Array, period_ns: int, delay_ns: int,
    from_ns: int, to_ns: int,
) -> None:
    """Propagate the response to each muscle alone, in place."""
    alone = np.zeros(inputs.shape[1])
    for i in range(alone.size):
        alone[i] = 1.0
        propagate(ladder, responses[i], alone, stamps, inputs, period_ns, delay_ns, from_ns, to_ns)
        alone[i] = 0.0


@compiled
def regress(
    strength: Array, least: float, greatest: float, mean: Array, covariance: Array, responses: Array,
    c: Array, unexplained: Array, kept: float, strength_variance: float, walk_variance: float,
    noise_variance: float,
) -> float:
    """One step of the filter, in place; return the log-likelihood of the measurement without its constant.

    Parameters
    ----------
    strength: (muscles,), filled.
    least, greatest: bounds of a strength.
    mean, covariance, responses: as in `StrengthState`.
    c: as in `Observer`.
    unexplained: (outputs,), measurement less offset.
    kept: factor on the distance of strengths from 1.
    strength_variance: stationary variance of strengths.
    walk_variance, noise_variance: variances of the disturbance's walk since the last sample and of a sample.
    """
    muscles, size = responses.shape[0], mean.size
    for i in range(muscles):
        mean[i] = 1.0 + kept * (mean[i] - 1.0)
        for j in range(size):
            covariance[i, j] *= kept
            covariance[j, i] *= kept
        covariance[i, i] += (1.0 - kept * kept) * strength_variance
    for i in range(muscles, size):
        covariance[i, i] += walk_variance
    likelihood = 0.0
    regressor = np.empty(size)
    for output in range(unexplained.size):
        regressor[:] = 0.0
        for i in range(muscles):
            for j in range(c.shape[1]):
                regressor[i] += c[output, j] * responses[i, j]
        regressor[muscles + output] = 1.0
        spread = np.zeros(size)
        for i in range(size):
            for j in range(size):
                spread[i] += covariance[i, j] * regressor[j]
        variance, innovation = noise_variance, unexplained[output]
        for i in range(size):
            variance += regressor[i] * spread[i]
            innovation -= regressor[i] * mean[i]
        likelihood -= 0.5 * (innovation * innovation / variance + math.log(variance))
        for i in range(size):
            mean[i] += spread[i] / variance * innovation
            for j in range(size):
                covariance[i, j] -= spread[i] * spread[j] / variance
    for i in range(muscles):
        strength[i] = mean[i] = min(max(mean[i], least), greatest)
    return likelihood
