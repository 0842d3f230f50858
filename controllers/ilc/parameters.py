"""Parameters of `Ilc`."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from controllers.ilc.laws import AllocatedCurves, LawName, Learning, Limits, SolverName
from controllers.ilc.points import Point, heeded
from controllers.ilc.trajectories import BankRule
from controllers.limits.allocation import Allocation, allocation_of
from fesloop.errors import InputError
from fesloop.loop.clock import NS_PER_MS, NS_PER_S, duration_ns
from fesloop.models.linear_model import LinearModel, SampledModel


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class IlcParameters:
    """Parameters of iterative learning control.

    Attributes
    ----------
    model: nominal plant; outputs rad, inputs the recruited fractions.
    bank: further models beside it; each trial is learnt from with what predicts it best (`ilc.bank`).
    bank_rule: "best" model or "mixture".
    current_ma: (muscles,), fixed current of each channel.
    duration_s: length of a trial; after it the last drive is held.
    law: see `ilc.laws`.
    output_weight: (outputs,), per rad^2; empty for 1 each.
    change_weight: rho, per unit of drive squared.
    points: instants and outputs that "point_to_point" heeds.
    forgetting: share of the drives, counted from the first, forgotten a trial; 0 to below 1.
    gradient_step: of "gradient"; its nominal condition is below 2.
    gain, lead_ms, cutoff_hz: of "phase_lead"; 0 Hz for no low-pass.
    slew: greatest change of a drive a tick.
    drive_max: greatest drive; less where a channel cannot reach it.
    trial_charge_max_uc: charge that each channel may give over a trial, one pulse a tick.
    width_max_us, charge_max_uc, full_scale_us: as in `Allocation`; the last where the model has no
        recruitment.
    first_drive: (muscles,), of the first trial, throughout; empty for zero.
    actuation_delay_ms: from this block to the plant, beyond the model's own delay.
    align_captures: compare reference and posture at the instants of capture, which takes the age of the
        samples out of the error; otherwise as they are read.
    max_gap_ms: longest distance of two captures between which posture is interpolated.
    sd_max_deg: a sample with a greater sd is doubtful and not learnt from (chosen: a fifth of a grasp).
    fingertips: number of forces that tell of contact.
    contact_n: force of any fingertip from which on a trial is in contact: what is grasped, not the drives,
        then sets the posture (chosen: ten times what sensors of fingertips scatter).
    grasping_outputs, grasping_channels: in contact these outputs are not learnt from and the drives of
        these channels stay those learnt in free motion, so that how hard the hand presses is how far beyond
        the object the reference goes; what else there is, such as a wrist, is learnt on. Empty: all.
    grasping_step: share of what is learnt in contact that counts, as no model knows a hand that holds
        something (chosen: half lets the hand be four times as quick to move as its model).
    reject_share: a trial with a greater share of doubtful samples is rejected (chosen).
    strength_margin: the law is told as doubtful if the plant may not be this many times as strong as model
        (chosen: what recruitment differs by from day to day).
    solver: of laws with limits inside: "osqp", or "daqp" (dense: for some hundred drives).
    """

    model: LinearModel
    current_ma: tuple[float, ...]
    duration_s: float
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
    fingertips: int = 5
    contact_n: float = 0.5
    grasping_outputs: tuple[int, ...] = ()
    grasping_channels: tuple[int, ...] = ()
    grasping_step: float = 0.5
    reject_share: float = 0.2
    strength_margin: float = 1.2
    solver: SolverName = "osqp"

    def allocation(self) -> Allocation:
        """How drives become pulses."""
        return allocation_of(self)

    def sampled(self, model: LinearModel, period: int) -> SampledModel:
        """A model at a period in ns, the actuation's delay included."""
        return model.sampled(period, duration_ns(self.actuation_delay_ms, NS_PER_MS, "actuation_delay_ms"))

    def learning(self, period: int, model: SampledModel | None = None) -> Learning:
        """The learning law at a period in ns, by the nominal model or another."""
        nyquist_hz = 0.5 * NS_PER_S / period
        if self.cutoff_hz >= nyquist_hz:
            raise InputError("cutoff_hz", f"{self.cutoff_hz}", f"below {nyquist_hz:g}, half the block's rate")
        muscles, outputs, allocation = self.model.inputs, self.model.outputs, self.allocation()
        samples = duration_ns(self.duration_s, NS_PER_S, "duration_s") // period + 1
        limits = Limits(reach=np.minimum(self.drive_max, allocation.reach()), slew=self.slew,
                        allocation=allocation, charge_c=1e-6 * self.trial_charge_max_uc)
        return Learning(
            law=self.law, model=model or self.sampled(self.model, period), samples=samples, limits=limits,
            first=limits.within(np.tile(np.array(self.first_drive or (0.0,) * muscles), (samples, 1))),
            output_weight=np.array(self.output_weight or (1.0,) * outputs),
            points=heeded(self.points, samples, outputs, period), curves=AllocatedCurves(allocation),
            change_weight=self.change_weight, forgetting=self.forgetting, step=self.gradient_step,
            gain=self.gain, lead=round(self.lead_ms * NS_PER_MS / period), cutoff=self.cutoff_hz / nyquist_hz,
            solver=self.solver)
