"""`ilc`: a feedforward for a whole trial, improved from trial to trial."""

from __future__ import annotations

import copy
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import cast

import numpy as np
from numpy.typing import NDArray

from controllers.force_sensors import contact_force, require_count, wired_places
from controllers.ilc.convergence import Condition, cautions_in_place, check, condition_of, faults
from controllers.ilc.laws import pulses_of
from controllers.ilc.parameters import IlcParameters
from controllers.progress import Progress, Report
from controllers.reach import Reach, reach_of
from controllers.timing import period_ns
from controllers.trajectories import SeenTrial, explained, mixed, rescaled
from fesloop.errors import InputError
from fesloop.loop.abilities import Passage, Surroundings
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_MS, NS_PER_S, duration_ns
from fesloop.loop.record import StatusLatch
from fesloop.loop.signals import Port, Sample, Sensors, Value, is_finite
from fesloop.models.linear_model import LinearModel, SampledModel

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
_CURVE = 21
"""Number of drives from 0 to the greatest at which recruitment curves of two models are compared (chosen)."""


def note(seen: SeenTrial, latch: StatusLatch, k: int, inputs: Sequence[Sample], sd_max_deg: float,
         tick: Tick) -> None:
    """Record the measurement of tick k, and report doubtful parts of it.

    `inputs`: `measured` and `measured_sd` (outputs,), rad, and `trusted`.
    """
    sample, spread, trusted = inputs
    measured, sd = cast(Array, sample.value), cast(Array, spread.value)
    broken = ~np.isfinite(measured)
    vague = ~(sd <= math.radians(sd_max_deg))
    latch.put(tick, "non_finite", bool(broken.any()), "a measurement is not finite: excluded from learning")
    latch.put(tick, "uncertain", bool(vague.any()),
              f"a measurement's sd is above {sd_max_deg:g} deg: excluded from learning")
    distrusted = not cast(float, trusted.value) >= 0.5
    latch.put(tick, "untrusted", distrusted, "marked as not trusted: excluded from learning")
    seen.note(k, sample.newest_ns, measured, broken | vague | distrusted)


