"""Iterative learning control: a feedforward for a whole trial, improved from trial to trial."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import cast

import numpy as np
from numpy.typing import NDArray

from controllers.ilc.checks import cautions_in_place, check, faults
from controllers.ilc.convergence import Condition, condition_of
from controllers.ilc.laws import pulses_of
from controllers.ilc.parameters import IlcParameters
from controllers.ilc.trajectories import explained
from controllers.ilc.trial import SeenTrial
from controllers.period import period_ns
from fesloop.errors import InputError
from fesloop.loop.abilities import Passage, Surroundings
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_MS, duration_ns
from fesloop.loop.guard import is_finite
from fesloop.loop.record import StatusLatch
from fesloop.loop.signals import Port, Sample, Value

Array = NDArray[np.float64]


def note(seen: SeenTrial, latch: StatusLatch, k: int, inputs: Sequence[Sample], sd_max_deg: float,
         tick: Tick) -> None:
    """Keep the measurement of tick k, and tell what of it is doubtful.

    `inputs`: `measured` and `measured_sd` (outputs,), rad, and `trusted`.
    """
    sample, spread, trusted = inputs
    measured, sd = cast(Array, sample.value), cast(Array, spread.value)
    broken = ~np.isfinite(measured)
    vague = ~(sd <= math.radians(sd_max_deg))
    latch.put(tick, "non_finite", bool(broken.any()), "a measurement is not finite: left out of learning")
    latch.put(tick, "uncertain", bool(vague.any()),
              f"a measurement's sd is above {sd_max_deg:g} deg: left out of learning")
    distrusted = not cast(float, trusted.value) >= 0.5
    latch.put(tick, "untrusted", distrusted, "said not to be trusted: left out of learning")
    seen.note(k, sample.newest_ns, measured, broken | vague | distrusted)


Report = tuple[str, str]


@dataclass(slots=True, eq=False)
class IlcState:
    """The drives of this trial and what is seen of it.

    Attributes
    ----------
    drives, pulses: (samples, muscles), and (samples, muscles, 2), what they become.
    pending: statuses of the learning before this trial, told at its first tick.
    """

    drives: Array
    pulses: Array
    seen: SeenTrial
    pending: tuple[Report, ...] = ()
    latch: StatusLatch = field(default_factory=StatusLatch)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Ilc(IlcParameters):
    """Learns the drives of a trial from the errors of the trials before (laws: `ilc.laws`).

    During a trial it gives out the drives learnt so far, as pulse widths at fixed currents by the inverse of
    the model's recruitment, and keeps what is measured with its capture stamps. Between trials the law
    turns the error into new drives. Only what the trial covered is learnt from: its end, if it ended early
    or its last samples were still under way, and gaps in the measurement, count for nothing. A trial of
    which too much is doubtful is rejected: its drives are used again. A law whose condition of convergence
    fails, or holds with a small margin, is told at the first tick.

    Parameters are those of `IlcParameters`.

    Inputs: `reference` and `measured` (outputs,), rad; optional `measured_sd` (outputs,), rad, `force`
    (fingertips,), N, and `trusted`, below 0.5 where a sample is not to be learnt from. Output: `stimulation`
    (muscles, 2).
    """

    def __post_init__(self) -> None:
        check(self)

    @property
    def inputs(self) -> tuple[Port, ...]:
        """`reference`, `measured`, `measured_sd`, `trusted`, `force`."""
        outputs = self.model.outputs
        return (Port("reference", (outputs,), "rad"), Port("measured", (outputs,), "rad"),
                Port("measured_sd", (outputs,), "rad", optional=True),
                Port("trusted", initial=1.0, optional=True),
                Port("force", (self.fingertips,), "N", optional=True))

    @property
    def outputs(self) -> tuple[Port, ...]:
        """`stimulation`."""
        return (Port("stimulation", (self.model.inputs, 2), "A,s"),)

    def passages(self, context: Context) -> tuple[Passage, ...]:
        """What is read is learnt from; the drives of a trial stand before it begins."""
        return (Passage(inputs=tuple(port.name for port in self.inputs), later="in the next trial"),)


    def condition(self, context: Context) -> Condition:
        """Whether the law converges on its nominal model, and with what margin."""
        return condition_of(self, period_ns(context))

    def faults(self, context: Context, surroundings: Surroundings) -> tuple[InputError, ...]:
        """What of the parameters does not fit the loop around: its delay."""
        return tuple(faults(self, surroundings))

    def cautions(self, context: Context) -> tuple[Report, ...]:
        """What is to be feared before the first trial: (status, detail) each."""
        return self.condition(context).cautions(self.law, self.strength_margin)

    def cautions_in_place(self, context: Context, surroundings: Surroundings) -> tuple[Report, ...]:
        """What is to be feared of the loop around: delays that the law does not reckon with."""
        return cautions_in_place(self, period_ns(context), surroundings)

    def init(self, context: Context) -> IlcState:
        """The first trial."""
        return self._trial(self.learning(period_ns(context)).first, self.cautions(context))

    def next_trial(self, state: IlcState, context: Context) -> IlcState:
        """The next trial, with what the last one taught."""
        period, share = period_ns(context), state.seen.doubtful_share()
        if share > self.reject_share:
            return self._trial(state.drives, ((
                "trial_rejected", f"{100.0 * share:.0f} % of what was measured is doubtful, more than "
                f"{100.0 * self.reject_share:g} %: the drives are used again"),))
        gap_ns = max(duration_ns(self.max_gap_ms, NS_PER_MS, "max_gap_ms"), 2 * period)
        posture, covered = state.seen.posture(self.align_captures, gap_ns)
        covered &= ~state.seen.touching(self.grasping_outputs, self.model.outputs)
        kept = state.seen.touching(self.grasping_channels, self.model.inputs)
        model, reports = None, []
        if self.bank and covered.any():
            models = [self.sampled(each, period) for each in (self.model, *self.bank)]
            model, report = explained(models, state.drives, posture, covered, self.bank_rule)
            reports.append(report)
        learning = self.learning(period, model)
        drives, status = learning.learn(state.drives, state.seen.reference - posture, covered, kept)
        part = np.where(state.seen.touching((), self.model.inputs), self.grasping_step, 1.0)
        drives = learning.limits.within(state.drives + part * (drives - state.drives))
        if status:
            reports.append((status, "nothing was learnt from the last trial: its drives are used again"))
        return self._trial(drives, tuple(reports))

    def _trial(self, drives: Array, reports: tuple[Report, ...]) -> IlcState:
        """A trial about to begin."""
        seen = SeenTrial.empty(drives.shape[0], self.model.outputs)
        return IlcState(drives, pulses_of(self.allocation(), drives), seen, reports)

    def step(self, state: IlcState, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """Pulses for this tick; what is read is kept."""
        for report in state.pending:
            tick.report(*report)
        state.pending = ()
        k, last = tick.index, state.drives.shape[0] - 1
        state.latch.put(tick, "past_end", k > last, "the trial is longer than duration_s: last drive held")
        if k > last:
            return (state.pulses[last].copy(),)
        reference = inputs[0]
        usable = reference.arrived_ns >= 0 and is_finite(reference.value)
        state.latch.put(tick, "no_reference", not usable, "no finite reference: this tick is not learnt from")
        if usable:
            state.seen.ticks_ns[k] = tick.time_ns
            state.seen.reference[k] = cast(Array, reference.value)
        if inputs[1].arrived_ns >= 0:
            note(state.seen, state.latch, k, inputs[1:4], self.sd_max_deg, tick)
        if state.seen.free and (cast(Array, inputs[4].value) > self.contact_n).any():
            state.seen.touch(k)
            tick.report("contact", f"a fingertip presses by more than {self.contact_n:g} N: from here on "
                        "what grasps is not learnt")
        return (state.pulses[k].copy(),)
