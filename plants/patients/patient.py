"""Virtual patients: parameters of the blocks between stimulator and skeleton, random members and days."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr, ndtri

from fesloop.errors import InputError, InputErrors
from fesloop.forms.schema import plain
from fesloop.hand.anthropometry import (
    BONES,
    FINGERS,
    JOINTED,
    SHIFT_MM,
    TILT_DEG,
    WIDTH_RATIO,
    HandSize,
)
from fesloop.hand.movements import EXTRINSIC, FREEDOMS, MUSCLES
from fesloop.hand.skeleton import RESTING_DEG, hand_tree
from fesloop.loop.noise import NoiseStream, stream_key
from fesloop.models.electrode_arrays import DORSAL, MOST_ELEMENTS
from plants.electrodes.axons import MOTOR_POINTS, AxonScatter, MotorPoint
from plants.muscles.ding import Ding2003, Ding2003Fatigue
from plants.muscles.lags import Hammerstein
from plants.muscles.variation import Variation
from plants.patients.sections import (
    LIMITS,
    Anatomy,
    Anthropometry,
    Calibration,
    CohortSpread,
    DaySpread,
    Fatigue,
    Limits,
    MuscleDynamics,
    Passive,
    Placement,
    Recruitment,
    SensorPlacement,
    Spasticity,
    Strength,
    Tolerance,
    Tremor,
    Triple,
    Voluntary,
    triples,
)

ADULT_FOREARM_MM = 260.0
"""Length of the forearm to which motor points and arrays apply, elbow to wrist (chosen, as in
`electrodes`)."""
HEALTHY_MCP, JOINT_SHARE = 0.04, 0.03
"""Stiffness of a finger's MCP joint, N m/rad, and the part of the joint itself; the rest is that of its
tendons (`plants.hand.model`)."""
LEAST_DEPTH_MM = 4.0
"""Least depth of a motor point under the skin (chosen)."""
RANGES_DEG = dict(zip(FREEDOMS, np.degrees(hand_tree(HandSize()).ranges).tolist(), strict=True))
"""Ranges of the hand's freedoms."""
LEAST_STRENGTH = 1e-4
"""Strength of a muscle without nerve (chosen: negligible, but not 0, by which MuJoCo would divide)."""


def hand(patient: Patient) -> dict[str, Any]:
    """Parameters of `hand` and, without the measures of the hand, of `myohand`."""
    strength, passive = patient.strength, patient.passive
    factors = tuple(
        max(strength.overall * strength.muscles.get(name, 1.0) * (1.0 - strength.denervated.get(name, 0.0)),
            LEAST_STRENGTH) for name in MUSCLES)
    tendons = HEALTHY_MCP - JOINT_SHARE
    return {"hand": patient.hand_size, "strength": factors, "stiffness": passive.stiffness,
            "damping": passive.damping, "passive_tension": passive.tension,
            "contracture": (passive.mcp_n_m_per_rad - tendons) / JOINT_SHARE,
            "rest_deg": dict(passive.rest_deg)}


def muscles(patient: Patient, model: str = "") -> dict[str, Any]:
    """Parameters of `muscles`; `model` in place of the patient's.

    `ding2003` has its own fatigue: a patient with fatigue gets its default values, uncalibrated.
    """
    dynamics, voluntary = patient.muscle, patient.voluntary
    model, natural = model or dynamics.model, dynamics.natural_rad_s
    least_ms = LIMITS["muscle"]["delay_ms"][0]
    naturals = {name: natural * factor for name, factor in dynamics.naturals.items()}
    parameters: dict[str, Any] = {
        "model": model, "delay_ms": dynamics.delay_ms, "fusion_hz": dynamics.fusion_hz,
        "delays_ms": {name: max(dynamics.delay_ms + more, least_ms)
                      for name, more in dynamics.delays_ms.items()},
        "natural_rad_s": natural, "naturals_rad_s": naturals, "voluntary_limit": voluntary.limit,
        "voluntary_limits": dict(voluntary.muscles),
        "hammerstein": Hammerstein(activation_rad_s=natural, activations_rad_s=naturals)}
    if patient.variation != Variation():
        parameters["variation"] = patient.variation
    if patient.fatigue is not None:
        if model == "ding2003":
            parameters["ding2003"] = Ding2003(fatigue=Ding2003Fatigue())
        else:
            parameters["fatigue"] = patient.fatigue.of_muscles
    if patient.spasticity is not None:
        parameters["reflex"] = patient.spasticity.reflex
    if patient.tremor is not None:
        parameters["tremor"] = patient.tremor.of_muscles
    return parameters


