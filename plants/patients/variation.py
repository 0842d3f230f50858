"""From a preset to one of its kind, and from a patient to one of their days."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr, ndtri

from fesloop.hand.movements import MUSCLES
from fesloop.loop.noise import NoiseStream, stream_key
from plants.patients.limits import LIMITS, Limits
from plants.patients.sections import (
    Anthropometry,
    Fatigue,
    Placement,
    Recruitment,
    Spasticity,
    Strength,
    Tremor,
    Voluntary,
)
from plants.patients.spreads import CohortSpread, DaySpread

if TYPE_CHECKING:
    from plants.patients.patient import Patient

MOST_SD = 2.5
"""No draw is further from the middle (chosen: the most unusual of a hundred)."""
_NEW_SEEDS = 2**53


@dataclass(frozen=True, slots=True)
class Draws:
    """Numbers drawn for one member or one day, each from a stream of its own name.

    So members, days and quantities do not depend on each other, nor on how many there are.
    """

    seed: int
    name: str
    number: int

    def uniform(self, quantity: str, width: int = 1) -> NDArray[np.float64]:
        """(width,), in [0, 1)."""
        return NoiseStream(stream_key(self.seed, f"{self.name}/{quantity}", self.number), width,
                           "uniform").row(0)

    def near(self, quantity: str, middle: float, sd: float, limits: Limits) -> float:
        """A normal number around `middle`, within `MOST_SD` and the limits."""
        return _truncated(float(self.uniform(quantity)[0]), middle, sd, limits)

    def scaled(self, quantity: str, middle: float, sd: float, limits: Limits) -> float:
        """A lognormal number of median `middle`, `sd` of its logarithm, within `MOST_SD` and the limits."""
        return _scaled(float(self.uniform(quantity)[0]), middle, sd, limits)

    def of_muscles(self, quantity: str, middles: dict[str, float], sd: float, limits: Limits,
                   ) -> dict[str, float]:
        """Lognormal factors of all muscles, of medians `middles` (where not named, 1)."""
        if sd == 0.0:
            return middles
        shares = self.uniform(quantity, len(MUSCLES))
        return {name: _scaled(float(share), middles.get(name, 1.0), sd, limits)
                for name, share in zip(MUSCLES, shares, strict=True)}

    def new_seed(self, quantity: str) -> int:
        """A seed that nobody else has."""
        return stream_key(self.seed, f"{self.name}/{quantity}", self.number) % _NEW_SEEDS


def _truncated(share: float, middle: float, sd: float, limits: Limits) -> float:
    """Quantile `share` of the normal distribution around `middle`, cut off."""
    if sd == 0.0:
        return middle
    low, high = (min(max((limit - middle) / sd, -MOST_SD), MOST_SD) for limit in limits)
    below, above = float(ndtr(low)), float(ndtr(high))
    drawn = middle + sd * float(ndtri(below + share * (above - below)))
    return min(max(drawn, limits[0]), limits[1])


def _scaled(share: float, middle: float, sd: float, limits: Limits) -> float:
    if sd == 0.0 or middle == 0.0:
        return middle
    low, high = (math.log(max(limit, 1e-300) / middle) for limit in limits)
    return min(max(middle * math.exp(_truncated(share, 0.0, sd, (low, high))), limits[0]), limits[1])


FARTHEST = 0.1
"""Share of the forearm's length by which drawn arrays are off at most (chosen: they stay on the forearm)."""


def member_of(patient: Patient, spread: CohortSpread, cohort: int, number: int) -> Patient:
    """Another patient of the same kind."""
    draws = Draws(cohort, f"patient/{patient.name}", number)
    muscle, passive, limits = patient.muscle, patient.passive, LIMITS["muscle"]
    muscle = replace(
        muscle, delay_ms=draws.near("delay", muscle.delay_ms, spread.delay_ms, limits["delay_ms"]),
        natural_rad_s=draws.scaled("natural", muscle.natural_rad_s, spread.natural, limits["natural_rad_s"]))
    passive = replace(passive, mcp_n_m_per_rad=draws.scaled(
        "mcp", passive.mcp_n_m_per_rad, spread.mcp, LIMITS["passive"]["mcp_n_m_per_rad"]))
    return replace(
        patient, anthropometry=_measures(patient.anthropometry, spread, draws),
        strength=_strength(patient.strength, spread, draws),
        recruitment=_recruitment(patient.recruitment, spread, draws), muscle=muscle, passive=passive,
        fatigue=_fatigue(patient.fatigue, spread.endurance, draws),
        voluntary=_voluntary(patient.voluntary, spread, draws),
        spasticity=_spasticity(patient.spasticity, spread.spasticity, draws),
        tremor=_tremor(patient.tremor, spread, draws))


