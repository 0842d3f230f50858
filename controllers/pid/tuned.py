"""`tuned_pid`: PID and feedforward of a few outputs, tuned and mixed by the patient's model."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, cast

import numpy as np
from numpy.typing import NDArray

from controllers.allocation import Allocation, allocate, allocation_of, risen
from controllers.pid.tuning import RuleName, Tuning, gain_at_rest, tuned
from controllers.quadratic_programme import Qp
from controllers.timing import period_ns
from fesloop.errors import InputError
from fesloop.loop.abilities import AgeLimit
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_MS, NS_PER_S, RateClock, duration_ns
from fesloop.loop.record import StatusLatch
from fesloop.loop.signals import Port, Sample, Value, is_finite
from fesloop.models.linear_model import LinearModel

if TYPE_CHECKING:
    import control

Array = NDArray[np.float64]
_EFFORT = 1e-6
"""Weight of drives in their mixing, relative to the strongest gain: it decides only between drives
with equal effects on the outputs (chosen)."""
_FARTHEST = 10.0
"""Limit of references and outputs, relative to the effect of all drives together (chosen: far outside any
hand, and within the resolution of the programme)."""
_FILTERED = 0.1
"""Time constant of the derivative's filter over the derivative time (customary: an eighth to a twentieth)."""


def mixing_hessian(gain: Array) -> Array:
    """Matrix of the cost |gain v - u|^2 + effort |v|^2 in the drives v; `gain` is (outputs, muscles)."""
    hessian = gain.T @ gain
    hessian += _EFFORT * np.linalg.norm(gain, 2)**2 * np.eye(gain.shape[1])
    return np.asarray(hessian)


def farthest(gain: Array, reach: Array) -> Array:
    """Limit (outputs,) of references and outputs, rad from rest, of a gain and greatest drives."""
    limit: Array = _FARTHEST * np.abs(gain) @ reach
    return limit


