"""Condition under which each learning law reduces the error of every trial, checked before the first one.

The conditions are those of monotone convergence without limits. Each is given as the growth of the error a
trial, for the nominal model, and as the margin: the greatest ratio of the plant's strength to the model's.

    phase_lead      max over frequency of |Q| s((1 - f) I - gain z^lead G K^+), s the greatest singular
                    value: frequency by frequency (Norrlof and Gunnarsson 2002, doi
                    10.1080/00207170210159122, theorem on the condition in the frequency domain)
    gradient        max |1 - f - step h|, h the strength of a pattern of drives over that of the strongest
    norm-optimal    max |1 - f - g / (g + rho)|, g the eigenvalues of G'WG

f is the forgetting. Patterns with less than `SEEN` of the strongest one's effect in the model are excluded:
no law learns what the outputs do not show. Limits inside the programme keep the nominal condition, as d = 0
is always admissible and so no optimum leaves a greater error.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from controllers.allocation import LEAST_REACH, check_reach, require_kept
from controllers.force_sensors import require_felt
from controllers.ilc.laws import Learning, low_pass, static_gain
from controllers.ilc.parameters import IlcParameters
from controllers.timing import DELAY_STATUS, delay_text, missed_ns
from controllers.trajectories import response, strongest
from fesloop.errors import InputError
from fesloop.loop.abilities import Surroundings
from fesloop.loop.clock import NS_PER_MS, NS_PER_S, duration_ns
from fesloop.models.linear_model import SampledModel

Array = NDArray[np.float64]
SEEN = 0.01
"""Singular value of G, over the greatest, below which a pattern of drives counts as invisible (chosen)."""
_PATTERNS = ("in the strongest pattern seen", "in the weakest pattern seen")
_FREQUENCIES = 400
_ROUNDING = 1e-9
SLACK = 0.01
"""Excess of growth over 1 that is accepted for part of a trial and weakly observable patterns (chosen)."""
_DENSE = 240
"""Largest number of drives for dense computation of a growth (chosen: some tenths of a second)."""
_KEPT = 4
"""Number of controllers whose condition is cached."""
_STRONGEST_PLANT = 1e3
"""Greatest margin that is reported."""


class Condition(NamedTuple):
    """Convergence of a law on its nominal model.

    Attributes
    ----------
    growth: greatest factor of the error from trial to trial; below 1 it shrinks in every trial.
    strength_margin: the growth stays at 1 or below for plants up to this many times as strong as the model.
    where: text that names the part of the error with this growth.
    """

    growth: float
    strength_margin: float
    where: str

    @property
    def holds(self) -> bool:
        """Whether the error never grows."""
        return self.growth <= 1.0 + _ROUNDING

    def cautions(self, law: str, strength_margin: float) -> tuple[tuple[str, str], ...]:
        """Warnings (status, detail) about a law that may diverge, or has less than the required margin."""
        if self.holds and self.strength_margin >= strength_margin:
            return ()
        grows = "" if self.holds else f"the error may grow {self.growth:.3g} times a trial {self.where}; "
        return (("low_margin" if self.holds else "may_diverge",
                 f"law {law}: {grows}convergence is certain only for a plant up to "
                 f"{self.strength_margin:.2f} times as strong as the model"),)


@lru_cache(maxsize=_KEPT)
def condition_of(ilc: IlcParameters, period_ns: int) -> Condition:
    """Condition of a controller at a period, cached because every run begins with it."""
    return condition(ilc.learning(period_ns), period_ns)


def condition(learning: Learning, period_ns: int) -> Condition:
    """Condition of a law at a period; for "newton", whose model changes, at its mean slopes."""
    kept = 1.0 - learning.forgetting
    if learning.law == "phase_lead":
        return _phase_lead(learning, 0.5 * NS_PER_S / period_ns)
    if learning.law == "gradient":
        growths = [abs(kept - learning.step * share) for share in (1.0, SEEN**2)]
        return Condition(max(growths), (1.0 + kept) / learning.step,
                         _PATTERNS[int(np.argmax(growths))])
    model = learning.model
    if learning.law == "newton":
        model = replace(model, b=model.b * np.minimum(learning.limits.reach, 1.0))
    greatest = strongest(model, learning.weights())
    growths = [abs(kept - g / (g + learning.change_weight)) for g in (greatest, SEEN**2 * greatest)]
    return Condition(max(growths), (1.0 + kept) * (1.0 + learning.change_weight / greatest),
                     _PATTERNS[int(np.argmax(growths))])


def _phase_lead(learning: Learning, nyquist_hz: float) -> Condition:
    """Condition at each frequency, on the outputs, or on the drives where these are fewer."""
    model, shares = learning.model, np.linspace(0.0, 1.0, _FREQUENCIES)
    inverse = learning.gain * np.linalg.pinv(static_gain(model))
    z = np.exp(1j * np.pi * shares)[:, None, None]
    plant = model.c @ np.linalg.solve(z * np.eye(model.a.shape[0]) - model.a, model.b)
    loop = z**learning.lead * (plant @ inverse if inverse.shape[0] >= inverse.shape[1] else inverse @ plant)
    low = np.ones(shares.size)
    if learning.cutoff > 0.0:
        from scipy.signal import sosfreqz  # 0.5 s to import

        low = np.abs(sosfreqz(low_pass(learning.cutoff), np.pi * shares)[1]) ** 2
    kept = (1.0 - learning.forgetting) * np.eye(loop.shape[1])

    def growth(strength: float) -> Array:
        each: Array = low * np.linalg.norm(kept - strength * loop, 2, axis=(1, 2))
        return each

    nominal = growth(1.0)
    worst = int(np.argmax(nominal))
    margin = _greatest_strength(lambda strength: float(growth(strength).max()))
    return Condition(float(nominal[worst]), margin, f"at {shares[worst] * nyquist_hz:.2f} Hz")


def _greatest_strength(growth: Callable[[float], float]) -> float:
    """Greatest strength whose growth is 1 or less; such strengths form an interval, as growth is convex."""
    low, high = 0.0, 1.0
    while growth(high) <= 1.0 + _ROUNDING:
        low, high = high, 2.0 * high
        if high > _STRONGEST_PLANT:
            return _STRONGEST_PLANT
    while high - low > 1e-2:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if growth(middle) <= 1.0 + _ROUNDING else (low, middle)
    return low


def growth_under(ilc: IlcParameters, period_ns: int, actuation_ns: int) -> float | None:
    """Growth (`growth_on`) for a plant that differs from the model in the actuation delay alone.

    It is computed for the first part of a trial; that of the whole is no less. None where that part is
    shorter than the delay.
    """
    learning = ilc.learning(period_ns)
    plant = ilc.model.sampled(period_ns, actuation_ns)
    samples = min(learning.samples, _DENSE // ilc.model.inputs)
    if 2 * plant.delay_steps >= samples:
        return None
    first = replace(learning, samples=samples, points=learning.points[:samples],
                    first=learning.first[:samples])
    return growth_on(first, plant)


def growth_on(learning: Learning, plant: SampledModel) -> float:
    """Greatest growth of the error a trial, in visible drives, of a linear law without limits on a plant.

    The 2-norm of Q ((1 - f) I - L G_plant) on the visible right singular vectors of the nominal G
    (Bristow et al. 2006, theorem 2). Dense: for some hundred drives.
    """
    samples, muscles = learning.samples, learning.model.b.shape[1]
    _, strength, seen = np.linalg.svd(learning.model.lifted(samples), full_matrices=False)
    seen = seen[strength >= SEEN * strength[0]]
    everywhere = np.ones((samples, learning.model.c.shape[0]), dtype=bool)
    left = []
    for pattern in seen.reshape(-1, samples, muscles):
        change = learning.change(response(plant, pattern), everywhere)
        left.append(learning.smoothed((1.0 - learning.forgetting) * pattern - change).ravel())
    return float(np.linalg.norm(seen @ np.array(left).T, 2))


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
    if ilc.stop_after < 0:
        raise InputError("stop_after", f"{ilc.stop_after}", "1 or more trials, or 0 for never")
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
    if duration_ns(ilc.begin_s, NS_PER_S, "begin_s") >= duration_ns(ilc.duration_s, NS_PER_S, "duration_s"):
        yield InputError("begin_s", f"{ilc.begin_s:g} s", f"less than duration_s, {ilc.duration_s:g} s")
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
    require_felt(ilc.places, ilc.contact_places)
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
        try:
            ilc.allocation(model)
        except InputError as fault:
            raise fault.within(f"bank[{i}]") from None