def electrodes(patient: Patient, elements: int) -> dict[str, Any]:
    """Parameters of `electrodes` with a number of elements.

    Positions of motor points and arrays along the forearm scale with its length.
    """
    person, recruitment, place = patient.anthropometry, patient.recruitment, patient.placement
    length_mm = 1e3 * person.size.forearm
    scale = length_mm / ADULT_FOREARM_MM
    points = tuple(_moved(point, scale, patient.anatomy.motor_points.get(point.muscle, _NOWHERE))
                   for point in MOTOR_POINTS)
    return {
        "radius_mm": person.forearm_radius_mm, "length_mm": length_mm, "motor_points": points,
        "axons": replace(AxonScatter(), spread=recruitment.spread),
        "axon_seed": recruitment.axon_seed, "chronaxie_us": recruitment.chronaxie_us,
        "threshold": tuple(recruitment.threshold * recruitment.thresholds.get(name, 1.0) for name in MUSCLES),
        "chronaxie": tuple(recruitment.chronaxies.get(name, 1.0) for name in MUSCLES),
        "shift_mm": place.along_mm + (scale - 1.0) * DORSAL.centre_mm, "shift_deg": place.around_deg,
        "skin_gain": skin_gains(patient, elements)}


_NOWHERE = (0.0, 0.0, 0.0)


def _moved(point: MotorPoint, scale: float, shift: Triple) -> MotorPoint:
    """Motor point of a person: scaled along the forearm, then displaced along, around, and in depth."""
    along, around, depth = shift
    return replace(point, along_mm=max(scale * point.along_mm + along, 1.0),
                   around_deg=point.around_deg + around, depth_mm=max(point.depth_mm + depth, LEAST_DEPTH_MM))


def sensors(patient: Patient) -> dict[str, Any]:
    """Parameters of `imus`: how the sensors were put on that day."""
    placed = patient.sensors
    parameters: dict[str, Any] = {}
    if placed.mounting_deg:
        parameters["mounting_deg"] = dict(placed.mounting_deg)
    if placed.sag_deg is not None:
        parameters["soft_tissue"] = {"sag_deg": placed.sag_deg,
                                     "outwards": (patient.hand_size.outwards, 0.0, 0.0)}
    if patient.calibration.error_scale != 1.0:
        parameters["error_scale"] = patient.calibration.error_scale
    return parameters


BALL = "F1m"
"""Segment that a ball joint moves."""


def misjudged(hand: HandSize, measured: HandSize, scale: float) -> HandSize:
    """A hand that differs from `hand` by `scale` times as much as `measured` does.

    Displacements and tilts are limited to what `HandSize` takes: 20 mm and 45 deg a component. The axes of
    the thumb's CMC joint stay untold at any scale: trackers take those of a ball joint to be the usual ones.
    """
    def moved(exact: Any, told: Any) -> Any:
        return exact + scale * (np.asarray(told) - exact)

    def width_mm(size: HandSize) -> float:
        return WIDTH_RATIO * size.hand_mm if size.width_mm is None else size.width_mm

    none = np.zeros((5, 3))
    shifts = none if hand.joints_mm is None else np.array(hand.joints_mm)
    joints = np.clip(moved(shifts, none), *SHIFT_MM)
    tilts = {name: np.clip(moved(np.array(tilt), np.zeros(3)), *TILT_DEG)
             for name, tilt in hand.axes_deg.items() if name != BALL}
    return replace(
        measured, hand_mm=float(moved(hand.hand_mm, measured.hand_mm)),
        width_mm=float(moved(width_mm(hand), width_mm(measured))),
        forearm_mm=1e3 * float(moved(hand.forearm, measured.forearm)),
        segments_mm=triples(1e3 * moved(hand.segments, measured.segments)), joints_mm=triples(joints),
        axes_deg=dict(zip(tilts, triples(list(tilts.values())), strict=True)))


