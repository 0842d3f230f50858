"""Linear model predictive control of joint angles through recruitment."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal, cast

import numpy as np
from numpy.typing import NDArray

from controllers.allocation import Allocation
from controllers.mpc_kernel import give_out, pose
from controllers.mpc_plan import Plan, Weights, make_plan
from controllers.observer import Observer, ObserverState
from controllers.period import period_ns
from controllers.qp import Qp
from controllers.strength_adaptation import StrengthAdaptation, StrengthState
from fesloop.errors import InputError
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_MS, duration_ns
from fesloop.loop.guard import is_finite
from fesloop.loop.signals import Port, Sample, Value
from fesloop.loop.status import StatusLatch
from fesloop.models.linear_model import LinearModel

Array = NDArray[np.float64]


@dataclass(slots=True, eq=False)
class MpcState:
    """Everything that a running controller remembers, and what its clock decides.

    Attributes
    ----------
    plan, observer, reach, table: coefficients; never written to.
    estimate: of the plant, with the recorded drives.
    strength: of the muscles, where it is adapted.
    qp: the programme, warm.
    drive: (muscles,), in force.
    pulses: (muscles, 2), in force.
    held: (muscles,), drive from which a ramp to zero starts.
    trouble, trouble_ns: what keeps the controller from control, and since when; "" while all is well.
    """

    plan: Plan
    observer: Observer
    reach: Array
    table: Array
    estimate: ObserverState
    strength: StrengthState | None
    qp: Qp
    drive: Array
    pulses: Array
    held: Array
    trouble: str = ""
    trouble_ns: int = 0
    latch: StatusLatch = field(default_factory=StatusLatch)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Mpc:
    """Model predictive control: cost and limits in `mpc_plan`, estimation in `observer`.

    Each tick estimates the plant's state now from the newest sample, using its capture stamp and the
    recorded drives, solves the condensed programme and gives out its first drive, turned into pulse
    widths at fixed currents by inverting the model's recruitment. Any number of muscles and outputs will do.

    When the programme is not solved, a sample is not finite or the newest capture is older than
    `max_age_ms`, the last drive is held for `hold_ms` and then ramped to zero over `ramp_ms`, with a
    status. Before the first measurement there is no stimulation.

    Attributes
    ----------
    model: nominal plant; outputs rad, inputs the recruited fractions.
    current_ma: (muscles,), fixed current of each channel.
    horizon: periods N.
    output_weight: (outputs,), per rad^2; empty for 1 each.
    move_weight, effort_weight, cocontraction_weight: per unit of drive squared, as in `mpc_plan`.
    slew: greatest change of a drive a tick.
    drive_max: greatest drive; less where a channel cannot reach it.
    width_max_us, charge_max_uc, full_scale_us: as in `Allocation`; the last where the model has no
        recruitment.
    charge_rise_uc: greatest rise of a channel's charge per phase a tick (as `Safety` has it, which then
        has nothing to cut); not kept where the model has no recruitment.
    actuation_delay_ms: from this block to the plant, beyond the model's own delay.
    compensate_age: predict across the age of a sample; otherwise it counts as captured when it is read.
    adaptation: of the muscles' strengths, as they tire; none if left out.
    drive_noise, disturbance_deg, measurement_deg: sd of the drive's error, of the walk of the output
        disturbance over 1 s, and of a measurement, for the observer's gain.
    max_age_ms, hold_ms, ramp_ms: see above.
    solver: "daqp" or "osqp".

    Inputs: `reference_preview` (N, outputs), the reference at the coming ticks, or `reference` (outputs,),
    held constant ahead; `measured` (outputs,); all rad. Output: `stimulation` (muscles, 2).
    """

    model: LinearModel
    current_ma: tuple[float, ...]
    horizon: int = 20
    output_weight: tuple[float, ...] = ()
    move_weight: float = 0.01
    effort_weight: float = 0.0
    cocontraction_weight: float = 1e-5
    slew: float = 0.2
    drive_max: float = 1.0
    width_max_us: float = 500.0
    charge_max_uc: float = 20.0
    charge_rise_uc: float = 5.0
    full_scale_us: float = 500.0
    actuation_delay_ms: float = 0.0
    compensate_age: bool = True
    adaptation: StrengthAdaptation | None = None
    drive_noise: float = 0.05
    disturbance_deg: float = 20.0
    measurement_deg: float = 0.5
    max_age_ms: float = 400.0
    hold_ms: float = 100.0
    ramp_ms: float = 200.0
    solver: Literal["daqp", "osqp"] = "daqp"

    def __post_init__(self) -> None:
        sizes = f"the model has {self.model.inputs} muscles and {self.model.outputs} outputs"
        if len(self.current_ma) != self.model.inputs:
            raise InputError("current_ma", f"{len(self.current_ma)} currents",
                             f"{self.model.inputs}, one a muscle", sizes)
        if self.output_weight and len(self.output_weight) != self.model.outputs:
            raise InputError("output_weight", f"{len(self.output_weight)} weights",
                             f"{self.model.outputs}, one an output, or none", sizes)
        if self.horizon < 1:
            raise InputError("horizon", f"{self.horizon}", "1 or more periods")
        for key in ("move_weight", "slew", "drive_max", "drive_noise", "disturbance_deg", "measurement_deg",
                    "charge_rise_uc"):
            if not (math.isfinite(getattr(self, key)) and getattr(self, key) > 0.0):
                raise InputError(key, f"{getattr(self, key)}", "a finite value above 0")
        for key, values in (("output_weight", self.output_weight), ("effort_weight", (self.effort_weight,)),
                            ("cocontraction_weight", (self.cocontraction_weight,))):
            if not all(math.isfinite(value) and value >= 0.0 for value in values):
                raise InputError(key, f"{values}", "finite weights, 0 or more")
        for key in ("actuation_delay_ms", "max_age_ms", "hold_ms", "ramp_ms"):
            duration_ns(getattr(self, key), NS_PER_MS, key)
        self.allocation()

    @property
    def inputs(self) -> tuple[Port, ...]:
        """`reference_preview`, `reference`, `measured`."""
        outputs = self.model.outputs
        return (Port("reference_preview", (self.horizon, outputs), "rad", optional=True),
                Port("reference", (outputs,), "rad", optional=True), Port("measured", (outputs,), "rad"))

    @property
    def outputs(self) -> tuple[Port, ...]:
        """`stimulation`."""
        return (Port("stimulation", (self.model.inputs, 2), "A,s"),)

    def allocation(self) -> Allocation:
        """How drives become pulses."""
        return Allocation(recruitment=self.model.recruitment, current_ma=self.current_ma,
                          width_max_us=self.width_max_us, full_scale_us=self.full_scale_us,
                          charge_max_uc=self.charge_max_uc)

    def init(self, context: Context) -> MpcState:
        """At rest, the programme and the observer for the context's clock.

        Raises InputError for a horizon that ends before the first drive shows.
        """
        period = period_ns(context)
        actuation = duration_ns(self.actuation_delay_ms, NS_PER_MS, "actuation_delay_ms")
        model = self.model.sampled(period, actuation)
        if self.horizon <= model.delay_steps:
            raise InputError(
                f"{context.name}.horizon",
                f"{self.horizon} periods of {period / NS_PER_MS:g} ms end before the delay of "
                f"{(self.model.delay_ns + actuation) / NS_PER_MS:g} ms does",
                f"{model.delay_steps + 1} or more", "lengthen the horizon by what the movement takes")
        allocation, muscles = self.allocation(), self.model.inputs
        plan = make_plan(model, self.horizon, Weights(
            np.array(self.output_weight or (1.0,) * self.model.outputs), self.move_weight,
            self.effort_weight, self.cocontraction_weight))
        observer = Observer.design(
            self.model, period_ns=period, delay_ns=self.model.delay_ns + actuation,
            reach_ns=duration_ns(self.max_age_ms, NS_PER_MS, "max_age_ms"), drive_noise=self.drive_noise,
            disturbance_walk=math.radians(self.disturbance_deg),
            measurement_noise=math.radians(self.measurement_deg))
        return MpcState(plan, observer, np.minimum(self.drive_max, allocation.reach()), allocation.table(),
                        observer.init(), self.adaptation.init(observer) if self.adaptation else None,
                        Qp(plan.hessian, plan.rows, solver=self.solver, centred=True), np.zeros(muscles),
                        np.zeros((muscles, 2)), np.zeros(muscles))

    def step(self, state: MpcState, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """Pulses for this tick."""
        reference, measured, now_ns = self._reference(inputs), inputs[2], tick.time_ns
        if reference is None or measured.arrived_ns < 0:
            trouble, detail = "no_input", "no reference or measurement yet"
        elif now_ns - measured.newest_ns > self.max_age_ms * NS_PER_MS:
            trouble, detail = "stale_input", f"the newest capture is older than {self.max_age_ms:g} ms"
        else:
            trouble, detail = self._control(state, reference, measured, now_ns)
        if trouble:
            self._fall_back(state, tick, trouble, detail)
        state.trouble = trouble
        estimate = state.estimate
        state.pulses = np.empty((state.drive.size, 2))
        saturated = give_out(state.table, state.drive, estimate.stamps, estimate.inputs, now_ns, state.pulses)
        state.latch.put(tick, "saturated", saturated > 0, "a channel is at its longest pulse")
        return (state.pulses,)

    def _reference(self, inputs: Sequence[Sample]) -> Array | None:
        """Reference over the horizon, (N, outputs); None before any has come."""
        preview, now, _ = inputs
        if preview.arrived_ns >= 0:
            return cast(Array, preview.value)
        if now.arrived_ns >= 0:
            return np.tile(cast(Array, now.value), (self.horizon, 1))
        return None

    def _control(self, state: MpcState, reference: Array, sample: Sample, now_ns: int) -> tuple[str, str]:
        """Set the drive to the first of the optimal ones; what went wrong, ("", "") if nothing."""
        observer, estimate, measured = state.observer, state.estimate, cast(Array, sample.value)
        captured_ns = sample.newest_ns if self.compensate_age else now_ns
        if self.adaptation and state.strength and is_finite(measured):
            self.adaptation.correct(state.strength, observer, estimate, captured_ns, measured)
        best, (lower, upper) = np.empty(state.qp.size), np.empty((2, state.qp.constraints))
        finite = pose(
            observer.ladder, observer.c, observer.offset, observer.gain, estimate.x, estimate.disturbance,
            estimate.strength, estimate.stamps, estimate.inputs, observer.period_ns, observer.delay_ns,
            estimate.at_ns, captured_ns, now_ns, measured, state.plan.free, state.reach, self.slew,
            state.table, 1e-6 * self.charge_rise_uc, state.drive, state.pulses, reference,
            best, lower, upper)
        if not finite:
            return "non_finite", "an input is not finite"
        estimate.at_ns = max(estimate.at_ns, captured_ns)
        result = state.qp.solve(best, lower, upper)
        if result.status != "solved":
            return result.status, "quadratic programme: the last drive is held, then ramped to zero"
        state.drive = result.x[:state.drive.size]
        if state.strength:
            state.drive = np.minimum(state.drive / estimate.strength, state.reach)
        return "", ""

    def _fall_back(self, state: MpcState, tick: Tick, trouble: str, detail: str) -> None:
        """The declared safe output: hold, then ramp to zero."""
        if not state.trouble:
            state.trouble_ns, state.held = tick.time_ns, state.drive
        if trouble != state.trouble:
            tick.report(trouble, detail)
        ramping_ms = (tick.time_ns - state.trouble_ns) / NS_PER_MS - self.hold_ms
        share = 1.0 if ramping_ms <= 0.0 else max(0.0, 1.0 - ramping_ms / max(self.ramp_ms, 1e-9))
        state.drive = share * state.held
