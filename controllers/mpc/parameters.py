"""Parameters of the block `mpc`."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from controllers.allocation import Allocation, allocation_of
from controllers.grip import Contact
from controllers.mpc.memory import Memory
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
    drive_max: greatest drive; lower where a channel cannot reach it.
    width_max_us, charge_max_uc, full_scale_us: as in `Allocation`; the last is used where the model has no
        recruitment.
    charge_rise_uc: greatest rise of a channel's charge per phase a tick, as in `Safety`, which then cuts
        nothing; without effect where the model has no recruitment.
    horizon_charge_max_uc: limit on the charge of any N successive ticks on all channels together, one pulse a
        tick. Future charge is linearised (`mpc.plan`), so the limit holds within some per cent of the charge
        of one tick.
    actuation_delay_ms: delay from this block to the plant, beyond the model's own.
    compensate_age: whether to predict across the age of a sample; otherwise a sample counts as captured when
        it is read.
    adaptation: adaptation of the muscles' strengths and the plant's speed, from trial to trial; None: none.
    memory: learning of what trials have in common beyond the model (`mpc.memory`); None: none.
    drive_noise, disturbance_deg, measurement_deg: sd of the drive's error, of the walk of the output
        disturbance over 1 s, and of a measurement, for the observer's gain.
    places: parts of the hand that the force sensors are on, such as "palm" and "F1d"; empty: as their block
        states. What touches other parts is not felt.
    contact_places: those of them whose force counts as contact; empty: all.
    contact: limits of the greatest force of a sensor that decide whether the hand touches something.
        `lost_ms` should be longer than samples are old, so that samples after it show free motion.
    grasping_outputs: outputs that an object blocks; empty: all.
    grasping_channels: channels that follow the model alone while the hand touches something; empty: none.
    touching_s: time constant with which the disturbances of the other outputs are followed while the hand
        touches something; the state then follows the drives alone (chosen: response time of a joint).
    begin_s: time in a trial before which it commands nothing: the hand is held in a pose, or relaxes after.
    max_age_ms: age beyond which a sample is not used.
    hold_ms, ramp_ms: time for which the drive is held, then ramped to zero, without a usable sample.
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
    memory: Memory | None = None
    drive_noise: float = 0.05
    disturbance_deg: float = 20.0
    measurement_deg: float = 0.5
    places: tuple[str, ...] = ()
    contact_places: tuple[str, ...] = ()
    contact: Contact = _CONTACT
    grasping_outputs: tuple[int, ...] = ()
    grasping_channels: tuple[int, ...] = ()
    touching_s: float = 0.3
    begin_s: float = 0.0
    max_age_ms: float = 400.0
    hold_ms: float = 100.0
    ramp_ms: float = 200.0
    solver: Literal["daqp", "osqp"] = "daqp"

    def allocation(self) -> Allocation:
        """Conversion of drives to pulses."""
        return allocation_of(self)

    def reach(self) -> Array:
        """Greatest drive of each muscle, (muscles,)."""
        return np.minimum(self.drive_max, self.allocation().reach())

    def boxes(self) -> tuple[Array, Array]:
        """Least and greatest outputs, (outputs,) rad each."""
        free = np.full(self.model.outputs, np.inf)
        return (np.radians(self.angle_min_deg) if self.angle_min_deg else -free,
                np.radians(self.angle_max_deg) if self.angle_max_deg else free)
