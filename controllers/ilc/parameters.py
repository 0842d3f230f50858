"""Parameters of the block `ilc`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from controllers.allocation import Allocation, allocation_of
from controllers.ilc.laws import AllocatedCurves, LawName, Learning, Limits, SolverName, pulses_of
from controllers.trajectories import BankRule
from fesloop.errors import InputError
from fesloop.loop.clock import NS_PER_MS, NS_PER_S, duration_ns
from fesloop.models.linear_model import LinearModel, SampledModel

Mask = NDArray[np.bool_]


@dataclass(frozen=True, slots=True, kw_only=True)
class Point:
    """Instant at which the outputs shall reach the reference.

    Attributes
    ----------
    at_s: time since the start of the trial.
    outputs: numbers of the outputs that count then, from 0; empty for all.
    """

    at_s: float
    outputs: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        if not (math.isfinite(self.at_s) and self.at_s >= 0.0):
            raise InputError("points.at_s", f"{self.at_s}", "0 or more seconds")


def point_mask(points: Sequence[Point], samples: int, outputs: int, period_ns: int) -> Mask:
    """Mask (samples, outputs): true at the tick nearest to each point; everywhere without points.

    Raises InputError for a point after the trial and for an output that does not exist.
    """
    if not points:
        return np.ones((samples, outputs), dtype=bool)
    mask = np.zeros((samples, outputs), dtype=bool)
    for i, point in enumerate(points):
        tick = round(point.at_s * NS_PER_S / period_ns)
        if tick >= samples:
            raise InputError(f"points[{i}].at_s", f"{point.at_s:g} s",
                             f"at most {(samples - 1) * period_ns / NS_PER_S:g} s, the end of the trial")
        if not all(0 <= output < outputs for output in point.outputs):
            raise InputError(f"points[{i}].outputs", f"{list(point.outputs)}", f"0 to {outputs - 1}")
        mask[tick, list(point.outputs) or slice(None)] = True
    return mask


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class IlcParameters:
    """Parameters of iterative learning control.

    Attributes
    ----------
    model: nominal plant; outputs rad, inputs the recruited fractions.
    bank: further models; the law of each trial uses those that predict it best
        (`trajectories.shares_of`).
    bank_rule: "best" model or "mixture".
    current_ma: (muscles,), fixed current of each channel.
    duration_s: length of a trial; after it the last drive is held.
    begin_s: time in a trial before which nothing is learnt and no drive is changed: the hand is held in a
        pose, or relaxes after it.
    law: learning law (`ilc.laws`).
    output_weight: (outputs,), per rad^2; empty for 1 each.
    change_weight: rho, per unit of drive squared.
    points: instants and outputs that count for "point_to_point".
    forgetting: share of the drives, counted from the first, forgotten a trial; 0 to below 1.
    gradient_step: step of "gradient"; its nominal condition is below 2.
    gain, lead_ms, cutoff_hz: gain, lead and low-pass cut-off of "phase_lead"; 0 Hz for no low-pass.
    slew: greatest change of a drive a tick.
    drive_max: greatest drive; lower where a channel cannot reach it.
    trial_charge_max_uc: limit on the charge of each channel over a trial, one pulse a tick.
    width_max_us, charge_max_uc, full_scale_us: as in `Allocation`; the last is used where the model has no
        recruitment.
    first_drive: (muscles,), constant drive of the first trial; empty for zero.
    actuation_delay_ms: delay from this block to the plant, beyond the model's own.
    align_captures: whether to compare reference and posture at the instants of capture, which removes the age
        of the samples from the error; otherwise samples are compared when they are read.
    max_gap_ms: longest distance of two captures between which posture is interpolated.
    sd_max_deg: sd above which a sample is doubtful and excluded from learning (chosen: a fifth of a grasp).
    places: parts of the hand that the force sensors are on, such as "palm" and "F1d"; empty: as their block
        states. What touches other parts is not felt.
    contact_places: those of them whose force counts as contact; empty: all.
    contact_n: force of any sensor from which a trial is in contact: the object, not the drives, then
        determines the posture (chosen: ten times the scatter of thin resistive sensors).
    grasping_outputs, grasping_channels: outputs that are excluded from learning in contact, and channels that
        then keep the drives learnt in free motion: grip force follows from how far the reference lies inside
        the object. Others, such as the wrist's, continue to learn. Empty: all.
    grasping_step: factor on what is learnt in contact, since no model describes a hand that holds an object
        (chosen: 0.5 tolerates a plant gain four times that of the model).
    reject_share: share of doubtful samples above which a trial is rejected (chosen).
    stop_after: number of successive worse trials after which learning stops, and the drives of the best trial
        are used; 0: never. A trial is worse with half as much error again as the best one and more than the
        last one, or with twice the best one's (chosen: more than stimulated muscle mostly varies by).
    strength_margin: ratio of the plant's strength to the model's up to which the law should converge; a law
        with a smaller margin is reported (chosen: variation of recruitment from day to day).
    solver: solver of laws with limits inside: "osqp", or "daqp" (dense: for some hundred drives).
    """

    model: LinearModel
    current_ma: tuple[float, ...]
    duration_s: float
    begin_s: float = 0.0
    law: LawName = "noilc_constrained"
    bank: tuple[LinearModel, ...] = ()
    bank_rule: BankRule = "best"
    output_weight: tuple[float, ...] = ()
    change_weight: float = 0.01
    points: tuple[Point, ...] = ()
    forgetting: float = 0.0
    gradient_step: float = 1.0
    gain: float = 0.5
    lead_ms: float = 200.0
    cutoff_hz: float = 3.0
    slew: float = 0.1
    drive_max: float = 1.0
    trial_charge_max_uc: float = math.inf
    width_max_us: float = 500.0
    charge_max_uc: float = 20.0
    full_scale_us: float = 500.0
    first_drive: tuple[float, ...] = ()
    actuation_delay_ms: float = 0.0
    align_captures: bool = True
    max_gap_ms: float = 150.0
    sd_max_deg: float = 15.0
    places: tuple[str, ...] = ()
    contact_places: tuple[str, ...] = ()
    contact_n: float = 0.5
    grasping_outputs: tuple[int, ...] = ()
    grasping_channels: tuple[int, ...] = ()
    grasping_step: float = 0.5
    reject_share: float = 0.2
    stop_after: int = 2
    strength_margin: float = 1.2
    solver: SolverName = "osqp"

    def allocation(self, model: LinearModel | None = None) -> Allocation:
        """Conversion of drives to pulses, by the recruitment of the nominal model or another."""
        nominal = allocation_of(self)
        return replace(nominal, recruitment=model.recruitment) if model else nominal

    def sampled(self, model: LinearModel, period: int) -> SampledModel:
        """A model at a period in ns, with the actuation delay."""
        return model.sampled(period, duration_ns(self.actuation_delay_ms, NS_PER_MS, "actuation_delay_ms"))

    def begins(self, period: int) -> int:
        """First sample that counts at a period in ns."""
        return -(-duration_ns(self.begin_s, NS_PER_S, "begin_s") // period)

    def learning(self, period: int, model: SampledModel | None = None, known: LinearModel | None = None
                 ) -> Learning:
        """The learning law at a period in ns, with the nominal model or another.

        `model` is for drives by the recruitment of `known`; both are the nominal model if not given.
        """
        nyquist_hz = 0.5 * NS_PER_S / period
        if self.cutoff_hz >= nyquist_hz:
            raise InputError("cutoff_hz", f"{self.cutoff_hz}", f"below {nyquist_hz:g}, half the block's rate")
        muscles, outputs, allocation = self.model.inputs, self.model.outputs, self.allocation(known)
        samples = duration_ns(self.duration_s, NS_PER_S, "duration_s") // period + 1
        first = np.outer(np.arange(samples) >= self.begins(period), self.first_drive or (0.0,) * muscles)
        if known is not None and known is not self.model:
            first = allocation.drives(pulses_of(self.allocation(), first))
        limits = Limits(reach=np.minimum(self.drive_max, allocation.reach()), slew=self.slew,
                        allocation=allocation, charge_c=1e-6 * self.trial_charge_max_uc)
        return Learning(
            law=self.law, model=model or self.sampled(self.model, period), samples=samples, limits=limits,
            first=limits.within(first),
            output_weight=np.array(self.output_weight or (1.0,) * outputs),
            points=point_mask(self.points, samples, outputs, period), curves=AllocatedCurves(allocation),
            change_weight=self.change_weight, forgetting=self.forgetting, step=self.gradient_step,
            gain=self.gain, lead=round(self.lead_ms * NS_PER_MS / period), cutoff=self.cutoff_hz / nyquist_hz,
            solver=self.solver)
