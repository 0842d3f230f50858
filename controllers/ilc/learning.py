"""From the parameters of iterative learning control to its law at the block's period."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from controllers.ilc.laws import Learning
from controllers.ilc.limits import Limits
from controllers.ilc.newton import AllocatedCurves
from controllers.ilc.points import heeded
from fesloop.errors import InputError
from fesloop.loop.clock import NS_PER_MS, NS_PER_S, duration_ns
from fesloop.models.linear_model import SampledModel

if TYPE_CHECKING:
    from controllers.ilc.block import Ilc


def learning_of(ilc: Ilc, period: int, model: SampledModel | None = None) -> Learning:
    """The learning law at a period in ns, by the nominal model or another."""
    nyquist_hz = 0.5 * NS_PER_S / period
    if ilc.cutoff_hz >= nyquist_hz:
        raise InputError("cutoff_hz", f"{ilc.cutoff_hz}", f"below {nyquist_hz:g}, half the block's rate")
    muscles, outputs, allocation = ilc.model.inputs, ilc.model.outputs, ilc.allocation()
    samples = duration_ns(ilc.duration_s, NS_PER_S, "duration_s") // period + 1
    limits = Limits(reach=np.minimum(ilc.drive_max, allocation.reach()), slew=ilc.slew,
                    allocation=allocation, charge_c=1e-6 * ilc.trial_charge_max_uc)
    return Learning(
        law=ilc.law, model=model or ilc.sampled(ilc.model, period), samples=samples, limits=limits,
        first=limits.within(np.tile(np.array(ilc.first_drive or (0.0,) * muscles), (samples, 1))),
        output_weight=np.array(ilc.output_weight or (1.0,) * outputs),
        points=heeded(ilc.points, samples, outputs, period), curves=AllocatedCurves(allocation),
        change_weight=ilc.change_weight, forgetting=ilc.forgetting, step=ilc.gradient_step,
        gain=ilc.gain, lead=round(ilc.lead_ms * NS_PER_MS / period), cutoff=ilc.cutoff_hz / nyquist_hz,
        solver=ilc.solver)
