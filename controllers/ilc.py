"""Iterative learning control: a feedforward for a whole trial, improved from trial to trial."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal, cast

import numpy as np
from numpy.typing import NDArray

from controllers.alignment import posture_at
from controllers.allocation import Allocation, allocate
from controllers.ilc_laws import LawName, Learning
from controllers.period import period_ns
from fesloop.errors import InputError
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_MS, NS_PER_S, duration_ns
from fesloop.loop.guard import is_finite
from fesloop.loop.signals import NEVER, Port, Sample, Value
from fesloop.loop.status import StatusLatch
from fesloop.models.linear_model import LinearModel

Array = NDArray[np.float64]
Stamps = NDArray[np.int64]


@dataclass(slots=True, eq=False)
class IlcState:
    """The drives of this trial and what is seen of it.

    Attributes
    ----------
    drives: (samples, muscles).
    pulses: (samples, muscles, 2), what the drives become.
    ticks_ns: (samples,), when the block stepped; NEVER where it did not.
    captured_ns: (samples,), newest capture behind the sample read then; NEVER for none.
    measured, reference: (samples, outputs), rad.
    pending: status of the learning before this trial, told at its first tick.
    """

    drives: Array
    pulses: Array
    ticks_ns: Stamps
    captured_ns: Stamps
    measured: Array
    reference: Array
    pending: str = ""
    latch: StatusLatch = field(default_factory=StatusLatch)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Ilc:
    """Learns the drives of a trial from the errors of the trials before (laws: `ilc_laws`).

    During a trial it gives out the drives learnt so far, as pulse widths at fixed currents by the inverse of
    the model's recruitment, and keeps what is measured with its capture stamps. Between trials the law
    turns the error into new drives. Only what the trial covered is learnt from: its end, if it ended early
    or its last samples were still under way, and gaps in the measurement, count for nothing.

    Attributes
    ----------
    model: nominal plant; outputs rad, inputs the recruited fractions.
    current_ma: (muscles,), fixed current of each channel.
    duration_s: length of a trial; after it the last drive is held.
    law: see `ilc_laws`.
    output_weight: (outputs,), per rad^2; empty for 1 each.
    change_weight: rho, per unit of drive squared.
    gain, lead_ms, cutoff_hz: of "phase_lead"; 0 Hz for no low-pass.
    slew: greatest change of a drive a tick.
    drive_max: greatest drive; less where a channel cannot reach it.
    width_max_us, full_scale_us: as in `Allocation`; the latter where the model has no recruitment.
    first_drive: (muscles,), of the first trial, throughout; empty for zero.
    actuation_delay_ms: from this block to the plant, beyond the model's own delay.
    align_captures: compare reference and posture at the instants of capture, which takes the age of the
        samples out of the error; otherwise as they are read.
    max_gap_ms: longest distance of two captures between which posture is interpolated.
    solver: of "noilc_constrained": "osqp" or "daqp".

    Inputs: `reference` and `measured` (outputs,), rad. Output: `stimulation` (muscles, 2).
    """

    model: LinearModel
    current_ma: tuple[float, ...]
    duration_s: float
    law: LawName = "noilc_constrained"
    output_weight: tuple[float, ...] = ()
    change_weight: float = 0.01
    gain: float = 0.5
    lead_ms: float = 200.0
    cutoff_hz: float = 3.0
    slew: float = 0.1
    drive_max: float = 1.0
    width_max_us: float = 500.0
    full_scale_us: float = 500.0
    first_drive: tuple[float, ...] = ()
    actuation_delay_ms: float = 0.0
    align_captures: bool = True
    max_gap_ms: float = 150.0
    solver: Literal["daqp", "osqp"] = "osqp"

    def __post_init__(self) -> None:
        muscles, outputs = self.model.inputs, self.model.outputs
        if len(self.current_ma) != muscles:
            raise InputError("current_ma", f"{len(self.current_ma)} currents", f"{muscles}, one a muscle")
        for key, size in (("output_weight", outputs), ("first_drive", muscles)):
            values = getattr(self, key)
            if values and len(values) != size:
                raise InputError(key, f"{len(values)} values", f"{size}, or none")
            if not all(math.isfinite(value) and value >= 0.0 for value in values):
                raise InputError(key, f"{values}", "finite values, 0 or more")
        for key in ("duration_s", "change_weight", "gain", "slew", "drive_max"):
            if not (math.isfinite(getattr(self, key)) and getattr(self, key) > 0.0):
                raise InputError(key, f"{getattr(self, key)}", "a finite value above 0")
        for key in ("lead_ms", "actuation_delay_ms", "max_gap_ms"):
            duration_ns(getattr(self, key), NS_PER_MS, key)
        if not (math.isfinite(self.cutoff_hz) and self.cutoff_hz >= 0.0):
            raise InputError("cutoff_hz", f"{self.cutoff_hz}", "0 or more")
        self.allocation()

    @property
    def inputs(self) -> tuple[Port, ...]:
        """`reference`, `measured`."""
        outputs = self.model.outputs
        return Port("reference", (outputs,), "rad"), Port("measured", (outputs,), "rad")

    @property
    def outputs(self) -> tuple[Port, ...]:
        """`stimulation`."""
        return (Port("stimulation", (self.model.inputs, 2), "A,s"),)

    def allocation(self) -> Allocation:
        """How drives become pulses."""
        return Allocation(recruitment=self.model.recruitment, current_ma=self.current_ma,
                          width_max_us=self.width_max_us, full_scale_us=self.full_scale_us)

    def samples(self, period: int) -> int:
        """Ticks of a trial at a period in ns, both ends counted."""
        return duration_ns(self.duration_s, NS_PER_S, "duration_s") // period + 1

    def learning(self, period: int) -> Learning:
        """The learning law at a period in ns."""
        actuation = duration_ns(self.actuation_delay_ms, NS_PER_MS, "actuation_delay_ms")
        nyquist_hz = 0.5 * NS_PER_S / period
        if self.cutoff_hz >= nyquist_hz:
            raise InputError("cutoff_hz", f"{self.cutoff_hz}", f"below {nyquist_hz:g}, half the block's rate")
        return Learning(
            law=self.law, model=self.model.sampled(period, actuation), samples=self.samples(period),
            reach=np.minimum(self.drive_max, self.allocation().reach()), slew=self.slew,
            output_weight=np.array(self.output_weight or (1.0,) * self.model.outputs),
            change_weight=self.change_weight, gain=self.gain,
            lead=round(self.lead_ms * NS_PER_MS / period), cutoff=self.cutoff_hz / nyquist_hz,
            solver=self.solver)

    def convergence_factor(self, period: int, plant: LinearModel | None = None) -> float:
        """Greatest growth of a trial's error at a period in ns (`Learning.convergence_factor`)."""
        actuation = duration_ns(self.actuation_delay_ms, NS_PER_MS, "actuation_delay_ms")
        actual = None if plant is None else plant.sampled(period, actuation)
        return self.learning(period).convergence_factor(actual)

    def init(self, context: Context) -> IlcState:
        """The first trial."""
        learning = self.learning(period_ns(context))
        drives = np.tile(np.array(self.first_drive or (0.0,) * self.model.inputs), (learning.samples, 1))
        return self._trial(learning.within_limits(drives), "")

    def next_trial(self, state: IlcState, context: Context) -> IlcState:
        """The next trial, with what the last one taught."""
        period = period_ns(context)
        stepped = state.ticks_ns >= 0
        if self.align_captures:
            gap_ns = max(duration_ns(self.max_gap_ms, NS_PER_MS, "max_gap_ms"), 2 * period)
            posture, covered = posture_at(state.ticks_ns, state.captured_ns, state.measured, gap_ns)
        else:
            posture, covered = state.measured, state.captured_ns >= 0
        drives, status = self.learning(period).learn(
            state.drives, state.reference - posture, covered & stepped)
        return self._trial(drives, status)

    def _trial(self, drives: Array, status: str) -> IlcState:
        """A trial about to begin."""
        samples, muscles = drives.shape
        pulses = np.empty((samples, muscles, 2))
        table = self.allocation().table()
        for k in range(samples):
            allocate(table, drives[k], pulses[k])
        return IlcState(
            drives, pulses, np.full(samples, NEVER, dtype=np.int64), np.full(samples, NEVER, dtype=np.int64),
            np.zeros((samples, self.model.outputs)), np.zeros((samples, self.model.outputs)), status)

    def step(self, state: IlcState, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """Pulses for this tick; what is read is kept."""
        reference, measured = inputs
        if state.pending:
            tick.report(state.pending, "nothing was learnt from the last trial: its drives are used again")
            state.pending = ""
        k, last = tick.index, state.drives.shape[0] - 1
        state.latch.put(tick, "past_end", k > last, "the trial is longer than duration_s: last drive held")
        if k > last:
            return (state.pulses[last].copy(),)
        usable = reference.arrived_ns >= 0 and is_finite(reference.value)
        state.latch.put(tick, "no_reference", not usable, "no finite reference: this tick is not learnt from")
        if usable:
            state.ticks_ns[k] = tick.time_ns
            state.reference[k] = cast(Array, reference.value)
        finite = is_finite(measured.value)
        state.latch.put(tick, "non_finite", not finite, "a measurement is not finite: left out of learning")
        if finite and measured.arrived_ns >= 0:
            state.captured_ns[k] = measured.newest_ns
            state.measured[k] = cast(Array, measured.value)
        return (state.pulses[k].copy(),)
