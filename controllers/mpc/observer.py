"""Estimate of the plant's present state from measurements of known age and recorded inputs.

A Kalman filter holds the estimate at the newest capture. A new sample propagates it to its own capture under
the inputs that acted until then; the present state is predicted from a copy. All transitions are exact to the
nanosecond for a linear model behind a pure delay.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_discrete_are

from fesloop.compiled import assign, compiled
from fesloop.loop.clock import NS_PER_MS, NS_PER_S
from fesloop.loop.signals import NEVER
from fesloop.models.linear_model import LinearModel, zero_order_hold

Array = NDArray[np.float64]
Stamps = NDArray[np.int64]
_LONG_AGO = -(2**62)


@dataclass(slots=True, eq=False)
class ObserverState:
    """Estimate and recorded inputs.

    Attributes
    ----------
    at_ns: instant of the estimate: the newest capture, or the start of the trial.
    x: (states,), estimate at that instant.
    disturbance: (outputs,), estimated difference between the outputs and the model's, rad.
    strength: (muscles,), response of each muscle to its drive, relative to the model's.
    stamps, inputs: (kept,) ns and (kept, muscles): instants and values of the issued drives, oldest first.
    """

    at_ns: int
    x: Array
    disturbance: Array
    strength: Array
    stamps: Stamps
    inputs: Array


@dataclass(frozen=True, slots=True, eq=False)
class Observer:
    """Coefficients of the observer.

    The model's output carries a disturbance that walks, which makes control free of offset (Pannocchia and
    Rawlings 2003, doi 10.1002/aic.690490213). The gain is that of the stationary filter with one sample a
    period; it is used whatever the true distance of two captures.

    Attributes
    ----------
    ladder: (rungs, states + muscles, states): transposed [Phi Gamma] over 1, 2, 4 ... 512 ns, over as many
        us, over 1, 2, 4 ... ms up to `period_ns`, and last over `period_ns` itself: most durations are whole
        periods and a few ms.
    c, offset: output of the model, (outputs, states) and (outputs,).
    gain: (states + outputs, outputs).
    touching_gain: the same while the hand touches something. The state then follows the drives alone, and the
        disturbances of observed outputs follow the measurements: an object that blocks one joint changes the
        response of all, and a correction of the state would change the drives of every muscle.
    delay_ns: delay from issuing a drive to its effect on x.
    period_ns: period of the samples.
    kept: number of inputs kept.
    """

    ladder: Array
    c: Array
    offset: Array
    gain: Array
    touching_gain: Array
    delay_ns: int
    period_ns: int
    kept: int

    @classmethod
    def design(
        cls, model: LinearModel, *, period_ns: int, delay_ns: int, reach_ns: int, drive_noise: float,
        disturbance_walk: float, measurement_noise: float, unseen: Sequence[int] = (),
        touching_s: float = 0.3,
    ) -> Observer:
        """Observer of a model.

        Parameters
        ----------
        period_ns: period of the samples, for the gain.
        delay_ns: total delay from issuing a drive to its effect on the model's state.
        reach_ns: greatest age of a measurement.
        drive_noise: sd of the error of the drive, held over a period.
        disturbance_walk: sd of the output disturbance after one second, rad.
        measurement_noise: sd, rad.
        unseen: numbers of the outputs that are not observed while the hand touches something.
        touching_s: time constant with which the disturbances of the others are then followed.
        """
        states, outputs = model.a.shape[0], model.outputs
        rungs_ns = [*(unit * 2**i for unit in (1, 1000) for i in range(10)),
                    *(NS_PER_MS * 2**i for i in range((period_ns // NS_PER_MS).bit_length())), period_ns]
        ladder = np.stack([np.vstack([m.T for m in zero_order_hold(model.a, model.b, rung / NS_PER_S)])
                           for rung in rungs_ns])
        phi, gamma = zero_order_hold(model.a, model.b, period_ns / NS_PER_S)
        a = np.eye(states + outputs)
        a[:states, :states] = phi
        c = np.hstack([model.c, np.eye(outputs)])
        noise = np.zeros_like(a)
        noise[:states, :states] = drive_noise**2 * gamma @ gamma.T
        noise[states:, states:] = disturbance_walk**2 * period_ns / NS_PER_S * np.eye(outputs)
        noise[:states, :states] += 1e-12 * np.eye(states)
        covariance = solve_discrete_are(a.T, c.T, noise, measurement_noise**2 * np.eye(outputs))
        gain = covariance @ c.T @ np.linalg.inv(c @ covariance @ c.T + measurement_noise**2 * np.eye(outputs))
        touching_gain = np.zeros_like(gain)
        seen = [i for i in range(outputs) if i not in unseen]
        touching_gain[[states + i for i in seen], seen] = -math.expm1(-period_ns / NS_PER_S / touching_s)
        kept = (reach_ns + delay_ns) // period_ns + 3
        return cls(ladder, np.ascontiguousarray(model.c), model.offset, np.ascontiguousarray(gain),
                   touching_gain, delay_ns, period_ns, kept)

    def init(self) -> ObserverState:
        """State at rest before t = 0, without issued drives."""
        states, muscles = self.ladder.shape[2], self.ladder.shape[1] - self.ladder.shape[2]
        return ObserverState(NEVER, np.zeros(states), np.zeros(self.offset.size), np.ones(muscles),
                             np.full(self.kept, _LONG_AGO, dtype=np.int64), np.zeros((self.kept, muscles)))

    def record(self, state: ObserverState, time_ns: int, drive: Array) -> None:
        """Record a drive that is issued at `time_ns`."""
        record(state.stamps, state.inputs, time_ns, drive)

    def correct(
        self, state: ObserverState, captured_ns: int, measured: Array, touching: bool = False
    ) -> None:
        """Correct by outputs (outputs,), rad, of `captured_ns`, unless that is not after the estimate."""
        if captured_ns <= state.at_ns:
            return
        gain = self.touching_gain if touching else self.gain
        correct(self.ladder, self.c, self.offset, gain, state.x, state.disturbance, state.strength,
                state.stamps, state.inputs, self.period_ns, self.delay_ns, state.at_ns, captured_ns, measured)
        state.at_ns = captured_ns

    def predict(self, state: ObserverState, time_ns: int, stored: int) -> Array:
        """State of `LinearModel.sampled` at `time_ns`: x, then effective drives of the last `stored` periods.

        The observer's state does not change.
        """
        present: Array = predict(self.ladder, state.x, state.strength, state.stamps, state.inputs,
                               self.period_ns, self.delay_ns, state.at_ns, time_ns, stored)
        return present


@compiled
def record(stamps: Stamps, inputs: Array, time_ns: int, drive: Array) -> None:
    """Append to the records and drop the oldest."""
    last = stamps.size - 1
    for k in range(last):
        stamps[k] = stamps[k + 1]
        assign(inputs[k], inputs[k + 1])
    stamps[last] = time_ns
    assign(inputs[last], drive)


@compiled
def step_rung(ladder: Array, rung: int, x: Array, strength: Array, drive: Array, after: Array) -> None:
    """Propagate x over the duration of one rung, in place."""
    states = x.size
    after[:] = 0.0
    for j in range(states):
        for i in range(states):
            after[i] += ladder[rung, j, i] * x[j]
    for j in range(drive.size):
        force = strength[j] * drive[j]
        for i in range(states):
            after[i] += ladder[rung, states + j, i] * force
    assign(x, after)


@compiled
def propagate_held(
    ladder: Array, x: Array, strength: Array, drive: Array, period_ns: int, duration_ns: int, after: Array
) -> None:
    """Propagate x under a held drive: whole periods, then the binary digits of the rest's ms, us and ns."""
    while duration_ns >= period_ns:
        step_rung(ladder, ladder.shape[0] - 1, x, strength, drive, after)
        duration_ns -= period_ns
    for unit, first in ((1_000_000, 20), (1_000, 10), (1, 0)):
        rung, count = first, duration_ns // unit
        duration_ns -= count * unit
        while count > 0:
            if count & 1:
                step_rung(ladder, rung, x, strength, drive, after)
            count >>= 1
            rung += 1


