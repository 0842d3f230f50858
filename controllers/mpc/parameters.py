"""Parameters of `Mpc`."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from controllers.grip.contact import Contact
from controllers.limits.allocation import Allocation, allocation_of
from controllers.mpc.strength_adaptation import StrengthAdaptation
from fesloop.models.linear_model import LinearModel

Array = NDArray[np.float64]
_CONTACT = Contact(lasts_ms=0.0)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MpcParameters:
    """Parameters of model predictive control.

    Attributes
    ----------
    model: nominal plant; outputs rad, inputs the recruited fractions.
    current_ma: (muscles,), fixed current of each channel.
    horizon: periods N.
    output_weight: (outputs,), per rad^2; empty for 1 each.
    move_weight, effort_weight, cocontraction_weight: per unit of drive squared, as in `mpc.plan`.
    angle_min_deg, angle_max_deg: (outputs,), soft boxes of the outputs, as in `mpc.plan`; -inf and inf for
        none, empty for none at all.
    slew: greatest change of a drive a tick.
    drive_max: greatest drive; less where a channel cannot reach it.
    width_max_us, charge_max_uc, full_scale_us: as in `Allocation`; the last where the model has no
        recruitment.
    charge_rise_uc: greatest rise of a channel's charge per phase a tick, as of `Safety`, which then has
        nothing to cut; not kept where the model has no recruitment.
    horizon_charge_max_uc: what any N ticks on end may give on all channels together, one pulse a tick. What
        is to come is counted by slopes (`mpc.plan`), so it is kept within some per cent of one tick's charge.
    actuation_delay_ms: from this block to the plant, beyond the model's own delay.
    compensate_age: predict across the age of a sample; otherwise it counts as captured when it is read.
    adaptation: of the muscles' strengths and the plant's speed, from trial to trial; none if left out.
    drive_noise, disturbance_deg, measurement_deg: sd of the drive's error, of the walk of the output
        disturbance over 1 s, and of a measurement, for the observer's gain.
    fingertips: number of forces that tell of contact.
    contact: when the hand touches something: the force is that of any fingertip. `lost_ms` should be longer
        than samples are old: what they show then is free motion again.
    grasping_outputs: see above; empty: all.
    grasping_channels: see above; empty: none, what is seen of other outputs leads all.
    touching_s: while the hand touches something the disturbances of the other outputs are followed with this
        time constant, and the state by the drives alone (chosen: how long a joint takes to answer).
    max_age_ms, hold_ms, ramp_ms: see above.
    solver: "daqp" or "osqp".
    """

    model: LinearModel
    current_ma: tuple[float, ...]
    horizon: int = 20
    output_weight: tuple[float, ...] = ()
    move_weight: float = 0.01
    effort_weight: float = 0.0
    cocontraction_weight: float = 1e-5
    angle_min_deg: tuple[float, ...] = ()
    angle_max_deg: tuple[float, ...] = ()
    slew: float = 0.2
    drive_max: float = 1.0
    width_max_us: float = 500.0
    charge_max_uc: float = 20.0
    charge_rise_uc: float = 5.0
    horizon_charge_max_uc: float = math.inf
    full_scale_us: float = 500.0
    actuation_delay_ms: float = 0.0
    compensate_age: bool = True
    adaptation: StrengthAdaptation | None = None
    drive_noise: float = 0.05
    disturbance_deg: float = 20.0
    measurement_deg: float = 0.5
    fingertips: int = 5
    contact: Contact = _CONTACT
    grasping_outputs: tuple[int, ...] = ()
    grasping_channels: tuple[int, ...] = ()
    touching_s: float = 0.3
    max_age_ms: float = 400.0
    hold_ms: float = 100.0
    ramp_ms: float = 200.0
    solver: Literal["daqp", "osqp"] = "daqp"

    def allocation(self) -> Allocation:
        """How drives become pulses."""
        return allocation_of(self)

    def reach(self) -> Array:
        """Greatest drive of each muscle, (muscles,)."""
        return np.minimum(self.drive_max, self.allocation().reach())

    def boxes(self) -> tuple[Array, Array]:
        """Least and greatest outputs, (outputs,) rad each."""
        free = np.full(self.model.outputs, np.inf)
        return (np.radians(self.angle_min_deg) if self.angle_min_deg else -free,
                np.radians(self.angle_max_deg) if self.angle_max_deg else free)
