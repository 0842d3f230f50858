"""`mpc`: linear model predictive control of joint angles through recruitment."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import cast

import numpy as np
from numpy.typing import NDArray

from controllers.force_sensors import contact_force, require_count, wired_places
from controllers.mpc import checks as mpc_checks
from controllers.mpc.design import candidates_of, carry_over, compare, nominal
from controllers.mpc.kernel import Task, build_problem, issue_drive, solve_in_contact
from controllers.mpc.memory import Course
from controllers.mpc.parameters import MpcParameters
from controllers.mpc.state import Loop, MpcState, fall_back
from controllers.quadratic_programme import NOT_FINITE
from controllers.reach import reach_of
from controllers.timing import period_ns
from fesloop.errors import InputError
from fesloop.loop.abilities import AgeLimit, Surroundings
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_MS, NS_PER_S, duration_ns
from fesloop.loop.signals import Port, Sample, Sensors, Value, is_finite

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Mpc(MpcParameters):
    """Model predictive control: cost and limits in `mpc.plan`, estimation in `mpc.observer`, learning from
    trial to trial in `mpc.memory`.

    Each tick estimates the plant's present state from the newest sample, its capture stamp and the recorded
    drives, solves the condensed programme and issues its first drive, converted to pulse widths at fixed
    currents by inverting the model's recruitment, for any number of muscles and outputs.

    When the programme has no solution, the last one continues to its end. After that, and for a sample that
    is not finite or older than `max_age_ms`, the drive is held for `hold_ms` and ramped to zero over
    `ramp_ms`, with a status. Before the first measurement there is no stimulation.

    Where an object blocks fingers, their error says nothing about the plant, and control free of offset would
    press harder and harder. From the first contact that force sensors feel on, `grasping_outputs` therefore
    count as unmeasured and their disturbances stay constant; `grasping_channels` follow the model alone, the
    others the measurements of other outputs, such as the wrist's (`mpc.kernel.solve_in_contact`).

    Parameters are those of `MpcParameters`.

    Inputs: `reference_preview` (N, outputs), the reference at the coming ticks, or `reference` (outputs,),
    held constant ahead; `measured` (outputs,); all rad; optional `force` (places,), N, without which
    contact is never detected. Output: `stimulation` (muscles, 2).
    """

    def __post_init__(self) -> None:
        mpc_checks.check(self)

    @property
    def inputs(self) -> tuple[Port, ...]:
        """`reference_preview`, `reference`, `measured`, `force`."""
        outputs = self.model.outputs
        return (Port("reference_preview", (self.horizon, outputs), "rad", optional=True),
                Port("reference", (outputs,), "rad", optional=True), Port("measured", (outputs,), "rad"),
                Port("force", (len(self.places) or None,), "N", optional=True))

    def resolve(self, shapes: Mapping[str, tuple[int, ...]]) -> Mpc:
        """This block; raises InputError for force sensors whose places are not known."""
        require_count(self.places, shapes)
        return self

    def with_sensors(self, sources: Mapping[str, Sensors]) -> Mpc:
        """The block for the places of the wired force sensors."""
        return replace(self, places=wired_places(self.places, sources))

    @property
    def outputs(self) -> tuple[Port, ...]:
        """`stimulation`."""
        return (Port("stimulation", (self.model.inputs, 2), "A,s"),)

    def faults(self, context: Context, surroundings: Surroundings) -> tuple[InputError, ...]:
        """Faults of the parameters in this loop: its delay, its reference."""
        return tuple(mpc_checks.faults(self, context, surroundings))

    def cautions(self, context: Context) -> tuple[tuple[str, str], ...]:
        """Warnings (status, detail) that the parameters give."""
        return mpc_checks.cautions(self)

    def cautions_in_place(self, context: Context, surroundings: Surroundings) -> tuple[tuple[str, str], ...]:
        """Warnings (status, detail) about this loop: a delay that differs from the predicted one."""
        return mpc_checks.cautions_in_place(self, context, surroundings)

    def age_limits(self) -> tuple[AgeLimit, ...]:
        """Age limits of `measured` and `force`."""
        limits = {"measured": "nothing is controlled, and the drive falls to zero",
                  "force": "contact of the hand is never detected"}
        return tuple(AgeLimit(port=port, limit_ms=self.max_age_ms, since="newest", then=then)
                     for port, then in limits.items())

    def init(self, context: Context) -> MpcState:
        """State at rest, with the programme and the observer for the context's clock.

        Raises InputError for a horizon that ends before the first drive has an effect.
        """
        for fault in self.faults(context, Surroundings()):
            raise InputError(f"{context.name}.{fault.where}", fault.found, fault.allowed, fault.remedy)
        muscles, candidates = self.model.inputs, candidates_of(self, period_ns(context))
        ledger = np.zeros(self.horizon if self.horizon_charge_max_uc < math.inf else 0)
        reach = self.reach()
        course = Course(np.empty((0, self.model.outputs))) if self.memory else None
        return MpcState(reach, reach_of(self.model, reach), self.allocation().table(), candidates,
                        nominal(candidates), np.zeros(muscles), np.zeros((muscles, 2)), ledger, course=course)

    def next_trial(self, state: MpcState, context: Context) -> MpcState:
        """State at rest, with the learnt strengths of the muscles, or the disturbance to expect."""
        fresh = self.init(context)
        if self.memory is not None and state.course is not None:
            period = period_ns(context)
            model = self.model.sampled(period, duration_ns(self.actuation_delay_ms, NS_PER_MS,
                                                           "actuation_delay_ms"))
            fresh.course = self.memory.next_course(
                state.course, model, period, self.grasping_outputs,
                np.array(self.output_weight or (1.0,) * self.model.outputs))
        if self.adaptation:
            carry_over(self.adaptation, state.candidates, fresh.candidates)
            fresh.chosen = state.chosen
        return fresh

    def step(self, state: MpcState, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """Pulses for this tick."""
        reference, measured, now_ns = self._reference(inputs), inputs[2], tick.time_ns
        if state.course is not None and state.course.pending:
            for report in state.course.pending:
                tick.report(*report)
            state.course.pending = ()
        if inputs[3].present:
            self._update_contact(state, inputs[3], tick)
        if reference is None or measured.arrived_ns < 0:
            trouble, detail = "no_input", "no reference or measurement yet"
        elif now_ns - measured.newest_ns > self.max_age_ms * NS_PER_MS:
            trouble, detail = "stale_input", (
                f"the newest capture behind `measured` is {(now_ns - measured.newest_ns) / NS_PER_MS:.4g} ms "
                f"old, older than {self.max_age_ms:g} ms")
        else:
            trouble, detail = self._control(state, reference, measured, tick)
        if trouble:
            fall_back(self, state, tick, trouble, detail)
        if now_ns < self.begin_s * NS_PER_S:
            state.drive = np.zeros_like(state.drive)
        elif reference is not None:
            state.held.look(state.latch, tick, reference[0])
        if state.course is not None:
            controlled = reference is not None and now_ns >= self.begin_s * NS_PER_S
            wanted = cast(Array, reference)[0] if controlled else np.full(self.model.outputs, np.nan)
            state.course.note(tick.index, state.drive, wanted, measured.newest_ns,
                              cast(Array, measured.value), state.touch.holding)
        estimate = state.estimate
        state.pulses = np.empty((state.drive.size, 2))
        saturated = issue_drive(state.table, state.drive, estimate.stamps, estimate.inputs, now_ns,
                                state.pulses)
        if state.given_uc.size:
            state.given_uc = np.append(state.given_uc[1:], 1e6 * state.pulses[:, 0] @ state.pulses[:, 1])
        if saturated or state.latch.holding:
            state.latch.put(tick, "saturated", saturated > 0, "a channel is at its longest pulse")
        return (state.pulses,)

    def _reference(self, inputs: Sequence[Sample]) -> Array | None:
        """Reference over the horizon, (N, outputs); None before the first message."""
        preview, now, *_ = inputs
        if preview.arrived_ns >= 0:
            return cast(Array, preview.value)
        return np.tile(cast(Array, now.value), (self.horizon, 1)) if now.arrived_ns >= 0 else None

    def _update_contact(self, state: MpcState, force: Sample, tick: Tick) -> None:
        """Update whether the hand touches something; unchanged by forces that are not finite or too old."""
        sound = is_finite(force.value) and tick.time_ns - force.newest_ns <= self.max_age_ms * NS_PER_MS
        state.latch.put(tick, "no_force", not sound, "forces not finite or too old: contact as before")
        if sound:
            pressed_n, _ = contact_force(cast(Array, force.value), self.places, self.contact_places)
            self.contact.look(state.touch, pressed_n, tick.time_ns)
        state.latch.put(tick, "contact", state.touch.holding, "grasping channels follow the model alone")

    def _control(self, state: MpcState, reference: Array, sample: Sample, tick: Tick) -> tuple[str, str]:
        """Set the drive to the first optimal one; return (status, detail), ("", "") without trouble."""
        measured, target = cast(Array, sample.value), reference
        captured_ns = sample.newest_ns if self.compensate_age else tick.time_ns
        if state.course is not None:
            period = state.candidates[0].observer.period_ns
            measured = measured - state.course.expected_at(captured_ns, period)
            target = reference - state.course.expected_ahead(tick.index, self.horizon)
        if self.adaptation and is_finite(measured):
            state.chosen = compare(state.candidates, state.chosen, self.adaptation, captured_ns, measured,
                                   state.touch.holding)
        candidate = state.candidates[state.chosen]
        gain = candidate.observer.touching_gain if state.touch.holding else candidate.observer.gain
        now = Loop(candidate.estimate, state.drive, state.pulses)
        task = Task(measured, captured_ns, tick.time_ns, reference, target)
        problem = build_problem(self, state, now, gain, task)
        if problem.fault == NOT_FINITE:
            return "non_finite", "an input is not finite"
        if state.touch.holding and self.grasping_channels:
            result = solve_in_contact(self, state, now, problem, task)
        else:
            state.alone = None
            result = candidate.qp.solve_around(*problem)
        if result.status != "solved":
            return result.status, "quadratic programme: the last solution continues, then a ramp to zero"
        state.fallback.solved(result.x)
        state.drive = result.x[:state.drive.size]
        if candidate.strength:
            state.drive = np.minimum(state.drive / candidate.estimate.strength, state.reach)
        return "", ""