@compiled
def propagate(
    ladder: Array, x: Array, strength: Array, stamps: Stamps, inputs: Array, period_ns: int, delay_ns: int,
    from_ns: int, to_ns: int,
) -> None:
    """Propagate x between two instants under the recorded inputs, each `delay_ns` late, in place."""
    after = np.empty(x.size)
    k = stamps.size - 1
    while k > 0 and stamps[k] + delay_ns > from_ns:
        k -= 1
    while from_ns < to_ns:
        stop = to_ns
        if k + 1 < stamps.size:
            stop = min(to_ns, stamps[k + 1] + delay_ns)
        propagate_held(ladder, x, strength, inputs[k], period_ns, stop - from_ns, after)
        from_ns = stop
        k += 1


@compiled
def correct(
    ladder: Array, c: Array, offset: Array, gain: Array, x: Array, disturbance: Array, strength: Array,
    stamps: Stamps, inputs: Array, period_ns: int, delay_ns: int, from_ns: int, captured_ns: int,
    measured: Array,
) -> None:
    """Propagate to the capture, then update by the measurement, in place."""
    propagate(ladder, x, strength, stamps, inputs, period_ns, delay_ns, from_ns, captured_ns)
    states = x.size
    innovation = measured - offset - disturbance
    for i in range(innovation.size):
        for j in range(states):
            innovation[i] -= c[i, j] * x[j]
    for i in range(innovation.size):
        for j in range(states):
            x[j] += gain[j, i] * innovation[i]
        for j in range(disturbance.size):
            disturbance[j] += gain[states + j, i] * innovation[i]


@compiled
def predict(
    ladder: Array, x: Array, strength: Array, stamps: Stamps, inputs: Array, period_ns: int, delay_ns: int,
    from_ns: int, to_ns: int, stored: int,
) -> Array:
    """State x at `to_ns`, then the effective drives of 1 ... `stored` periods before, flat."""
    states, muscles = x.size, inputs.shape[1]
    present = np.empty(states + stored * muscles)
    assign(present[:states], x)
    propagate(ladder, present[:states], strength, stamps, inputs, period_ns, delay_ns, from_ns, to_ns)
    k = stamps.size - 1
    for lag in range(1, stored + 1):
        # Half a period of tolerance: ticks of a rate with a period of fractional ns differ by 1 ns.
        while k > 0 and stamps[k] > to_ns - lag * period_ns + period_ns // 2:
            k -= 1
        for i in range(muscles):
            present[states + (lag - 1) * muscles + i] = strength[i] * inputs[k, i]
    return present
