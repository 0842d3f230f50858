"""`pid`: PID control of joint angles through a mixing matrix onto muscles."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal, Self, cast

import numpy as np
from numpy.typing import NDArray

from controllers.allocation import Allocation, allocate
from controllers.timing import period_ns
from fesloop.compiled import compiled
from fesloop.errors import InputError
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_S
from fesloop.loop.record import StatusLatch
from fesloop.loop.signals import Port, Sample, Value
from fesloop.models.linear_form import BlockToControl, SampledForm
from fesloop.models.linear_model import Recruitment

if TYPE_CHECKING:
    import control

Array = NDArray[np.float64]
INTEGRAL, DERIVATIVE, PREVIOUS = 0, 1, 2
"""Rows of the memory: integral part, filtered derivative part, measurement of the tick before."""
RUNNING, SATURATED, NON_FINITE = 0, 1, 2
"""Outcomes of a tick."""


@compiled
def pid_tick(
    gains: Array, mixing: Array, channels: Array, table: Array, memory: Array, primed: bool,
    reference: Array, measured: Array,
) -> tuple[int, Array]:
    """One tick: RUNNING, SATURATED or NON_FINITE, and the pulses (muscles, 2), A and s.

    Parameters
    ----------
    gains: (joints, 4): kp, ki h, alpha, beta as in `Pid`.
    mixing: (muscles, joints).
    channels: (muscles, 3): bias, least and greatest drive.
    table: from `Allocation.table`.
    memory: (3, joints), updated in place; unchanged for non-finite input, but not for overflow inside.
    primed: whether `memory` holds a previous measurement.
    """
    muscles, joints = mixing.shape
    pulses = np.zeros((muscles, 2))
    for j in range(joints):
        if not (math.isfinite(reference[j]) and math.isfinite(measured[j])):
            return NON_FINITE, pulses
    drive = channels[:, 0].copy()
    for j in range(joints):
        moved = measured[j] - memory[PREVIOUS, j] if primed else 0.0
        memory[DERIVATIVE, j] = gains[j, 2] * memory[DERIVATIVE, j] - gains[j, 3] * moved
        memory[PREVIOUS, j] = measured[j]
        command = gains[j, 0] * (reference[j] - measured[j]) + memory[INTEGRAL, j] + memory[DERIVATIVE, j]
        for i in range(muscles):
            drive[i] += mixing[i, j] * command
    for i in range(muscles):
        if not math.isfinite(drive[i]):
            return NON_FINITE, pulses
    for j in range(joints):
        growth = gains[j, 1] * (reference[j] - measured[j])
        if can_follow(mixing[:, j], channels, drive, growth):
            memory[INTEGRAL, j] += growth
    for i in range(muscles):
        drive[i] = min(max(drive[i], channels[i, 1]), channels[i, 2])
    saturated = allocate(table, drive, pulses)
    return (SATURATED if saturated else RUNNING), pulses


@compiled
def can_follow(weights: Array, channels: Array, drive: Array, growth: float) -> bool:
    """Whether the integral of a joint may grow: a muscle can follow, or most muscles leave saturation."""
    deeper, back = 0.0, 0.0
    for i in range(weights.size):
        change = weights[i] * growth
        low, high = drive[i] <= channels[i, 1], drive[i] >= channels[i, 2]
        if not low and not high and change != 0.0:
            return True
        if (low and change < 0.0) or (high and change > 0.0):
            deeper += abs(weights[i])
        elif change != 0.0:
            back += abs(weights[i])
    return back >= deeper


def _pid_gains(where: str, controller: control.TransferFunction) -> tuple[float, float, float, float]:
    """kp, ki, kd and the filter time of kp + ki/s + kd s/(Tf s + 1), s.

    Raises InputError for another transfer function.
    """
    if not hasattr(controller, "num") or controller.ninputs != 1 or controller.noutputs != 1 or controller.dt:
        raise InputError(where, f"a {type(controller).__name__}", "a continuous-time SISO transfer function",
                         "convert it with control.tf")
    above, below = (np.trim_zeros(np.asarray(part[0][0], dtype=np.float64), "f")
                    for part in (controller.num, controller.den))
    if below[-1] != 0.0:  # no integral: the same times s/s
        above, below = np.append(above, 0.0), np.append(below, 0.0)
    if above.size > 3 or below.size not in (2, 3) or below[-2] == 0.0:
        raise InputError(where, f"({above.tolist()}) / ({below.tolist()})", "kp + ki/s + kd s/(Tf s + 1)")
    second, first, ki = np.pad(above, (3 - above.size, 0)) / below[-2]
    filter_s = float(below[0] / below[1]) if below.size == 3 else 0.0
    kp = first - ki * filter_s
    return float(kp), float(ki), float(second - kp * filter_s), filter_s


Matrix = tuple[tuple[float, ...], ...]


@dataclass(slots=True, eq=False)
class PidState:
    """State of the controller, with the coefficients that follow from its clock.

    Attributes
    ----------
    gains, mixing, channels, table: constant arguments of `pid_tick`.
    memory: (3, joints), rows as numbered above.
    primed: whether a measurement has arrived.
    outcome: outcome of the last tick.
    latch: statuses that hold until they end.
    """

    gains: Array
    mixing: Array
    channels: Array
    table: Array
    memory: Array
    primed: bool = False
    outcome: int = 0
    latch: StatusLatch = field(default_factory=StatusLatch)


@dataclass(frozen=True, slots=True, kw_only=True)
class Pid(BlockToControl):
    """One PID controller for each joint, with their commands mixed onto muscles.

    With period h, error e = reference - measured and measurement y, joint by joint,

        u[k] = kp e[k] + I[k] + D[k]
        I[k+1] = I[k] + ki h e[k]
        D[k] = alpha D[k-1] - beta (y[k] - y[k-1]),   alpha = Tf / (Tf + h),  beta = kd / (Tf + h)

    (forward difference for the integral, backward for the filtered derivative of the measurement: Astrom
    and Murray, Feedback Systems, 2nd ed., section 11.5, ISBN 978-0-691-19398-4). Muscle drives are
    v = bias + mixing u, limited to what each channel can recruit. Anti-windup is conditional integration:
    I stays constant while no muscle of the joint can follow its growth and most, by their weight in
    `mixing`, would go deeper into saturation.

    Attributes
    ----------
    kp, ki, kd: (joints,), drive per rad, per rad s, and drive s per rad.
    derivative_filter_ms: Tf.
    mixing: (muscles, joints), drive of each muscle per unit of joint command.
    bias: (muscles,), drive at zero command: co-contraction; empty for none.
    current_ma: (muscles,), fixed current of each channel.
    recruitment_curve: "lognormal" inverts `recruitment`; "linear" takes pulse width = v x `full_scale_us`,
        signed and unlimited, for the theory of the linear loop.
    recruitment: nominal curves; needed for "lognormal".
    width_max_us: longest pulse.
    full_scale_us: pulse width of v = 1 under "linear".

    Inputs: `reference` and `measured` (joints,), rad. Output: `stimulation` (muscles, 2). Without a
    measurement, or with a non-finite input, stimulation is zero, with a status.
    """

    kp: tuple[float, ...]
    ki: tuple[float, ...]
    kd: tuple[float, ...]
    mixing: Matrix
    current_ma: tuple[float, ...]
    derivative_filter_ms: float = 20.0
    bias: tuple[float, ...] = ()
    recruitment_curve: Literal["lognormal", "linear"] = "lognormal"
    recruitment: Recruitment | None = None
    width_max_us: float = 500.0
    full_scale_us: float = 500.0

    def __post_init__(self) -> None:
        for key in ("kp", "ki", "kd"):
            values = getattr(self, key)
            if not values or len(values) != len(self.kp):
                raise InputError(key, f"{len(values)} values", "as many as kp, one a joint, one or more")
            if not all(math.isfinite(value) for value in values):
                raise InputError(key, f"{values}", "finite values")
        if len(self.mixing) != self.muscles or any(len(row) != self.joints for row in self.mixing):
            raise InputError("mixing", f"rows of {[len(row) for row in self.mixing]}",
                             f"{self.muscles} rows, one a muscle, of {self.joints} values, one a joint")
        if not all(math.isfinite(weight) for row in self.mixing for weight in row):
            raise InputError("mixing", "a weight that is not finite", "finite weights")
        if self.bias and len(self.bias) != self.muscles:
            raise InputError("bias", f"{len(self.bias)} values", f"{self.muscles}, one a muscle, or none")
        if not all(math.isfinite(value) and value >= 0.0 for value in self.bias):
            raise InputError("bias", f"{self.bias}", "finite drives, 0 or more")
        if not (math.isfinite(self.derivative_filter_ms) and self.derivative_filter_ms >= 0.0):
            raise InputError("derivative_filter_ms", f"{self.derivative_filter_ms}", "0 or more")
        if self.recruitment_curve == "lognormal" and self.recruitment is None:
            raise InputError("recruitment", "no nominal curves", "thresholds and spreads",
                             'or take recruitment_curve = "linear"')
        self.allocation()

    @classmethod
    def from_control(cls, controllers: Sequence[control.TransferFunction], **parameters: Any) -> Self:
        """The PID with the gains of continuous-time transfer functions, one a joint.

        Each is kp + ki/s + kd s/(Tf s + 1), all with the same Tf; `parameters` are the other attributes.
        Raises InputError for another transfer function.
        """
        rows = [_pid_gains(f"controllers[{joint}]", each) for joint, each in enumerate(controllers)]
        filters = {round(1e3 * filter_s, 9) for *_, kd, filter_s in rows if kd != 0.0} or {0.0}
        if len(filters) > 1:
            raise InputError("controllers", f"filter times of {sorted(filters)} ms", "one for all joints")
        kp, ki, kd = (tuple(row[k] for row in rows) for k in range(3))
        return cls(kp=kp, ki=ki, kd=kd, derivative_filter_ms=filters.pop(), **parameters)

    @property
    def joints(self) -> int:
        """Number of joints."""
        return len(self.kp)

    @property
    def muscles(self) -> int:
        """Number of muscles and channels."""
        return len(self.current_ma)

    @property
    def inputs(self) -> tuple[Port, ...]:
        """`reference`, `measured`."""
        return Port("reference", (self.joints,), "rad"), Port("measured", (self.joints,), "rad")

    @property
    def outputs(self) -> tuple[Port, ...]:
        """`stimulation`."""
        return (Port("stimulation", (self.muscles, 2), "A,s"),)

    def allocation(self) -> Allocation:
        """Conversion of drives to pulses."""
        curves = self.recruitment if self.recruitment_curve == "lognormal" else None
        return Allocation(recruitment=curves, current_ma=self.current_ma,
                          width_max_us=self.width_max_us, full_scale_us=self.full_scale_us)

    def gains(self, period_s: float) -> Array:
        """Coefficients (joints, 4): kp, ki h, alpha, beta."""
        filter_s = 1e-3 * self.derivative_filter_ms
        return np.column_stack([
            np.asarray(self.kp), np.asarray(self.ki) * period_s,
            np.full(self.joints, filter_s / (filter_s + period_s)),
            np.asarray(self.kd) / (filter_s + period_s)])

    def sampled(self, period_s: float) -> tuple[Array, Array, Array, Array]:
        """Matrices a, b, c, d from [reference; measured] to muscle drives less their bias, unsaturated.

        The state is I[k], D[k-1], y[k-1], each (joints,).
        """
        kp, ki_h, alpha, beta = (np.diag(column) for column in self.gains(period_s).T)
        zero, one = np.zeros_like(kp), np.eye(self.joints)
        a = np.block([[one, zero, zero], [zero, alpha, beta], [zero, zero, zero]])
        b = np.block([[ki_h, -ki_h], [zero, -beta], [zero, one]])
        mixing = np.asarray(self.mixing)
        return a, b, mixing @ np.hstack([one, alpha, beta]), mixing @ np.hstack([kp, -kp - beta])

    def linear_form(self, context: Context) -> SampledForm:
        """Unsaturated law; under "linear" to pulse widths."""
        a, b, c, d = self.sampled(period_ns(context) / NS_PER_S)
        lognormal = self.recruitment_curve == "lognormal"
        scale = 1.0 if lognormal else 1e-6 * self.full_scale_us
        return SampledForm(inputs=("reference", "measured"), output="stimulation", a=a, b=b, c=scale * c,
                           d=scale * d, noise=np.zeros((self.muscles, 0)),
                           curves=self.recruitment if lognormal else None,
                           offset=scale * np.array(self.bias or (0.0,) * self.muscles),
                           least=np.zeros(self.muscles) if lognormal else None,
                           greatest=self.allocation().reach() if lognormal else None)

    def init(self, context: Context) -> PidState:
        """State at rest, with the coefficients for the context's clock."""
        period_s = period_ns(context) / NS_PER_S
        allocation, linear = self.allocation(), self.recruitment_curve == "linear"
        channels = np.zeros((self.muscles, 3))
        channels[:, 0] = self.bias or 0.0
        channels[:, 1] = -np.inf if linear else 0.0
        channels[:, 2] = allocation.reach()
        return PidState(self.gains(period_s), np.ascontiguousarray(self.mixing, dtype=np.float64), channels,
                        allocation.table(), np.zeros((3, self.joints)))

    def step(self, state: PidState, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """Pulses for this tick."""
        reference, measured = inputs
        if measured.arrived_ns < 0 or reference.arrived_ns < 0:
            state.latch.put(tick, "no_input", True, "no reference or measurement yet: no stimulation")
            return (np.zeros((self.muscles, 2)),)
        outcome, pulses = pid_tick(state.gains, state.mixing, state.channels, state.table, state.memory,
                                   state.primed, cast(Array, reference.value), cast(Array, measured.value))
        if outcome != NON_FINITE:
            state.primed = True
        if outcome != state.outcome:
            self._report(state, outcome, tick)
        return (pulses,)

    def _report(self, state: PidState, outcome: int, tick: Tick) -> None:
        """Report what has changed since the last tick."""
        state.latch.put(tick, "non_finite", outcome == NON_FINITE, "input is not finite: no stimulation")
        state.latch.put(tick, "saturated", outcome == SATURATED, "a channel is at its longest pulse")
        state.outcome = outcome
