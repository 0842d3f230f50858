"""What the plant's state is now, from measurements that are old by a known age and inputs that are recorded.

A Kalman filter stands at the instant of the newest capture. A new sample takes it on to its own capture
under the inputs that acted until then; to see the present, the estimate is taken on from there without
being moved. All transitions are exact to the nanosecond for a linear model behind a pure delay.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_discrete_are

from fesloop.compiled import compiled
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
    x: (states,), estimate then.
    disturbance: (outputs,), estimate of what the model leaves unexplained of the outputs, rad.
    strength: (muscles,), how strongly each muscle answers its drive, over what the model expects.
    stamps, inputs: (kept,) ns and (kept, muscles): when each drive was given out; oldest first.
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
        us, over 1, 2, 4 ... ms up to `period_ns`, and last over `period_ns` itself: most ways are made of
        whole periods and of a few ms.
    c, offset: output of the model, (outputs, states) and (outputs,).
    gain: (states + outputs, outputs).
    touching_gain: likewise while the hand touches something. The state then follows the drives alone and the
        disturbances of what is still seen follow the measurements: an object that blocks one joint alters
        how all answer, and a share in the state would tell that to every muscle.
    delay_ns: from giving a drive out to its acting on x.
    period_ns: of the samples.
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
        period_ns: of the samples, for the gain.
        delay_ns: from giving a drive out to its acting on the model's state, all delays together.
        reach_ns: oldest measurement to be understood.
        drive_noise: sd of the error of the drive, held over a period.
        disturbance_walk: sd of the output disturbance after one second, rad.
        measurement_noise: sd, rad.
        unseen: numbers of the outputs that are not seen while the hand touches something.
        touching_s: time constant with which disturbances of the others are then followed.
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
        """At rest before t = 0, nothing given out before."""
        states, muscles = self.ladder.shape[2], self.ladder.shape[1] - self.ladder.shape[2]
        return ObserverState(NEVER, np.zeros(states), np.zeros(self.offset.size), np.ones(muscles),
                             np.full(self.kept, _LONG_AGO, dtype=np.int64), np.zeros((self.kept, muscles)))

    def record(self, state: ObserverState, time_ns: int, drive: Array) -> None:
        """A drive is given out at `time_ns`."""
        record(state.stamps, state.inputs, time_ns, drive)

    def correct(
        self, state: ObserverState, captured_ns: int, measured: Array, touching: bool = False
    ) -> None:
        """Take in outputs (outputs,) in rad as they were at `captured_ns`; nothing if that is no news."""
        if captured_ns <= state.at_ns:
            return
        gain = self.touching_gain if touching else self.gain
        correct(self.ladder, self.c, self.offset, gain, state.x, state.disturbance, state.strength,
                state.stamps, state.inputs, self.period_ns, self.delay_ns, state.at_ns, captured_ns, measured)
        state.at_ns = captured_ns

    def ahead(self, state: ObserverState, time_ns: int, stored: int) -> Array:
        """Estimate at `time_ns`, fresh: x, then what the drives given out 1 ... `stored` periods before do.

        That is the state of `LinearModel.sampled` for the same delay. The observer's state is left alone.
        """
        present: Array = ahead(self.ladder, state.x, state.strength, state.stamps, state.inputs,
                               self.period_ns, self.delay_ns, state.at_ns, time_ns, stored)
        return present


@compiled
def record(stamps: Stamps, inputs: Array, time_ns: int, drive: Array) -> None:
    """Append to the records, the oldest falling out."""
    stamps[:-1] = stamps[1:]
    inputs[:-1] = inputs[1:]
    stamps[-1] = time_ns
    inputs[-1] = drive


@compiled
def step_rung(ladder: Array, rung: int, x: Array, strength: Array, drive: Array, after: Array) -> None:
    """x over the duration of one rung, in place."""
    states = x.size
    after[:] = 0.0
    for j in range(states):
        for i in range(states):
            after[i] += ladder[rung, j, i] * x[j]
    for j in range(drive.size):
        force = strength[j] * drive[j]
        for i in range(states):
            after[i] += ladder[rung, states + j, i] * force
    x[:] = after


@compiled
def hold(
    ladder: Array, x: Array, strength: Array, drive: Array, period_ns: int, duration_ns: int, after: Array
) -> None:
    """x over a duration under a held drive: whole periods, then the bits of ms, us and ns of the rest."""
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
def carry(
    ladder: Array, x: Array, strength: Array, stamps: Stamps, inputs: Array, period_ns: int, delay_ns: int,
    from_ns: int, to_ns: int,
) -> None:
    """x from one instant to another under the recorded inputs, each acting `delay_ns` after it was given."""
    after = np.empty(x.size)
    k = stamps.size - 1
    while k > 0 and stamps[k] + delay_ns > from_ns:
        k -= 1
    while from_ns < to_ns:
        stop = to_ns
        if k + 1 < stamps.size:
            stop = min(to_ns, stamps[k + 1] + delay_ns)
        hold(ladder, x, strength, inputs[k], period_ns, stop - from_ns, after)
        from_ns = stop
        k += 1


@compiled
def correct(
    ladder: Array, c: Array, offset: Array, gain: Array, x: Array, disturbance: Array, strength: Array,
    stamps: Stamps, inputs: Array, period_ns: int, delay_ns: int, from_ns: int, captured_ns: int,
    measured: Array,
) -> None:
    """Carry to the capture, then the measurement update, in place."""
    carry(ladder, x, strength, stamps, inputs, period_ns, delay_ns, from_ns, captured_ns)
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
def ahead(
    ladder: Array, x: Array, strength: Array, stamps: Stamps, inputs: Array, period_ns: int, delay_ns: int,
    from_ns: int, to_ns: int, stored: int,
) -> Array:
    """x carried to `to_ns`, then what the drives in force 1 ... `stored` periods before do, flat."""
    states, muscles = x.size, inputs.shape[1]
    present = np.empty(states + stored * muscles)
    present[:states] = x
    carry(ladder, present[:states], strength, stamps, inputs, period_ns, delay_ns, from_ns, to_ns)
    k = stamps.size - 1
    for lag in range(1, stored + 1):
        # Half a period of tolerance: ticks of a rate that is no whole number of ns differ by 1 ns.
        while k > 0 and stamps[k] > to_ns - lag * period_ns + period_ns // 2:
            k -= 1
        present[states + (lag - 1) * muscles:states + lag * muscles] = strength * inputs[k]
    return present