@dataclass(slots=True, eq=False)
class TunedPidState:
    """State of the controller, with the coefficients that follow from its clock.

    Attributes
    ----------
    gains: (outputs, 5): kp, integral gain a tick, anti-windup gain a tick, the derivative's pole and gain.
    gain: (outputs, muscles), gain at rest.
    reach: (muscles,), greatest drives.
    table: from `Allocation.table`.
    qp: programme of the mixing.
    late, slow: (outputs,), delay in ticks, and pole a tick, of the expected response to the feedforward.
    ahead: (outputs,), index of the coming reference that is delay and lag from now.
    integral, derivative, previous: (outputs,), rad.
    asked: (ticks, outputs), rad, references f, newest first.
    expected: (outputs,), expected response to them.
    pulses: (muscles, 2), present pulses.
    primed: whether a measurement has arrived.
    trouble: status of the tick before; "" for none.
    latch: statuses that hold until they end.
    """

    gains: Array
    gain: Array
    reach: Array
    table: Array
    qp: Qp
    late: NDArray[np.int64]
    slow: Array
    ahead: NDArray[np.int64]
    integral: Array
    derivative: Array
    previous: Array
    pulses: Array
    asked: Array
    expected: Array
    primed: bool = False
    trouble: str = ""
    latch: StatusLatch = field(default_factory=StatusLatch)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TunedPid:
    """PID of a few outputs through many channels, gains and mixing from the patient's model.

    With the gain K of the model after 2 s, y measured, f the reference, lag and delay ahead of now where
    there is a preview of it, output by output,

        e = f exp(-delay s) / (lag s + 1) - y                expected response to the feedforward, less y
        u = (f - offset) + kp e + I + D                      commanded outputs, from rest
        v = argmin |K v - u|^2 + effort |v|^2, 0 <= v <= limits        drives of the muscles
        I[k+1] = I[k] + (kp h / Ti) e + (h / Ti) (K v - u)
        D[k] = alpha D[k-1] - beta (y[k] - y[k-1])

    so that the feedforward is the inverse of that gain, within the limits, and feedback corrects only what
    the model does not predict (two degrees of freedom: Astrom and Hagglund 2006, Advanced PID Control,
    section 5.3); without feedforward e = reference - y. The integral is reduced by what the limits cut off
    (back-calculation, ibid., section 3.5, tracking time Ti). Where no drives reach the reference, the steady
    state has the least sum of kp e^2. Gains, lag and delay are those of `controllers.pid.tuning`, with the
    delay of the model, `delay_ms` and half a period.

    Attributes
    ----------
    model: model of the patient; outputs rad, inputs the recruited fractions.
    current_ma: (muscles,), fixed current of each channel.
    rule: "simc": PI by Skogestad; "amigo": PID by Astrom and Hagglund.
    closed_loop_ms: time constant of the closed loop for "simc"; 0: as long as the loop's delay.
    delay_ms: delay of the loop beyond the model: usual age of `measured` when it is read.
    feedforward: whether the term (f - offset) is used.
    preview: number of coming references, one a tick, in `reference_preview`; 0: no such input.
    width_max_us, charge_max_uc, full_scale_us: as in `Allocation`; the last is used where the model has no
        recruitment.
    charge_rise_uc: greatest rise of a channel's charge per phase a tick, as in `Safety`; without effect where
        the model has no recruitment.
    begin_s: time in a trial before which it commands and learns nothing: the hand is held in a pose, or
        relaxes after. An integral would grow on what it cannot move.
    max_age_ms: greatest age of `measured`, counted from its newest capture.

    Inputs: `reference` and `measured` (outputs,), rad; `reference_preview` (preview, outputs), rad.
    Output: `stimulation` (muscles, 2). Without a measurement, with one that is too old or an input that is
    not finite, stimulation is zero, with a status, and the integral stays constant.
    """

    model: LinearModel
    current_ma: tuple[float, ...]
    rule: RuleName = "simc"
    closed_loop_ms: float = 0.0
    delay_ms: float = 20.0
    feedforward: bool = True
    preview: int = 0
    width_max_us: float = 500.0
    charge_max_uc: float = 20.0
    full_scale_us: float = 500.0
    charge_rise_uc: float = 5.0
    begin_s: float = 0.0
    max_age_ms: float = 400.0

    def __post_init__(self) -> None:
        if len(self.current_ma) != self.model.inputs:
            raise InputError("current_ma", f"{len(self.current_ma)} currents",
                             f"{self.model.inputs}, one a muscle of the model")
        if self.rule not in ("simc", "amigo"):
            raise InputError("rule", f"{self.rule!r}", "simc, amigo")
        if self.preview < 0:
            raise InputError("preview", f"{self.preview}", "0 or more instants")
        for key in ("closed_loop_ms", "delay_ms", "max_age_ms"):
            duration_ns(getattr(self, key), NS_PER_MS, key)
        duration_ns(self.begin_s, NS_PER_S, "begin_s")
        if not (math.isfinite(self.charge_rise_uc) and self.charge_rise_uc > 0.0):
            raise InputError("charge_rise_uc", f"{self.charge_rise_uc}", "a finite charge above 0")
        self.allocation()
        tuned(self.model, self.rule, extra_delay_s=max(1e-3 * self.delay_ms, 1e-3), closed_loop_s=0.0)

    @property
    def inputs(self) -> tuple[Port, ...]:
        """`reference`, `measured` and, with a preview, `reference_preview`."""
        now = Port("reference", (self.model.outputs,), "rad"), Port("measured", (self.model.outputs,), "rad")
        if self.preview == 0:
            return now
        return (*now, Port("reference_preview", (self.preview, self.model.outputs), "rad"))

    @property
    def outputs(self) -> tuple[Port, ...]:
        """`stimulation`."""
        return (Port("stimulation", (self.model.inputs, 2), "A,s"),)

    def allocation(self) -> Allocation:
        """Conversion of drives to pulses."""
        return allocation_of(self)

    def tuning(self, period_s: float) -> list[Tuning]:
        """Gains and fitted lag of each output, for a period."""
        return tuned(self.model, self.rule, extra_delay_s=1e-3 * self.delay_ms + 0.5 * period_s,
                     closed_loop_s=1e-3 * self.closed_loop_ms)

    def gains(self, period_s: float) -> Array:
        """Coefficients (outputs, 5), as in `TunedPidState`."""
        rows = []
        for (kp, integral_s, derivative_s), _ in self.tuning(period_s):
            filter_s = _FILTERED * derivative_s
            rows.append((kp, kp * period_s / integral_s, period_s / integral_s,
                         filter_s / (filter_s + period_s), kp * derivative_s / (filter_s + period_s)))
        return np.array(rows)

    def to_control(self, rate: str | int | float) -> control.StateSpace:
        """The law without limits at a rate in hertz, as a discrete-time `control.StateSpace`.

        Its inputs are [reference; measured] less the model's offset, its outputs drives; the preview equals
        the reference. Limits act wherever a drive would be negative, so that antagonists follow it in part
        only.
        """
        import control

        clock = RateClock.from_rate(rate)
        state = self.init(Context(type(self).__name__, clock=clock))
        kp, integral, pull, pole, filtered = (np.diag(column) for column in state.gains.T)
        outputs, past = self.model.outputs, len(state.asked)
        drives = np.linalg.solve(mixing_hessian(state.gain), state.gain.T)
        # Columns: integral, derivative, previous, expected, asked from the newest on | reference, measured.
        columns = {name: np.eye(outputs, (6 + past) * outputs, k * outputs) for k, name in enumerate(
            ("integral", "derivative", "previous", "expected", *range(past), "reference", "measured"))}
        reference, measured = columns["reference"], columns["measured"]
        asked, expected = [reference, *(columns[k] for k in range(past - 1))], reference
        if self.feedforward:
            due = np.stack([asked[late][output] for output, late in enumerate(state.late)])
            slow = state.slow[:, np.newaxis]
            expected = slow * columns["expected"] + (1.0 - slow) * due
        derivative = pole @ columns["derivative"] - filtered @ (measured - columns["previous"])
        asked_for = kp @ (expected - measured) + columns["integral"] + derivative
        asked_for = asked_for + (reference if self.feedforward else 0.0)
        grown = (columns["integral"] + integral @ (expected - measured)
                 + pull @ (state.gain @ drives - np.eye(outputs)) @ asked_for)
        rows = np.vstack([grown, derivative, measured, expected, *asked])
        states = (4 + past) * outputs
        output = drives @ asked_for
        return control.ss(rows[:, :states], rows[:, states:], output[:, :states], output[:, states:],
                          clock.period_s)

    def age_limits(self) -> tuple[AgeLimit, ...]:
        """Age limit of `measured`."""
        return (AgeLimit(port="measured", limit_ms=self.max_age_ms, since="newest", then="no stimulation"),)

    def init(self, context: Context) -> TunedPidState:
        """State at rest, with the coefficients for the context's clock."""
        gain, allocation, nothing = gain_at_rest(self.model), self.allocation(), np.zeros(self.model.outputs)
        period_s = period_ns(context) / NS_PER_S
        lags = [lag for _, lag in self.tuning(period_s)]
        late = np.array([round(lag.delay_s / period_s) for lag in lags])
        ahead = np.array([round((lag.delay_s + lag.lag_s) / period_s) for lag in lags])
        if 0 < self.preview < ahead.max():
            raise InputError(f"{context.name}.preview", f"{self.preview} instants", f"{ahead.max()} or more",
                             "the reference must be known a delay and a lag before")
        return TunedPidState(
            self.gains(period_s), gain, np.minimum(allocation.reach(), 1.0), allocation.table(),
            Qp(mixing_hessian(gain), np.empty((0, self.model.inputs))), late,
            np.exp([-period_s / lag.lag_s for lag in lags]), ahead - 1, integral=nothing, derivative=nothing,
            previous=nothing, pulses=np.zeros((self.model.inputs, 2)),
            asked=np.zeros((int(late.max()) + 1, nothing.size)), expected=nothing)

    def step(self, state: TunedPidState, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """Pulses for this tick."""
        reference, measured, *preview = inputs
        trouble, detail, drive = "", "", np.zeros(self.model.inputs)
        if reference.arrived_ns < 0 or measured.arrived_ns < 0:
            trouble, detail = "no_input", "no reference or measurement yet"
        elif tick.time_ns - measured.newest_ns > self.max_age_ms * NS_PER_MS:
            age_ms = (tick.time_ns - measured.newest_ns) / NS_PER_MS
            trouble, detail = "stale_input", (
                f"the newest capture behind `measured` is {age_ms:.4g} ms old, "
                f"older than {self.max_age_ms:g} ms")
        elif not all(is_finite(each.value) for each in inputs):
            trouble, detail = "non_finite", "an input is not finite"
        elif tick.time_ns >= self.begin_s * NS_PER_S:
            wanted = asked = cast(Array, reference.value)
            if preview and preview[0].present:
                asked = cast(Array, preview[0].value)[state.ahead, np.arange(wanted.size)]
            trouble, drive = self._control(state, wanted, asked, cast(Array, measured.value))
            detail = "mixing of the drives"
        if trouble and trouble != state.trouble:
            tick.report(trouble, f"{detail}: no stimulation")
        state.trouble = trouble
        state.pulses = np.empty((self.model.inputs, 2))
        saturated = allocate(state.table, drive, state.pulses)
        state.latch.put(tick, "saturated", saturated > 0, "a channel is at its longest pulse")
        return (state.pulses,)

    def _control(self, state: TunedPidState, reference: Array, asked: Array,
                 measured: Array) -> tuple[str, Array]:
        """Status, "" without trouble, and the drives (muscles,); `asked` is f."""
        kp, integral, pull, pole, rate = state.gains.T
        limit = farthest(state.gain, state.reach)
        rest = self.model.offset
        reference, asked, measured = (rest + np.clip(each - rest, -limit, limit)
                                      for each in (reference, asked, measured))
        expected = self._expected(state, asked, measured) if self.feedforward else reference
        error = expected - measured
        moved = measured - state.previous if state.primed else 0.0 * error
        derivative = pole * state.derivative - rate * moved
        wanted = kp * error + state.integral + derivative
        if self.feedforward:
            wanted += asked - rest
        rise = np.empty(self.model.inputs)
        risen(state.table, state.pulses, 1e-6 * self.charge_rise_uc, rise)
        result = state.qp.solve(-state.gain.T @ wanted, np.zeros_like(rise), np.minimum(state.reach, rise))
        if not result.solved:
            return result.status, np.zeros(self.model.inputs)
        grown = state.integral + integral * error + pull * (state.gain @ result.x - wanted)
        state.integral = np.clip(grown, -limit, limit)
        state.derivative, state.previous, state.primed = derivative, measured, True
        return "", result.x

    def _expected(self, state: TunedPidState, asked: Array, measured: Array) -> Array:
        """Expected response of the outputs to the feedforward; records the reference."""
        if not state.primed:
            state.asked[:], state.expected = measured, measured
        state.asked = np.vstack((asked, state.asked[:-1]))
        due = state.asked[state.late, np.arange(asked.size)]
        state.expected = state.slow * state.expected + (1.0 - state.slow) * due
        return state.expected