@dataclass(slots=True, eq=False)
class IlcState:
    """Drives of this trial and its measurements.

    Attributes
    ----------
    drives: (samples, muscles), by the recruitment curves of the model that the law learnt by, which may be
        another one of the bank in each trial; once learning has stopped, of the nominal model.
    pulses: (samples, muscles, 2), what is issued.
    held: angles that drives can hold.
    progress: errors of the trials before.
    pending: statuses of the learning before this trial, reported at its first tick.
    """

    drives: Array
    pulses: Array
    seen: SeenTrial
    held: Reach
    progress: Progress
    pending: tuple[Report, ...] = ()
    latch: StatusLatch = field(default_factory=StatusLatch)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Ilc(IlcParameters):
    """Learns the drives of a trial from the errors of the trials before (laws: `ilc.laws`).

    During a trial it issues the drives learnt so far, as pulse widths at fixed currents by the inverse of the
    model's recruitment, and records the measurements with their capture stamps. Between trials the law
    computes new drives from the error. Only instants with a measurement count: not the end of a trial that
    ended early or whose last samples had not arrived, and not gaps. A trial with too many doubtful samples
    is rejected, and its drives are used again. Learning that makes trials worse stops, and the drives of the
    best trial are used from then on (`stop_after`). A law whose condition of convergence fails, or holds with
    a small margin, is reported at the first tick.

    Parameters are those of `IlcParameters`.

    Inputs: `reference` and `measured` (outputs,), rad; optional `measured_sd` (outputs,), rad, `force`
    (places,), N, and `trusted`, below 0.5 where a sample is excluded from learning. Output: `stimulation`
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
                Port("force", (len(self.places) or None,), "N", optional=True))

    def resolve(self, shapes: Mapping[str, tuple[int, ...]]) -> Ilc:
        """This block; raises InputError for force sensors whose places are not known."""
        require_count(self.places, shapes)
        return self

    def with_sensors(self, sources: Mapping[str, Sensors]) -> Ilc:
        """The block for the places of the wired force sensors."""
        return replace(self, places=wired_places(self.places, sources))

    @property
    def outputs(self) -> tuple[Port, ...]:
        """`stimulation`."""
        return (Port("stimulation", (self.model.inputs, 2), "A,s"),)

    def passages(self, context: Context) -> tuple[Passage, ...]:
        """No input has an effect within the trial: drives are fixed before it begins."""
        return (Passage(inputs=tuple(port.name for port in self.inputs), later="in the next trial"),)

    def condition(self, context: Context) -> Condition:
        """Condition of convergence of the law on its nominal model, and its margin."""
        return condition_of(self, period_ns(context))

    def faults(self, context: Context, surroundings: Surroundings) -> tuple[InputError, ...]:
        """Faults of the parameters in this loop: its delay."""
        return tuple(faults(self, surroundings))

    def cautions(self, context: Context) -> tuple[Report, ...]:
        """Warnings (status, detail) that the parameters give."""
        return self.condition(context).cautions(self.law, self.strength_margin)

    def cautions_in_place(self, context: Context, surroundings: Surroundings) -> tuple[Report, ...]:
        """Warnings (status, detail) about this loop: delays that the law does not include."""
        return cautions_in_place(self, period_ns(context), surroundings)

    def init(self, context: Context) -> IlcState:
        """State of the first trial."""
        first = self.learning(period_ns(context)).first
        return self._trial(first, pulses_of(self.allocation(), first), Progress(), self.cautions(context))

    def next_trial(self, state: IlcState, context: Context) -> IlcState:
        """State of the next trial, with the drives that the law learns from the last one."""
        period, share = period_ns(context), state.seen.doubtful_share()
        progress = copy.deepcopy(state.progress)
        if progress.stopped and progress.best is not None:
            return self._trial(self.allocation().drives(progress.best), progress.best, progress)
        if share > self.reject_share:
            return self._trial(state.drives, state.pulses, progress, ((
                "trial_rejected", f"{100.0 * share:.0f} % of the measurements are doubtful, more than "
                f"{100.0 * self.reject_share:g} %: the drives are used again"),))
        gap_ns = max(duration_ns(self.max_gap_ms, NS_PER_MS, "max_gap_ms"), 2 * period)
        posture, covered = state.seen.posture(self.align_captures, gap_ns)
        begun = np.arange(covered.shape[0])[:, None] >= self.begins(period)
        covered &= begun & ~state.seen.touching(self.grasping_outputs, self.model.outputs)
        kept = ~begun | state.seen.touching(self.grasping_channels, self.model.inputs)
        known, model, last, reports = self.model, None, state.drives, list[Report]()
        if self.bank and not covered.any():
            return self._trial(state.drives, state.pulses, progress)
        if self.bank:
            known, model, last, report = self._chosen(state, posture, covered, period)
            reports.append(report)
        learning, errors = self.learning(period, model, known), state.seen.reference - posture
        # By other curves the drives of the last trial may rise faster than those they were learnt as.
        rise = float(np.abs(np.diff(last, axis=0, prepend=0.0)).max()) if self.bank else 0.0
        learning = replace(learning, limits=replace(learning.limits, slew=max(self.slew, rise)))
        heed = covered * learning.weights()
        if heed.any():
            error = math.sqrt(float(np.sum(heed * errors ** 2) / np.sum(heed)))
            reports += progress.note(error, state.pulses, self.stop_after, "the drives")
            if progress.stopped and progress.best is not None:
                best = self.allocation().drives(progress.best)
                return self._trial(best, progress.best, progress, tuple(reports))
        drives, status = learning.learn(last, errors, covered, kept)
        part = np.where(state.seen.touching((), self.model.inputs), self.grasping_step, 1.0)
        drives = learning.limits.within(last + part * (drives - last))
        if status:
            reports.append((status, "nothing was learnt from the last trial: its drives are used again"))
        return self._trial(drives, pulses_of(self.allocation(known), drives), progress, tuple(reports))

    def _chosen(self, state: IlcState, posture: Array, covered: Mask, period: int
                ) -> tuple[LinearModel, SampledModel, Array, Report]:
        """The model of the bank that explains a trial best, the law's model, drives of the trial, a report.

        Each model predicts the trial by its own recruitment of the trial's pulses: persons differ in
        thresholds. The law's model is for drives by the curves of the first model returned, as are the
        drives (samples, muscles). Further models of a mixture are brought to these curves by the ratio of
        the recruited fractions, over the trial and some pulses up to the longest.
        """
        known = (self.model, *self.bank)
        allocations = [self.allocation(each) for each in known]
        models = [self.sampled(each, period) for each in known]
        recruited = [each.drives(state.pulses) for each in allocations]
        shares, report = explained(models, recruited, posture, covered, self.bank_rule)
        lead = int(np.argmax(shares))
        reach = np.minimum(self.drive_max, allocations[lead].reach())
        rising = np.where(np.isfinite(reach), reach, 1.0) * np.linspace(0.0, 1.0, _CURVE)[:, None]
        pulses = np.concatenate([state.pulses, pulses_of(allocations[lead], rising)])
        common = allocations[lead].drives(pulses)
        same = [rescaled(model, each.drives(pulses), common) if share > 0.0 else model
                for model, each, share in zip(models, allocations, shares, strict=True)]
        return known[lead], mixed(same, shares), recruited[lead], report

    def _trial(self, drives: Array, pulses: Array, progress: Progress, reports: tuple[Report, ...] = ()
               ) -> IlcState:
        """State at the start of a trial with the given drives and their pulses."""
        seen = SeenTrial.empty(drives.shape[0], self.model.outputs)
        held = reach_of(self.model, np.minimum(self.drive_max, self.allocation().reach()))
        return IlcState(drives, pulses, seen, held, progress, reports)

    def step(self, state: IlcState, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """Pulses for this tick; records the inputs."""
        for report in state.pending:
            tick.report(*report)
        state.pending = ()
        k, last = tick.index, state.drives.shape[0] - 1
        state.latch.put(tick, "past_end", k > last, "the trial is longer than duration_s: last drive held")
        if k > last:
            return (state.pulses[last].copy(),)
        reference = inputs[0]
        usable = reference.arrived_ns >= 0 and is_finite(reference.value)
        state.latch.put(tick, "no_reference", not usable, "no finite reference: this tick does not count")
        if usable:
            state.seen.ticks_ns[k] = tick.time_ns
            state.seen.reference[k] = cast(Array, reference.value)
            if tick.time_ns >= self.begin_s * NS_PER_S:
                state.held.look(state.latch, tick, state.seen.reference[k])
        if inputs[1].arrived_ns >= 0:
            note(state.seen, state.latch, k, inputs[1:4], self.sd_max_deg, tick)
        if state.seen.free and inputs[4].present:
            pressed_n, place = contact_force(cast(Array, inputs[4].value), self.places, self.contact_places)
            if pressed_n > self.contact_n:
                state.seen.touch(k)
                tick.report("contact", f"more than {self.contact_n:g} N on {place}: from here on grasping "
                            "outputs are excluded from learning")
        return (state.pulses[k].copy(),)
