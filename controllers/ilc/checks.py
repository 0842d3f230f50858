"""Checks of the parameters of `ilc`, alone and in their loop."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from controllers.ilc.convergence import SLACK, growth_under
from controllers.ilc.parameters import IlcParameters
from controllers.limits.allocation import LEAST_REACH, check_reach, require_kept
from controllers.timing import DELAY_STATUS, delay_text, missed_ns
from fesloop.errors import InputError
from fesloop.loop.abilities import Surroundings
from fesloop.loop.clock import NS_PER_MS, NS_PER_S, duration_ns

_POSITIVE = ("duration_s", "change_weight", "gain", "gradient_step", "slew", "drive_max", "sd_max_deg",
             "strength_margin", "contact_n")


def check(ilc: IlcParameters) -> None:
    """Raise InputError for the first parameter that is not allowed."""
    _check_sizes(ilc)
    for key in _POSITIVE:
        if not (math.isfinite(getattr(ilc, key)) and getattr(ilc, key) > 0.0):
            raise InputError(key, f"{getattr(ilc, key)}", "a finite value above 0")
    if not ilc.trial_charge_max_uc > 0.0:
        raise InputError("trial_charge_max_uc", f"{ilc.trial_charge_max_uc}", "above 0; inf for no limit")
    if not 0.0 <= ilc.forgetting < 1.0:
        raise InputError("forgetting", f"{ilc.forgetting}", "0 or more, below 1")
    if not 0.0 < ilc.grasping_step <= 1.0:
        raise InputError("grasping_step", f"{ilc.grasping_step}", "above 0, at most 1")
    if not 0.0 <= ilc.reject_share <= 1.0:
        raise InputError("reject_share", f"{ilc.reject_share}", "0 to 1")
    for key in ("lead_ms", "actuation_delay_ms", "max_gap_ms"):
        duration_ns(getattr(ilc, key), NS_PER_MS, key)
    if not (math.isfinite(ilc.cutoff_hz) and ilc.cutoff_hz >= 0.0):
        raise InputError("cutoff_hz", f"{ilc.cutoff_hz}", "0 or more")
    if (ilc.law == "point_to_point") != bool(ilc.points):
        raise InputError("points", f"{len(ilc.points)} points with law {ilc.law!r}",
                         'points with law "point_to_point", and with no other')
    _check_limits(ilc)


def _check_limits(ilc: IlcParameters) -> None:
    """Raise InputError for limits that leave no drive to learn."""
    allocation = ilc.allocation()
    check_reach(ilc.drive_max, allocation)
    require_kept(ilc, allocation)
    reach = np.minimum(ilc.drive_max, allocation.reach())
    beyond = np.flatnonzero(np.array(ilc.first_drive or (0.0,) * reach.size) > reach)
    if beyond.size:
        muscle = int(beyond[0])
        raise InputError("first_drive", f"{ilc.first_drive[muscle]:g} of muscle {muscle}",
                         f"up to {reach[muscle]:.3g}, which its channel can recruit",
                         "lower it, or raise drive_max, current_ma, width_max_us or charge_max_uc")
    if ilc.model.recruitment is None:
        return
    threshold_uc = 1e6 * allocation.charge(np.full(reach.size, LEAST_REACH))
    if not ilc.trial_charge_max_uc >= threshold_uc.max():
        muscle = int(threshold_uc.argmax())
        raise InputError("trial_charge_max_uc", f"{ilc.trial_charge_max_uc:g} uC",
                         f"{threshold_uc[muscle]:.3g} or more, one pulse that recruits {LEAST_REACH:g} of "
                         f"muscle {muscle}", "raise it to the charge of a trial")


def faults(ilc: IlcParameters, surroundings: Surroundings) -> Iterator[InputError]:
    """Faults in this loop: a trial that ends before the delay of model and loop, points within the delay."""
    own_ns = ilc.model.delay_ns + duration_ns(ilc.actuation_delay_ms, NS_PER_MS, "actuation_delay_ms")
    delay_ns = max(own_ns, ilc.model.delay_ns + surroundings.loop_ns)
    of = f"the delay of {delay_ns / NS_PER_MS:g} ms of model and loop"
    if duration_ns(ilc.duration_s, NS_PER_S, "duration_s") <= delay_ns:
        yield InputError("duration_s", f"{ilc.duration_s:g} s end before {of} does",
                         f"above {delay_ns / NS_PER_S:g} s", "lengthen the trial")
    for i, point in enumerate(ilc.points):
        if point.at_s * NS_PER_S <= own_ns:
            yield InputError(f"points[{i}].at_s", f"{point.at_s:g} s is before the effect of any drive",
                             f"above {own_ns / NS_PER_S:g} s", "set the point later")


def cautions_in_place(
    ilc: IlcParameters, period_ns: int, surroundings: Surroundings
) -> tuple[tuple[str, str], ...]:
    """Warnings about delays that the law does not include, and whether it converges under them.

    They are the delay to the plant, and the age of samples where captures are not aligned, which delays the
    effect of a drive in the measurements.
    """
    if surroundings.actuation_ns is None:
        return ()
    own_ns = duration_ns(ilc.actuation_delay_ms, NS_PER_MS, "actuation_delay_ms")
    late_ns = missed_ns(own_ns, surroundings, period_ns)
    told = [delay_text(ilc.actuation_delay_ms, surroundings)] if late_ns else []
    age_ns = 0.0 if ilc.align_captures else surroundings.age_ns.get("measured", 0.0)
    if age_ns > period_ns:
        late_ns += age_ns
        told.append(f"samples are {age_ns / NS_PER_MS:.4g} ms old on average, and align_captures = false "
                    "treats them as present")
    if not told:
        return ()
    growth = growth_under(ilc, period_ns, own_ns + round(late_ns))
    if growth is not None and growth > 1.0 + SLACK:
        told.append(f"law {ilc.law} may diverge: the error may grow {growth:.3g} times a trial")
    return ((DELAY_STATUS, "; ".join(told)),)


def _check_sizes(ilc: IlcParameters) -> None:
    """Raise InputError unless currents, weights and further models have the sizes of the model."""
    muscles, outputs = ilc.model.inputs, ilc.model.outputs
    for key, size in (("grasping_outputs", outputs), ("grasping_channels", muscles)):
        if not set(getattr(ilc, key)) <= set(range(size)):
            raise InputError(key, f"{getattr(ilc, key)}", f"numbers from 0 to {size - 1}")
    if ilc.fingertips < 1:
        raise InputError("fingertips", f"{ilc.fingertips}", "1 or more")
    if len(ilc.current_ma) != muscles:
        raise InputError("current_ma", f"{len(ilc.current_ma)} currents", f"{muscles}, one a muscle")
    for key, size in (("output_weight", outputs), ("first_drive", muscles)):
        values = getattr(ilc, key)
        if values and len(values) != size:
            raise InputError(key, f"{len(values)} values", f"{size}, or none")
        if not all(math.isfinite(value) and value >= 0.0 for value in values):
            raise InputError(key, f"{values}", "finite values, 0 or more")
    for i, model in enumerate(ilc.bank):
        if (model.inputs, model.outputs) != (muscles, outputs):
            raise InputError(f"bank[{i}]", f"{model.inputs} inputs and {model.outputs} outputs",
                             f"{muscles} and {outputs}, as in model")
