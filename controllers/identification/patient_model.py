"""A patient's model from the record of an identification experiment (`identification.excitation`)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from controllers.identification.dynamics import Dynamics, Method, identify_dynamics
from controllers.identification.recruitment import RecruitmentFit, fit_recruitment
from fesloop.errors import InputError
from fesloop.loop.clock import NS_PER_S
from fesloop.models.linear_model import LinearModel
from fesloop.models.recruitment import Recruitment

Array = NDArray[np.float64]
LEAST_MOVED = np.deg2rad(1.0)
"""Response of an angle, rad, from which on a channel counts as recruiting (chosen: above the scatter of a
tracker whose wearer rests)."""
AHEAD_S = 0.5
"""Of the prediction "half_second", as far as a predictive controller looks."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class IdentificationRecord:
    """What an identification experiment left, on the ticks of the stimulation.

    Attributes
    ----------
    period_s: of the ticks.
    stimulation: (n, channels, 2), A and s, held until the next tick.
    measured: (n, outputs), at the ticks, whenever it was received.
    phase: (n,), as of `Excitation`.
    outputs: names of what is measured.
    """

    period_s: float
    stimulation: Array
    measured: Array
    phase: Array
    outputs: tuple[str, ...]

    def __post_init__(self) -> None:
        used = self.phase >= 0.0
        if not np.isfinite(self.measured[used]).all():
            raise InputError("measured", "holds values that are not finite", "a number at every tick",
                             "identify from a tracker that sees what is measured")

    @property
    def channels(self) -> int:
        """Number of channels."""
        return int(self.stimulation.shape[1])


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Identified:
    """The model, and how it came about.

    Attributes
    ----------
    model: of recruitment, delay and dynamics.
    curves: one a channel.
    current_ma: (channels,).
    operating_drive, operating_outputs: mean of the binary part.
    fit: percent by kind of prediction and output, on what was held out: `fit_of`.
    held_out_s: how long that was.
    """

    model: LinearModel
    curves: tuple[RecruitmentFit, ...]
    current_ma: tuple[float, ...]
    operating_drive: Array
    operating_outputs: Array
    fit: dict[str, dict[str, float]]
    held_out_s: float


def identify(record: IdentificationRecord, *, method: Method = "subspace", held_out: float = 1.0 / 3.0,
             chronaxie_us: float = 200.0, least_moved: float = LEAST_MOVED) -> Identified:
    """The model of a record.

    Parameters
    ----------
    method: of `identify_dynamics`.
    held_out: share of the binary part, its end, that nothing is fitted to.
    chronaxie_us: taken as known; at a single current it cannot be told from the threshold.
    least_moved: response that counts as one, in the units of what is measured.

    Raises InputError for a channel that moves nothing, too short a record, or one without a stable model.
    """
    curves = tuple(_curve(record, channel, chronaxie_us, least_moved) for channel in range(record.channels))
    used = record.stimulation[record.phase >= 0.0, :, 0]
    current_ma = tuple(float(1e3 * each) for each in used.max(axis=0))
    recruitment = Recruitment(threshold_ma=tuple(curve.threshold_ma for curve in curves),
                              spread=tuple(curve.spread for curve in curves), chronaxie_us=chronaxie_us)
    binary = record.phase == record.channels
    if not 0.0 < held_out < 1.0 or binary.sum() < 2:
        raise InputError("held_out", f"{held_out:g} of {int(binary.sum())} samples",
                         "a share between 0 and 1, of a run that got to its binary part")
    drive = np.array([recruitment.fraction(pulses) for pulses in record.stimulation[binary]])
    measured = record.measured[binary]
    first = len(drive) - round(held_out * len(drive))
    dynamics = identify_dynamics(drive[:first], measured[:first], record.period_s, method=method)
    a, b = dynamics.continuous()
    return Identified(
        model=LinearModel(a=a, b=b, c=dynamics.c, offset=dynamics.offset, recruitment=recruitment,
                          delay_ns=round(dynamics.delay_s * NS_PER_S)),
        curves=curves, current_ma=current_ma, operating_drive=drive[:first].mean(axis=0),
        operating_outputs=measured[:first].mean(axis=0),
        fit=predictions(dynamics, drive, measured, first, record.outputs),
        held_out_s=(len(drive) - first) * record.period_s)


def _curve(record: IdentificationRecord, channel: int, chronaxie_us: float,
           least_moved: float) -> RecruitmentFit:
    rows = record.phase == channel
    if not rows.any():
        raise InputError(f"channel {channel}", "was not recruited by itself", "every channel",
                         "let the experiment run until its end")
    pulses = record.stimulation[rows, channel]
    try:
        return fit_recruitment(pulses[:, 1], float(1e3 * pulses[:, 0].max()), record.measured[rows],
                               record.period_s, chronaxie_us=chronaxie_us, least_moved=least_moved)
    except InputError as fault:
        raise InputError(f"channel {channel}: {fault.where}", fault.found, fault.allowed,
                         fault.remedy) from None


def predictions(dynamics: Dynamics, drive: Array, measured: Array, first: int,
                outputs: Sequence[str]) -> dict[str, dict[str, float]]:
    """Fit of three predictions of everything from sample `first` on, percent by output.

    "free_run" knows the drives alone; "half_second" and "one_step" know what was measured that long before
    and add by how much the free run missed it, which is what a controller does that estimates an output
    disturbance.
    """
    free = dynamics.response(drive)
    missed = measured - free
    found = {"free_run": free[first:]}
    for kind, steps in (("half_second", max(1, round(AHEAD_S / dynamics.period_s))), ("one_step", 1)):
        found[kind] = free[first:] + missed[first - steps:len(drive) - steps]
    return {kind: dict(zip(outputs, fit_of(measured[first:], predicted), strict=True))
            for kind, predicted in found.items()}


def fit_of(measured: Array, predicted: Array) -> list[float]:
    """100 (1 - |measured - predicted| / |measured - mean|) of each column."""
    error = np.linalg.norm(measured - predicted, axis=0)
    spread = np.linalg.norm(measured - measured.mean(axis=0), axis=0)
    return [float(value) for value in 100.0 * (1.0 - error / np.maximum(spread, 1e-300))]