def skin_gains(patient: Patient, elements: int) -> tuple[float, ...]:
    """Fraction of each element's current that passes the skin on this day."""
    place = patient.placement
    stream = NoiseStream(stream_key(place.skin_seed, "skin", 0), 1)
    normal = np.array([stream.row(element)[0] for element in range(elements)])
    return tuple(float(gain) for gain in place.skin * np.exp(place.element_sd * normal))


def table_of(patient: Patient, kind: str, own: Mapping[str, Any]) -> dict[str, Any]:
    """Table of an experiment file for the patient and a kind of block; empty for other kinds.

    `own` is the block's own table in the file, unchecked: it determines the muscles' model and the number of
    elements.
    """
    if kind in ("hand", "myohand"):
        parameters = hand(patient)
        if kind == "myohand":
            del parameters["hand"]  # MyoHand has its own size
        if own.get("assist"):
            scale = patient.calibration.error_scale
            parameters["assist"] = {"error_deg": {
                name: scale * error for name, error in patient.calibration.pose_error_deg.items()}}
        return _plain(parameters)
    if kind == "muscles":
        model = own.get("model")
        return _plain(muscles(patient, model if isinstance(model, str) else ""))
    if kind == "intention":
        able = patient.voluntary
        return {"voluntary_limit": able.limit, "voluntary_limits": dict(able.muscles)}
    if kind == "electrodes":
        elements = _elements(own.get("arrays"))
        parameters = electrodes(patient, elements)
        if not elements:
            del parameters["skin_gain"]
        return _plain(parameters)
    if kind == "moving_hand":
        return _plain({"pose_error_deg": dict(patient.calibration.pose_error_deg)})
    if kind == "imus":
        return _plain(sensors(patient))
    if kind == "safety":
        return safety(patient, own)
    return {}


def safety(patient: Patient, own: Mapping[str, Any]) -> dict[str, Any]:
    """Limits of the `safety` block.

    Raises InputError if the experiment itself allows more than the patient's limits.
    """
    limits = cast("dict[str, float]", plain(patient.tolerance))
    for key, limit in limits.items():
        declared = own.get(key)  # one value for all channels, or one for each
        most = max((value for value in (declared if isinstance(declared, (list, tuple)) else (declared,))
                    if isinstance(value, (int, float))), default=limit)
        if most > limit:
            raise InputError(f"safety.{key}", f"{most:g}", f"at most {limit:g} for {patient.name}",
                             "remove it, or lower it")
    return dict(limits)


def _plain(parameters: dict[str, Any]) -> dict[str, Any]:
    return {key: plain(value) for key, value in parameters.items()}


def _elements(arrays: Any) -> int:
    """Number of elements of unchecked arrays; 0 for invalid ones, which a later check reports."""
    if arrays is None:
        from plants.electrodes.recruitment import Electrodes

        return Electrodes().elements
    try:
        count = sum(len(array.get("positions", ())) or array.get("rows", 0) * array.get("columns", 0)
                    for array in arrays)
        return count if 0 < count <= len(arrays) * MOST_ELEMENTS else 0
    except (TypeError, AttributeError):
        return 0