def _measures(person: Anthropometry, spread: CohortSpread, draws: Draws) -> Anthropometry:
    limits = LIMITS["anthropometry"]
    return replace(
        person, hand_mm=draws.near("hand", person.hand_mm, spread.hand_mm, limits["hand_mm"]),
        forearm_radius_mm=draws.near("forearm radius", person.forearm_radius_mm, spread.forearm_radius_mm,
                                     limits["forearm_radius_mm"]))


def _strength(strength: Strength, spread: CohortSpread, draws: Draws) -> Strength:
    limits = LIMITS["strength"]
    denervated = {name: draws.near(f"denervated {name}", share, spread.denervated, limits["denervated"])
                  if 0.0 < share < 1.0 else share for name, share in strength.denervated.items()}
    return Strength(
        overall=draws.scaled("strength", strength.overall, spread.strength, limits["overall"]),
        muscles=draws.of_muscles("muscle strength", strength.muscles, spread.muscle_strength,
                                 limits["muscles"]),
        denervated=denervated)


def _recruitment(recruitment: Recruitment, spread: CohortSpread, draws: Draws) -> Recruitment:
    limits = LIMITS["recruitment"]
    return replace(
        recruitment, axon_seed=draws.new_seed("axons"),
        threshold=draws.scaled("threshold", recruitment.threshold, spread.threshold, limits["threshold"]),
        thresholds=draws.of_muscles("muscle threshold", recruitment.thresholds, spread.muscle_threshold,
                                    limits["thresholds"]))


def _voluntary(voluntary: Voluntary, spread: CohortSpread, draws: Draws) -> Voluntary:
    """Efforts of another patient; what cannot be moved at will stays so."""
    def drawn(name: str, effort: float) -> float:
        return draws.near(name, effort, spread.voluntary, LIMITS["voluntary"]["limit"]) if effort else 0.0

    return Voluntary(limit=drawn("voluntary", voluntary.limit), muscles={
        name: drawn(f"voluntary {name}", effort) for name, effort in voluntary.muscles.items()})


def _spasticity(spasticity: Spasticity | None, sd: float, draws: Draws) -> Spasticity | None:
    if spasticity is None:
        return None
    return replace(spasticity, gain_s=draws.scaled(
        "spasticity", spasticity.gain_s, sd, LIMITS["spasticity"]["gain_s"]))


def _tremor(tremor: Tremor | None, spread: CohortSpread, draws: Draws) -> Tremor | None:
    if tremor is None:
        return None
    return replace(tremor, frequency_hz=draws.near(
        "tremor", tremor.frequency_hz, spread.tremor_hz, LIMITS["tremor"]["frequency_hz"]))


def _fatigue(fatigue: Fatigue | None, sd: float, draws: Draws) -> Fatigue | None:
    if fatigue is None:
        return None
    return replace(fatigue, endurance=draws.scaled(
        "endurance", fatigue.endurance, sd, LIMITS["fatigue"]["endurance"]))


def on_day_of(patient: Patient, spread: DaySpread, number: int) -> Patient:
    """The patient on a day of that number."""
    draws = Draws(0, f"patient/{patient.name}/day", number)
    strength, recruitment, muscle = patient.strength, patient.recruitment, patient.muscle
    return replace(
        patient, placement=_placement(patient, spread, draws),
        strength=replace(strength, overall=draws.scaled(
            "strength", strength.overall, spread.strength, LIMITS["strength"]["overall"])),
        recruitment=replace(recruitment, threshold=draws.scaled(
            "threshold", recruitment.threshold, spread.threshold, LIMITS["recruitment"]["threshold"])),
        muscle=replace(muscle, delay_ms=draws.near(
            "delay", muscle.delay_ms, spread.delay_ms, LIMITS["muscle"]["delay_ms"])),
        fatigue=_fatigue(patient.fatigue, spread.endurance, draws),
        spasticity=_spasticity(patient.spasticity, spread.spasticity, draws))


def _placement(patient: Patient, spread: DaySpread, draws: Draws) -> Placement:
    """Where the arrays lie on that day, and the skin under them."""
    place, limits = patient.placement, LIMITS["placement"]
    farthest = max(FARTHEST * 1e3 * patient.anthropometry.size.forearm, abs(place.along_mm))
    return Placement(
        along_mm=draws.near("along", place.along_mm, spread.along_mm,
                            (max(-farthest, limits["along_mm"][0]), min(farthest, limits["along_mm"][1]))),
        around_deg=draws.near("around", place.around_deg, spread.around_deg, limits["around_deg"]),
        skin=draws.scaled("skin", place.skin, spread.skin, limits["skin"]),
        element_sd=max(place.element_sd, spread.element), skin_seed=draws.new_seed("skin"))
