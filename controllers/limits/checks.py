"""Whether limits of stimulation leave anything to control with."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from controllers.limits.allocation import LEAST_REACH, Allocation
from fesloop.errors import InputError
from fesloop.models.linear_model import LinearModel

Array = NDArray[np.float64]


def check_reach(drive_max: float, allocation: Allocation) -> None:
    """Raise InputError for a greatest drive below what every channel must recruit (see `Allocation`)."""
    if drive_max < LEAST_REACH and allocation.recruitment is not None:
        raise InputError("drive_max", f"{drive_max:g}", f"{LEAST_REACH:g} or more",
                         "raise it, or leave the channel out of the model")


def require_kept(controller: Any, allocation: Allocation) -> None:
    """Raise InputError for limits of pulses that are given and cannot be kept, as nothing is recruited.

    Where a model has no recruitment, pulses are signed and unlimited (see `Allocation`).
    """
    if allocation.recruitment is not None:
        return
    for each in fields(controller):
        if each.name in ("width_max_us", "charge_max_uc") and getattr(controller, each.name) != each.default:
            raise InputError(each.name, f"{getattr(controller, each.name):g} would not be kept: the model "
                             "has no recruitment, and pulses are signed and unlimited", "no such limit",
                             "leave it out, and limit stimulation in the safety block")


def posture_within(model: LinearModel, reach: Array, least: Array, greatest: Array) -> Array | None:
    """Steady drives (muscles,) that keep the outputs between two postures (outputs,) rad; None if none do.

    Drives are between 0 and `reach` (muscles,). Where the model has no steady state, or no end is finite,
    there is nothing to refuse: zeros.
    """
    bounded = np.concatenate([np.isfinite(greatest), np.isfinite(least)])
    if not bounded.any() or np.linalg.matrix_rank(model.a) < model.a.shape[0]:
        return np.zeros(reach.size)
    from scipy.optimize import linprog  # 0.1 s to import

    gain = -model.c @ np.linalg.solve(model.a, model.b)
    ends = np.concatenate([greatest - model.offset, model.offset - least])
    found = linprog(np.ones(reach.size), np.vstack([gain, -gain])[bounded], ends[bounded],
                    bounds=[(0.0, float(most)) for most in reach])
    return np.asarray(found.x) if found.status == 0 else None