MOST_SD = 2.5
"""Greatest deviation of a random value from its middle, in sd (chosen: the most unusual of a hundred)."""
_NEW_SEEDS = 2**53
_NO_ONES: Mapping[str, float] = MappingProxyType({})


@dataclass(frozen=True, slots=True)
class Draws:
    """Random numbers of one member or one day, with a separate stream for each quantity.

    Members, days and quantities are therefore independent of each other and of their number.
    """

    seed: int
    name: str
    number: int

    def uniform(self, quantity: str, width: int = 1) -> NDArray[np.float64]:
        """Uniform numbers (width,), in [0, 1)."""
        return NoiseStream(stream_key(self.seed, f"{self.name}/{quantity}", self.number), width,
                           "uniform").row(0)

    def near(self, quantity: str, middle: float, sd: float, limits: Limits) -> float:
        """Normal number around `middle`, within `MOST_SD` and the limits."""
        return _truncated(float(self.uniform(quantity)[0]), middle, sd, limits)

    def scaled(self, quantity: str, middle: float, sd: float, limits: Limits) -> float:
        """Lognormal number of median `middle` and log sd `sd`, within `MOST_SD` and the limits."""
        return _scaled(float(self.uniform(quantity)[0]), middle, sd, limits)

    def of_muscles(self, quantity: str, middles: dict[str, float], sd: float, limits: Limits,
                   single: Mapping[str, float] = _NO_ONES) -> dict[str, float]:
        """Lognormal factors of all muscles, with medians `middles` (default 1); `single` sds replace `sd`."""
        return self._each(_scaled, quantity, middles, 1.0, sd, limits, single)

    def near_muscles(self, quantity: str, middles: dict[str, float], sd: float, limits: Limits,
                     single: Mapping[str, float] = _NO_ONES) -> dict[str, float]:
        """Normal numbers of all muscles, around `middles` (default 0); `single` sds replace `sd`."""
        return self._each(_truncated, quantity, middles, 0.0, sd, limits, single)

    def _each(self, quantile: Callable[[float, float, float, Limits], float], quantity: str,
              middles: dict[str, float], usual: float, sd: float, limits: Limits,
              single: Mapping[str, float]) -> dict[str, float]:
        if sd == 0.0 and not any(single.values()):
            return middles
        shares = self.uniform(quantity, len(MUSCLES))
        return {name: quantile(float(share), middles.get(name, usual), single.get(name, sd), limits)
                for name, share in zip(MUSCLES, shares, strict=True)}

    def new_seed(self, quantity: str) -> int:
        """Seed of a quantity, unique to this member or day."""
        return stream_key(self.seed, f"{self.name}/{quantity}", self.number) % _NEW_SEEDS


def _truncated(share: float, middle: float, sd: float, limits: Limits) -> float:
    """Quantile `share` of the truncated normal distribution around `middle`."""
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
"""Greatest random displacement of arrays, as a fraction of the forearm's length (chosen: they stay on it)."""


