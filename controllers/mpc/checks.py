"""Checks of the parameters of `mpc`, alone and in their loop."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from controllers.allocation import LEAST_REACH, check_reach, posture_within, require_kept
from controllers.force_sensors import require_felt
from controllers.mpc.parameters import MpcParameters
from controllers.timing import DELAY_STATUS, delay_text, missed_ns, period_ns
from fesloop.errors import InputError
from fesloop.loop.abilities import Surroundings
from fesloop.loop.block import Context
from fesloop.loop.clock import NS_PER_MS, NS_PER_S, duration_ns

Array = NDArray[np.float64]
_POSITIVE = ("move_weight", "slew", "drive_max", "drive_noise", "disturbance_deg", "measurement_deg",
             "charge_rise_uc", "touching_s")
_ROUNDING_RAD = 1e-9
_LEAST_RISE = 1e-6
"""Rise of drive below the tolerance of the programme."""
_SLOWEST_PER_S = 1e-9
"""Rate of a pole below which its state is, but for rounding, an integral: no observer distinguishes it from a
disturbance of the output, and there is no steady state (chosen)."""
_MOST_UNKNOWNS = 2000
"""Largest number of unknowns of a programme, whose matrices are dense (chosen: some 30 MB each)."""
_LONGEST_S = 60
"""Longest delay, age of a sample, hold and ramp (chosen)."""


def check(mpc: MpcParameters) -> None:
    """Raise InputError for the first parameter that is not allowed."""
    sizes = f"the model has {mpc.model.inputs} muscles and {mpc.model.outputs} outputs"
    if len(mpc.current_ma) != mpc.model.inputs:
        raise InputError("current_ma", f"{len(mpc.current_ma)} currents",
                         f"{mpc.model.inputs}, one a muscle", sizes)
    for key, what in (("output_weight", "weights"), ("angle_min_deg", "angles"), ("angle_max_deg", "angles")):
        if getattr(mpc, key) and len(getattr(mpc, key)) != mpc.model.outputs:
            raise InputError(key, f"{len(getattr(mpc, key))} {what}",
                             f"{mpc.model.outputs}, one an output, or none", sizes)
    longest = _MOST_UNKNOWNS // max(mpc.model.inputs, mpc.model.outputs)
    if not 1 <= mpc.horizon <= longest:
        raise InputError("horizon", f"{mpc.horizon}", f"1 to {longest} periods", sizes)
    for key in _POSITIVE:
        if not (math.isfinite(getattr(mpc, key)) and getattr(mpc, key) > 0.0):
            raise InputError(key, f"{getattr(mpc, key)}", "a finite value above 0")
    for key, values in (("output_weight", mpc.output_weight), ("effort_weight", (mpc.effort_weight,)),
                        ("cocontraction_weight", (mpc.cocontraction_weight,))):
        if not all(math.isfinite(value) and value >= 0.0 for value in values):
            raise InputError(key, f"{values}", "finite weights, 0 or more")
    duration_ns(mpc.begin_s, NS_PER_S, "begin_s")
    if mpc.memory is not None and mpc.adaptation is not None:
        raise InputError("memory", "given beside adaptation, which explains the same errors by the muscles",
                         "one of both", "remove memory or adaptation")
    require_felt(mpc.places, mpc.contact_places)
    for key, size in (("grasping_outputs", mpc.model.outputs), ("grasping_channels", mpc.model.inputs)):
        if not set(getattr(mpc, key)) <= set(range(size)):
            raise InputError(key, f"{getattr(mpc, key)}", f"numbers from 0 to {size - 1}")
    if mpc.output_weight and not any(mpc.output_weight):
        raise InputError("output_weight", f"{mpc.output_weight}", "one above 0 at least")
    for key in ("actuation_delay_ms", "max_age_ms", "hold_ms", "ramp_ms"):
        if duration_ns(getattr(mpc, key), NS_PER_MS, key) > _LONGEST_S * NS_PER_S:
            raise InputError(key, f"{getattr(mpc, key):g}", f"at most {1000 * _LONGEST_S}")
    slowest = np.abs(np.linalg.eigvals(mpc.model.a)).min()
    if slowest < _SLOWEST_PER_S:
        raise InputError("model", f"a pole at {slowest:.3g} 1/s: it never comes to rest",
                         "no pole this near 0", "identify it again, or move the pole to the left")
    _check_limits(mpc)


def _check_limits(mpc: MpcParameters) -> None:
    """Raise InputError for limits that leave no stimulation to control with."""
    least, greatest = mpc.boxes()
    for output in range(mpc.model.outputs):
        if not least[output] <= greatest[output]:
            raise InputError("angle_min_deg", f"output {output} from {math.degrees(least[output]):g} to "
                             f"{math.degrees(greatest[output]):g} deg", "at most angle_max_deg",
                             "widen the box, or leave it out with -inf and inf")
    allocation = mpc.allocation()
    check_reach(mpc.drive_max, allocation)
    require_kept(mpc, allocation)
    if mpc.model.recruitment is None:
        if math.isfinite(mpc.horizon_charge_max_uc):
            raise InputError("horizon_charge_max_uc", f"{mpc.horizon_charge_max_uc:g}", "inf",
                             "the model has no recruitment, so that charge is not known")
        return
    threshold_uc = 1e6 * allocation.charge(np.full(allocation.channels, LEAST_REACH))
    risen = allocation.risen(1e-6 * mpc.charge_rise_uc)
    if (risen < _LEAST_RISE).any():
        muscle = int(np.argmin(risen))
        raise InputError(
            "charge_rise_uc", f"{mpc.charge_rise_uc:g} uC a tick never brings muscle {muscle} from rest "
            "across its threshold", f"up to {threshold_uc[muscle]:.3g} uC, which recruits {LEAST_REACH:g} "
            "of it at once", "raise charge_rise_uc")
    if mpc.solver == "osqp" and math.isfinite(mpc.horizon_charge_max_uc):
        raise InputError("solver", "'osqp' does not converge in time with a limit on charge", "daqp")
    if not mpc.horizon_charge_max_uc >= mpc.horizon * threshold_uc.min():
        raise InputError(
            "horizon_charge_max_uc", f"{mpc.horizon_charge_max_uc:g} uC over {mpc.horizon} pulses recruit "
            f"less than {LEAST_REACH:g} of any muscle", f"{mpc.horizon * threshold_uc.min():.3g} or more",
            "raise it, or shorten the horizon")


def faults(mpc: MpcParameters, context: Context, surroundings: Surroundings) -> Iterator[InputError]:
    """Faults in this loop: a horizon within the delay, a memory's cut-off from half the rate on, boxes
    without a posture or without the reference.
    """
    period = period_ns(context)
    own_ns = duration_ns(mpc.actuation_delay_ms, NS_PER_MS, "actuation_delay_ms")
    loop_ns, way = max((own_ns, "actuation_delay_ms"), (surroundings.loop_ns, surroundings.way))
    model_ns = mpc.model.delay_ns + (max(mpc.adaptation.delays_ns()) if mpc.adaptation else 0)
    delay_ns = model_ns + loop_ns
    if mpc.horizon * period <= delay_ns:
        yield InputError(
            "horizon", f"{mpc.horizon} periods of {period / NS_PER_MS:g} ms end before the delay of "
            f"{delay_ns / NS_PER_MS:g} ms does: {model_ns / NS_PER_MS:g} ms of the model, "
            f"{loop_ns / NS_PER_MS:g} ms of {way}",
            f"{delay_ns // period + 1} or more", "lengthen the horizon by the duration of the movement")
    if mpc.memory is not None and mpc.memory.cutoff_hz >= 0.5 * NS_PER_S / period:
        yield InputError("memory.cutoff_hz", f"{mpc.memory.cutoff_hz:g} Hz",
                         f"below {0.5 * NS_PER_S / period:g} Hz, half the block's rate")
    least, greatest = mpc.boxes()
    if posture_within(mpc.model, mpc.reach(), least, greatest) is None:
        yield InputError("angle_min_deg", f"{mpc.angle_min_deg} to {mpc.angle_max_deg} deg holds no posture "
                         "that the model can keep within its limits of stimulation", "boxes around one",
                         "widen the boxes, or raise drive_max, current_ma or width_max_us")
    for port in ("reference", "reference_preview"):
        if port in surroundings.coming:
            yield from _outside(surroundings.coming[port].reshape(-1, mpc.model.outputs), least, greatest)
            return


def _outside(reference: Array, least: Array, greatest: Array) -> Iterator[InputError]:
    """Faults of outputs whose reference leaves their box."""
    for output in range(least.size):
        low, high = reference[:, output].min(), reference[:, output].max()
        for key, broken, angle, end in (
                ("angle_min_deg", low < least[output] - _ROUNDING_RAD, low, least[output]),
                ("angle_max_deg", high > greatest[output] + _ROUNDING_RAD, high, greatest[output])):
            if broken:
                yield InputError(key, f"the box of output {output} ends at {math.degrees(end):g} deg, its "
                                 f"reference goes to {math.degrees(angle):.4g} deg",
                                 "boxes that hold the reference", "widen the box or change the reference")


def cautions_in_place(
    mpc: MpcParameters, context: Context, surroundings: Surroundings
) -> tuple[tuple[str, str], ...]:
    """Warning about a delay to the plant that differs from the predicted one."""
    own_ns = duration_ns(mpc.actuation_delay_ms, NS_PER_MS, "actuation_delay_ms")
    missed, period = missed_ns(own_ns, surroundings, period_ns(context)), period_ns(context)
    learnt = max(mpc.adaptation.delays_ns()) + period if mpc.adaptation else 0
    if not missed or 0.0 < missed <= learnt:
        return ()
    return ((DELAY_STATUS, delay_text(mpc.actuation_delay_ms, surroundings)),)


def cautions(mpc: MpcParameters) -> tuple[tuple[str, str], ...]:
    """Warning about a posture at rest outside the boxes."""
    least, greatest = mpc.boxes()
    outside = np.flatnonzero((mpc.model.offset < least) | (mpc.model.offset > greatest))
    if outside.size == 0:
        return ()
    where = ", ".join(f"output {i} at {math.degrees(mpc.model.offset[i]):.3g} deg" for i in outside)
    return (("rest_outside_limits", f"without stimulation the model rests outside its box: {where}"),)