def member_of(patient: Patient, spread: CohortSpread, cohort: int, number: int) -> Patient:
    """Random patient of the same kind."""
    draws = Draws(cohort, f"patient/{patient.name}", number)
    muscle, passive, limits = patient.muscle, patient.passive, LIMITS["muscle"]
    muscle = replace(
        muscle, delay_ms=draws.near("delay", muscle.delay_ms, spread.delay_ms, limits["delay_ms"]),
        natural_rad_s=draws.scaled("natural", muscle.natural_rad_s, spread.natural, limits["natural_rad_s"]),
        delays_ms=draws.near_muscles("muscle delay", muscle.delays_ms, spread.muscle_delay_ms,
                                     limits["delays_ms"], spread.delays_ms),
        naturals=draws.of_muscles("muscle natural", muscle.naturals, spread.muscle_natural,
                                  limits["naturals"], spread.naturals))
    passive = replace(passive, rest_deg=_rest(passive.rest_deg, spread.rest_deg, draws),
                      mcp_n_m_per_rad=draws.scaled("mcp", passive.mcp_n_m_per_rad, spread.mcp,
                                                   LIMITS["passive"]["mcp_n_m_per_rad"]))
    measures = _measures(patient.anthropometry, spread, draws)
    return replace(
        patient, anthropometry=measures, anatomy=_anatomy(patient.anatomy, measures, spread, draws),
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


def _anatomy(anatomy: Anatomy, measures: Anthropometry, spread: CohortSpread, draws: Draws) -> Anatomy:
    """Random bones, joints and motor points; those that do not vary stay as they are."""
    limits = LIMITS["anatomy"]
    motor = (spread.motor_along_mm, spread.motor_around_deg, spread.motor_depth_mm)
    width = WIDTH_RATIO * measures.hand_mm if anatomy.width_mm is None else anatomy.width_mm
    return Anatomy(
        lengths={bone: draws.scaled(f"length {bone}", anatomy.lengths.get(bone, 1.0), spread.length,
                                    limits["lengths"]) for bone in BONES} if spread.length
        else anatomy.lengths,
        joints_mm=_shifted("joint", anatomy.joints_mm, FINGERS, (spread.joint_mm,) * 3, limits["joints_mm"],
                           draws),
        axes_deg=_shifted("axes", anatomy.axes_deg, JOINTED, (spread.axis_deg / math.sqrt(3.0),) * 3,
                          limits["axes_deg"], draws),
        width_mm=draws.near("width", width, spread.width_mm, limits["width_mm"]) if spread.width_mm
        else anatomy.width_mm,
        motor_points=_shifted("motor point", anatomy.motor_points, EXTRINSIC, motor, limits["motor_points"],
                              draws))


def _shifted(quantity: str, middles: Mapping[str, Triple], names: Sequence[str], sds: Triple, limits: Limits,
             draws: Draws) -> dict[str, Triple]:
    """Random vectors around `middles`, by name, with a standard deviation of each component."""
    if not any(sds):
        return dict(middles)

    def component(name: str, i: int) -> float:
        return draws.near(f"{quantity} {name} {i}", middles.get(name, _NOWHERE)[i], sds[i], limits)

    return {name: (component(name, 0), component(name, 1), component(name, 2)) for name in names}


def _rest(rest_deg: Mapping[str, float], sd: float, draws: Draws) -> dict[str, float]:
    """Random resting posture of the flexions; half of the variance is common to the fingers."""
    if not sd:
        return dict(rest_deg)
    common = draws.near("rest of all fingers", 0.0, sd * math.sqrt(0.5), (-90.0, 90.0))
    found = dict(rest_deg)
    for freedom, (low, high) in RANGES_DEG.items():
        if freedom.endswith("_flexion"):
            several = freedom[:2] in FINGERS[1:]
            middle = rest_deg.get(freedom, RESTING_DEG[freedom]) + common * several
            found[freedom] = draws.near(f"rest {freedom}", min(max(middle, low + 1.0), high - 1.0),
                                        sd * math.sqrt(0.5 if several else 1.0), (low + 1.0, high - 1.0))
    return found


def _strength(strength: Strength, spread: CohortSpread, draws: Draws) -> Strength:
    limits = LIMITS["strength"]
    denervated = {name: draws.near(f"denervated {name}", share, spread.denervated, limits["denervated"])
                  if 0.0 < share < 1.0 else share for name, share in strength.denervated.items()}
    return Strength(
        overall=draws.scaled("strength", strength.overall, spread.strength, limits["overall"]),
        muscles=draws.of_muscles("muscle strength", strength.muscles, spread.muscle_strength,
                                 limits["muscles"], spread.strengths),
        denervated=denervated)


def _recruitment(recruitment: Recruitment, spread: CohortSpread, draws: Draws) -> Recruitment:
    limits = LIMITS["recruitment"]
    return replace(
        recruitment, axon_seed=draws.new_seed("axons"),
        threshold=draws.scaled("threshold", recruitment.threshold, spread.threshold, limits["threshold"]),
        thresholds=draws.of_muscles("muscle threshold", recruitment.thresholds, spread.muscle_threshold,
                                    limits["thresholds"], spread.thresholds),
        chronaxies=draws.of_muscles("muscle chronaxie", recruitment.chronaxies, spread.muscle_chronaxie,
                                    limits["chronaxies"]))


def _voluntary(voluntary: Voluntary, spread: CohortSpread, draws: Draws) -> Voluntary:
    """Random efforts; an effort of 0 remains 0."""
    def varied(name: str, effort: float) -> float:
        return draws.near(name, effort, spread.voluntary, LIMITS["voluntary"]["limit"]) if effort else 0.0

    return Voluntary(limit=varied("voluntary", voluntary.limit), muscles={
        name: varied(f"voluntary {name}", effort) for name, effort in voluntary.muscles.items()})


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
    """The patient on a numbered day."""
    draws = Draws(0, f"patient/{patient.name}/day", number)
    strength, recruitment, muscle = patient.strength, patient.recruitment, patient.muscle
    return replace(
        patient, placement=_placement(patient, spread, draws), sensors=_worn(patient.sensors, spread, draws),
        calibration=_measured(patient.calibration, spread, draws),
        strength=replace(strength, overall=draws.scaled(
            "strength", strength.overall, spread.strength, LIMITS["strength"]["overall"])),
        recruitment=replace(recruitment, threshold=draws.scaled(
            "threshold", recruitment.threshold, spread.threshold, LIMITS["recruitment"]["threshold"])),
        muscle=replace(muscle, delay_ms=draws.near(
            "delay", muscle.delay_ms, spread.delay_ms, LIMITS["muscle"]["delay_ms"])),
        fatigue=_fatigue(patient.fatigue, spread.endurance, draws),
        spasticity=_spasticity(patient.spasticity, spread.spasticity, draws))


def _placement(patient: Patient, spread: DaySpread, draws: Draws) -> Placement:
    """Random placement of the arrays, and skin under them, on a day."""
    place, limits = patient.placement, LIMITS["placement"]
    farthest = max(FARTHEST * 1e3 * patient.anthropometry.size.forearm, abs(place.along_mm))
    return Placement(
        along_mm=draws.near("along", place.along_mm, spread.along_mm,
                            (max(-farthest, limits["along_mm"][0]), min(farthest, limits["along_mm"][1]))),
        around_deg=draws.near("around", place.around_deg, spread.around_deg, limits["around_deg"]),
        skin=draws.scaled("skin", place.skin, spread.skin, limits["skin"]),
        element_sd=max(place.element_sd, spread.element), skin_seed=draws.new_seed("skin"))


def _worn(sensors: SensorPlacement, spread: DaySpread, draws: Draws) -> SensorPlacement:
    """Random mounting of the sensors on a day; half of its variance is common to a strip."""
    if not spread.mounting_deg and not spread.sag_deg:
        return sensors
    limits, sd = LIMITS["sensors"], spread.mounting_deg / math.sqrt(6.0)
    names = ("forearm", *JOINTED)
    strips = _shifted("strip", {}, (*FINGERS, "forearm", "hand"), (sd,) * 3, limits["mounting_deg"], draws)
    middles = {name: _sum(sensors.mounting_deg.get(name, _NOWHERE), strips.get(name[:2], strips.get(name)))
               for name in names} if spread.mounting_deg else dict(sensors.mounting_deg)
    sag = sensors.sag_deg or 0.0
    return SensorPlacement(
        mounting_deg=_shifted("mounting", middles, names, (sd,) * 3, limits["mounting_deg"], draws),
        sag_deg=draws.near("sag", sag, spread.sag_deg, limits["sag_deg"]) if spread.sag_deg
        else sensors.sag_deg)


def _sum(first: Triple, second: Triple | None) -> Triple:
    x, y, z = second or _NOWHERE
    return first[0] + x, first[1] + y, first[2] + z


def _measured(calibration: Calibration, spread: DaySpread, draws: Draws) -> Calibration:
    """Random errors of the held pose and of the ruler on a day."""
    limits = LIMITS["calibration"]
    errors = dict(calibration.pose_error_deg)
    if spread.pose_deg:
        errors = {freedom: draws.near(f"pose {freedom}", errors.get(freedom, 0.0), spread.pose_deg,
                                      limits["pose_error_deg"]) for freedom in FREEDOMS}
    return replace(
        calibration, pose_error_deg=errors,
        hand_error_mm=draws.near("ruler hand", calibration.hand_error_mm, spread.ruler_mm,
                                 limits["hand_error_mm"]),
        width_error_mm=draws.near("ruler width", calibration.width_error_mm, spread.ruler_mm,
                                  limits["width_error_mm"]))


GREATEST_NUMBER = 2**31 - 1
"""Greatest number of a cohort, member or day (chosen)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Patient:
    """A virtual patient. A preset is the middle of its kind; `member` and `on_day` vary it.

    Attributes
    ----------
    name: name of the preset or of the variant: "sci_c6", "sci_c6.1.3" (cohort 1, member 3),
        "sci_c6.1.3 day 2". Random values depend on it.
    description: description for readers.
    anthropometry, anatomy, strength, recruitment, muscle, voluntary, passive, placement, sensors,
        calibration: sections of the file; defaults are those of an able-bodied adult of average proportions,
        with sensors and electrodes in their places and measured without error.
    tolerance: limits of stimulation below those of the `safety` block.
    variation: of stimulated muscle's strength from trial to trial (`plants.muscles.variation`).
    fatigue, spasticity, tremor: None for a patient without.
    cohort, day: variation between patients of this kind, and between days; None in a variant.

    Raises InputErrors with all contradictions.
    """

    name: str
    description: str = ""
    anthropometry: Anthropometry = field(default_factory=Anthropometry)
    anatomy: Anatomy = field(default_factory=Anatomy)
    strength: Strength = field(default_factory=Strength)
    recruitment: Recruitment = field(default_factory=Recruitment)
    muscle: MuscleDynamics = field(default_factory=MuscleDynamics)
    variation: Variation = field(default_factory=Variation)
    fatigue: Fatigue | None = None
    voluntary: Voluntary = field(default_factory=Voluntary)
    passive: Passive = field(default_factory=Passive)
    spasticity: Spasticity | None = None
    tremor: Tremor | None = None
    placement: Placement = field(default_factory=Placement)
    sensors: SensorPlacement = field(default_factory=SensorPlacement)
    calibration: Calibration = field(default_factory=Calibration)
    tolerance: Tolerance = field(default_factory=Tolerance)
    cohort: CohortSpread | None = None
    day: DaySpread | None = None

    def __post_init__(self) -> None:
        faults = list(self._contradictions())
        if faults:
            raise InputErrors(faults)

    @property
    def hand_size(self) -> HandSize:
        """The hand itself, for plants."""
        return self.anatomy.of(self.anthropometry.size)

    @property
    def measured_hand(self) -> HandSize:
        """The hand as a clinician measures it, for trackers and controllers: side, length and width.

        With an `error_scale` of other than 1, its difference from the hand itself is so many times as large.
        """
        measures, hand, errors = self.anthropometry.size, self.hand_size, self.calibration
        length = measures.hand_mm * (hand.reach / measures.reach) + errors.hand_error_mm
        width = None if hand.width_mm is None else hand.width_mm + errors.width_error_mm
        measured = replace(measures, hand_mm=length, width_mm=width)
        return measured if errors.error_scale == 1.0 else misjudged(hand, measured, errors.error_scale)

    def with_error_scale(self, scale: float) -> Patient:
        """The same person and day with other errors of what a tracker knows and senses.

        Muscles, nerves, electrodes and the hand itself do not change. Raises InputErrors outside 0 to 4.
        """
        return replace(self, calibration=replace(self.calibration, error_scale=scale))

    def hand(self) -> dict[str, Any]:
        """Parameters of the `hand` and the `myohand` plant."""
        return hand(self)

    def muscles(self, model: str = "") -> dict[str, Any]:
        """Parameters of the `muscles` plant; `model` replaces the patient's if given."""
        return muscles(self, model)

    def electrodes(self, elements: int = 59) -> dict[str, Any]:
        """Parameters of the `electrodes` block with a number of elements."""
        return electrodes(self, elements)

    def parameters(self, kind: str, own: Mapping[str, Any]) -> dict[str, Any]:
        """Plain parameters for a kind of block, whose own table in an experiment file is `own`."""
        return table_of(self, kind, own)

    def table(self) -> dict[str, Any]:
        """Plain tables of the patient's file."""
        tables = cast("dict[str, Any]", plain(self))
        # A patient of average proportions has the table, and so the fingerprint, of one who knows no others.
        for key, usual in (("anatomy", Anatomy()), ("sensors", SensorPlacement()),
                           ("calibration", Calibration()), ("variation", Variation())):
            if getattr(self, key) == usual:
                del tables[key]
        return tables

    def _contradictions(self) -> Iterator[InputError]:
        if not self.name:
            yield InputError("name", "is empty", "a name, on which random values depend")
        dead = {name for name, share in self.strength.denervated.items() if share >= 1.0}
        alive = "a muscle with some nerve left, see strength.denervated"
        for name in sorted(dead.intersection(self.spasticity.muscles if self.spasticity else ())):
            yield InputError("spasticity.muscles", f"{name} is completely denervated: it has no reflex",
                             alive)
        for name in sorted(dead.intersection(self.tremor.muscles if self.tremor else ())):
            yield InputError("tremor.muscles", f"{name} is completely denervated: it has no tremor", alive)
        for name in sorted(dead):
            if self.voluntary.muscles.get(name, 0.0) > 0.0:
                yield InputError(f"voluntary.muscles.{name}", "has voluntary effort, but is completely "
                                 "denervated", alive)
        if self.spasticity and not (self.spasticity.gain_s and self.spasticity.limit):
            yield InputError("spasticity", "the reflex has no effect", "gain_s and limit above 0",
                             "remove the section for a patient without spasticity")

    def member(self, *, cohort: int, number: int) -> Patient:
        """A random patient of this kind, determined by cohort and number alone.

        Raises InputError for a patient who is a variant already, or whose file states no variation.
        """
        _require_number("cohort", cohort)
        _require_number("member", number)
        if self.cohort is None:
            raise InputError(self.name, "has no [cohort] table with the variation between members",
                             "a preset", "add the table, empty if all are alike")
        member = member_of(self, self.cohort, cohort, number)
        return replace(member, name=f"{self.name}.{cohort}.{number}", cohort=None)

    def on_day(self, number: int) -> Patient:
        """The patient on one day, with its electrode placement, skin and condition.

        Raises InputError if the patient is one of a day already, or the file states no variation.
        """
        _require_number("day", number)
        if self.day is None:
            raise InputError(self.name, "has no [day] table with the variation between days",
                             "a patient with such a table", "add the table, empty if all are alike")
        return replace(on_day_of(self, self.day, number), name=f"{self.name} day {number}",
                       cohort=None, day=None)


def _require_number(key: str, number: int) -> None:
    if not 0 <= number <= GREATEST_NUMBER:
        raise InputError(key, f"{number}", f"0 to {GREATEST_NUMBER}")
