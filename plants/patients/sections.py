"""Sections of a patient's file, in clinical terms; one class per section."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields, replace
from typing import Any, Literal, cast

import numpy as np

from fesloop.errors import InputError, InputErrors, did_you_mean
from fesloop.hand.anthropometry import BONES, FINGERS, JOINTED, HandSize
from fesloop.hand.movements import EXTRINSIC, FREEDOMS, MUSCLES, muscle
from fesloop.hand.skeleton import hand_tree
from plants.hand.model import require_in_range, resting_posture
from plants.muscles.lags import CONDITIONS, MuscleFatigue
from plants.muscles.patient_drive import MuscleTremor, StretchReflex, chosen

Limits = tuple[float, float]
Triple = tuple[float, float, float]

LIMITS: dict[str, dict[str, Limits]] = {
    # (chosen: hands from a child of eight years to the largest; arms long enough for arrays of 96 mm)
    "anthropometry": {"hand_mm": (130.0, 240.0), "forearm_mm": (160.0, 400.0),
                      "forearm_radius_mm": (25.0, 65.0)},
    # (chosen: from a trace of force, 1 % of the able-bodied adult's, to an athlete's)
    "strength": {"overall": (0.01, 3.0), "muscles": (0.01, 3.0), "denervated": (0.0, 1.0)},
    # (chosen: thresholds beyond these cannot be distinguished with 126 mA)
    "recruitment": {"threshold": (0.1, 10.0), "thresholds": (0.1, 10.0), "spread": (0.0, 1.0),
                    "chronaxie_us": (20.0, 2000.0), "chronaxies": (0.1, 10.0), "axon_seed": (0.0, 2.0**53)},
    # Delay: 10-20 ms in models, 40-140 measured at the wrist; speed: models are off by up to 5 times from
    # 20-25 rad/s (Hunt 1998). Single muscles: four sd among people's (docs/models/people.md), rounded up.
    "muscle": {"delay_ms": (5.0, 200.0), "natural_rad_s": (4.0, 125.0), "fusion_hz": (2.0, 50.0),
               "delays_ms": (-50.0, 50.0), "naturals": (0.25, 4.0)},
    "fatigue": {"endurance": (0.05, 20.0), "floor": (0.0, 1.0), "fatigue_s": (0.05, 1000.0),
                "recovery_s": (1.0, 10000.0), "frequency_weight": (0.0, 1.0)},
    "voluntary": {"limit": (0.0, 1.0), "muscles": (0.0, 1.0)},
    # MCP joints: .033 N m/rad in health to .64 at MAS 3 (PMC7775510), and twice that.
    "passive": {"mcp_n_m_per_rad": (0.02, 1.3), "stiffness": (0.1, 10.0), "damping": (0.1, 10.0),
                "tension": (0.0, 5.0), "rest_deg": (-180.0, 180.0)},
    "spasticity": {"gain_s": (0.0, 20.0), "threshold_per_s": (0.0, 20.0), "delay_ms": (10.0, 200.0),
                   "limit": (0.0, 1.0)},
    "tremor": {"activation": (0.0, 0.5), "frequency_hz": (2.0, 15.0), "spread_hz": (0.001, 3.0)},
    # Shifts of +-10 mm, +-10 deg are to be expected; greater ones are mistakes in putting on the arrays.
    "placement": {"along_mm": (-40.0, 40.0), "around_deg": (-45.0, 45.0), "skin": (0.05, 1.5),
                  "element_sd": (0.0, 1.0), "skin_seed": (0.0, 2.0**53)},
    # (chosen: several sd of what people differ by; joints, axes and motor points beyond these are mistakes)
    "anatomy": {"lengths": (0.7, 1.4), "joints_mm": (-20.0, 20.0), "axes_deg": (-30.0, 30.0),
                "width_mm": (50.0, 130.0), "motor_points": (-60.0, 60.0)},
    "sensors": {"mounting_deg": (-45.0, 45.0), "sag_deg": (0.0, 20.0)},
    "calibration": {"pose_error_deg": (-60.0, 60.0), "hand_error_mm": (-20.0, 20.0),
                    "width_error_mm": (-20.0, 20.0), "error_scale": (0.0, 4.0)},
    # Stimulators give 126 mA, 126 mA x 500 us = 63 uC, and 50 of them a second.
    "tolerance": {"current_max_ma": (1.0, 126.0), "charge_max_uc": (0.1, 63.0),
                  "charge_per_s_max_uc": (0.1, 3150.0)},
}
"""Ranges by section of a patient's file; the range of a table applies to each of its values."""
SPREADS: dict[str, Limits] = {
    "hand_mm": (0.0, 40.0), "forearm_radius_mm": (0.0, 15.0), "delay_ms": (0.0, 50.0),
    "muscle_delay_ms": (0.0, 50.0), "delays_ms": (0.0, 50.0),
    "voluntary": (0.0, 0.5), "denervated": (0.0, 0.5), "along_mm": (0.0, 20.0), "around_deg": (0.0, 20.0),
    "tremor_hz": (0.0, 5.0), "length": (0.0, 0.1), "joint_mm": (0.0, 8.0), "axis_deg": (0.0, 12.0),
    "width_mm": (0.0, 15.0), "motor_along_mm": (0.0, 20.0), "motor_around_deg": (0.0, 20.0),
    "motor_depth_mm": (0.0, 5.0), "rest_deg": (0.0, 20.0), "mounting_deg": (0.0, 20.0),
    "sag_deg": (0.0, 5.0), "pose_deg": (0.0, 20.0), "ruler_mm": (0.0, 8.0)}
"""Ranges of standard deviations; all others are of logarithms, and range from 0 to 1."""

_UNITS = {"_mm": " mm", "_deg": " deg", "_ms": " ms", "_s": " s", "_per_s": " 1/s", "_rad_s": " rad/s",
          "_us": " us", "_hz": " Hz", "_ma": " mA", "_n_m_per_rad": " N m/rad", "_uc": " uC",
          "_per_s_max_uc": " uC/s"}
"""Units by the end of a name; the last match applies."""


def refuse(section: str, parameters: object, limits: Mapping[str, Limits], *muscle_tables: str) -> None:
    """Raise InputErrors for all numbers of a section outside their ranges, and all unknown muscles."""
    faults = list(_faults(section, parameters, limits, muscle_tables))
    if faults:
        raise InputErrors(faults)


def _faults(section: str, parameters: Any, limits: Mapping[str, Limits],
            muscle_tables: tuple[str, ...]) -> Iterator[InputError]:
    for key, (low, high) in limits.items():
        value = getattr(parameters, key)
        named = value.items() if isinstance(value, Mapping) else (("", value),)
        for name, several in named:
            where = f"{section}.{key}" + (f".{name}" if name else "")
            if key in muscle_tables and name not in MUSCLES:
                yield _unknown_muscle(where, name)
                continue
            for number in several if isinstance(several, tuple) else (several,):
                if number is not None and not (math.isfinite(number) and low <= number <= high):
                    unit = next((unit for end, unit in reversed(_UNITS.items()) if key.endswith(end)), "")
                    yield InputError(where, f"{number:g}{unit}", f"{low:g} to {high:g}{unit}")


def _unknown_muscle(where: str, name: str) -> InputError:
    try:
        muscle(name)
    except InputError as fault:
        return InputError(where, f"no muscle is named {name!r}", fault.allowed, fault.remedy)
    raise AssertionError(f"{name} is a muscle")


def spread_limits(keys: tuple[str, ...]) -> dict[str, Limits]:
    """Ranges of standard deviations."""
    return {key: SPREADS.get(key, (0.0, 1.0)) for key in keys}


@dataclass(frozen=True, slots=True, kw_only=True)
class Anthropometry:
    """Measures of hand and forearm.

    Attributes
    ----------
    side: side of the body.
    hand_mm: length from the wrist's crease to the tip of the middle finger.
    forearm_mm: length from elbow to wrist; default: in proportion to the hand.
    forearm_radius_mm: radius of the forearm as a cylinder.
    """

    side: Literal["left", "right"] = "right"
    hand_mm: float = 190.0
    forearm_mm: float | None = None
    forearm_radius_mm: float = 40.0

    def __post_init__(self) -> None:
        refuse("anthropometry", self, LIMITS["anthropometry"])
        if self.side not in ("left", "right"):
            raise InputError("anthropometry.side", f"{self.side!r}", "'left', 'right'")

    @property
    def size(self) -> HandSize:
        """Measures of the hand for skeleton and trackers."""
        return HandSize(side=self.side, hand_mm=self.hand_mm, forearm_mm=self.forearm_mm)


@dataclass(frozen=True, slots=True, kw_only=True)
class Anatomy:
    """Deviations of a person's bones, joints and nerves from proportion; empty: none.

    Trackers, controllers and searches are told none of it.

    Attributes
    ----------
    lengths: factors on the functional lengths of bones, by segment.
    joints_mm: displacement of the first joint of a digit on the palm, by digit: dorsal, distal, ulnar.
    axes_deg: tilt of the axes of the joint that moves a segment, by segment: a rotation vector about the
        segment's x, y and z.
    width_mm: of the hand across the MCP joints; default: in proportion to its length.
    motor_points: displacement of motor points, by muscle: along the forearm, mm, around it, deg, and in
        depth, mm.
    """

    lengths: dict[str, float] = field(default_factory=dict)
    joints_mm: dict[str, Triple] = field(default_factory=dict)
    axes_deg: dict[str, Triple] = field(default_factory=dict)
    width_mm: float | None = None
    motor_points: dict[str, Triple] = field(default_factory=dict)

    def __post_init__(self) -> None:
        _require_names("anatomy.lengths", self.lengths, BONES)
        _require_names("anatomy.joints_mm", self.joints_mm, FINGERS)
        _require_names("anatomy.axes_deg", self.axes_deg, JOINTED)
        _require_names("anatomy.motor_points", self.motor_points, EXTRINSIC)
        refuse("anatomy", self, LIMITS["anatomy"])

    def of(self, measures: HandSize) -> HandSize:
        """The hand of these measures with this anatomy."""
        scales = np.array([self.lengths.get(bone, 1.0) for bone in BONES]).reshape(5, 3)
        shifts = tuple(self.joints_mm.get(digit, (0.0, 0.0, 0.0)) for digit in FINGERS)
        return replace(
            measures, axes_deg=dict(self.axes_deg), width_mm=self.width_mm,
            segments_mm=triples(1e3 * scales * measures.segments) if self.lengths else measures.segments_mm,
            joints_mm=cast("Any", shifts) if self.joints_mm else measures.joints_mm)


def triples(table: Any) -> Any:
    """Rows of numbers as tuples."""
    return tuple(tuple(float(each) for each in row) for row in table)


def _require_names(where: str, table: Mapping[str, Any], names: Sequence[str]) -> None:
    for name in table:
        if name not in names:
            raise InputError(f"{where}.{name}", "is unknown", ", ".join(names), did_you_mean(name, names))


@dataclass(frozen=True, slots=True, kw_only=True)
class SensorPlacement:
    """Sensors as they were put on, on one day.

    Attributes
    ----------
    mounting_deg: rotation of a sensor against its segment, by segment: a rotation vector about x, y and z.
    sag_deg: rotation of the sensors by 1 g along the skin (`plants.imus`); None: rigid mounting.
    """

    mounting_deg: dict[str, Triple] = field(default_factory=dict)
    sag_deg: float | None = None

    def __post_init__(self) -> None:
        _require_names("sensors.mounting_deg", self.mounting_deg, ("forearm", *JOINTED))
        refuse("sensors", self, LIMITS["sensors"])


@dataclass(frozen=True, slots=True, kw_only=True)
class Calibration:
    """Errors of what a clinician measures and holds, on one day.

    Attributes
    ----------
    pose_error_deg: difference of the pose that is held from the standard pose, by freedom.
    hand_error_mm, width_error_mm: errors of the ruler.
    error_scale: factor on all errors of a tracker's knowledge and of its sensors: these, those of [sensors]
        and of the inertial sensors themselves, and the difference between the hand and the measured one.
    """

    pose_error_deg: dict[str, float] = field(default_factory=dict)
    hand_error_mm: float = 0.0
    width_error_mm: float = 0.0
    error_scale: float = 1.0

    def __post_init__(self) -> None:
        _require_names("calibration.pose_error_deg", self.pose_error_deg, FREEDOMS)
        refuse("calibration", self, LIMITS["calibration"])


@dataclass(frozen=True, slots=True, kw_only=True)
class Strength:
    """Peak forces relative to those of an able-bodied adult with a hand of the same size.

    Attributes
    ----------
    overall: factor on all muscles.
    muscles: further factors on single muscles, for example after disuse.
    denervated: fraction of each muscle's fibres without a nerve. Neither voluntary effort, reflex nor
        stimulation activates them: pulses of less than a millisecond excite nerves alone.
    """

    overall: float = 1.0
    muscles: dict[str, float] = field(default_factory=dict)
    denervated: dict[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        refuse("strength", self, LIMITS["strength"], "muscles", "denervated")


@dataclass(frozen=True, slots=True, kw_only=True)
class Recruitment:
    """Excitability of motor axons.

    Attributes
    ----------
    threshold: factor on the thresholds of all axons (their median: `plants.electrodes.axons`).
    thresholds: further factors for single muscles.
    spread: standard deviation of the logarithm of thresholds within a muscle.
    chronaxie_us: chronaxie of the axons.
    chronaxies: factors on it for single muscles.
    axon_seed: seed of the axons' positions, which differs between persons.
    """

    threshold: float = 1.0
    thresholds: dict[str, float] = field(default_factory=dict)
    spread: float = 0.25
    chronaxie_us: float = 122.0
    chronaxies: dict[str, float] = field(default_factory=dict)
    axon_seed: int = 0

    def __post_init__(self) -> None:
        refuse("recruitment", self, LIMITS["recruitment"], "thresholds", "chronaxies")


@dataclass(frozen=True, slots=True, kw_only=True)
class MuscleDynamics:
    """Contraction of stimulated muscle.

    Attributes
    ----------
    model: model of the `muscles` block.
    delay_ms: electromechanical delay.
    delays_ms: what single muscles add to it; no muscle has less than 5 ms.
    natural_rad_s: natural frequency of linear activation dynamics, critically damped, also of voluntary
        effort and reflex.
    naturals: further factors on it for single muscles.
    fusion_hz: stimulation frequency of half the fused force.
    """

    model: Literal["hammerstein", "riener", "ding2003", "ding2007"] = "hammerstein"
    delay_ms: float = 40.0
    delays_ms: dict[str, float] = field(default_factory=dict)
    natural_rad_s: float = 16.0
    naturals: dict[str, float] = field(default_factory=dict)
    fusion_hz: float = 10.0

    def __post_init__(self) -> None:
        refuse("muscle", self, LIMITS["muscle"], "delays_ms", "naturals")


@dataclass(frozen=True, slots=True, kw_only=True)
class Fatigue:
    """Fatigue and recovery of muscles.

    Attributes
    ----------
    condition: condition that sets the parameters (`plants.muscles.lags`).
    endurance: factor on the time constant of fatigue.
    floor, fatigue_s, recovery_s, frequency_weight: values in place of the condition's.
    """

    condition: Literal["able_bodied", "sci_acute", "sci_chronic"] = "able_bodied"
    endurance: float = 1.0
    floor: float | None = None
    fatigue_s: float | None = None
    recovery_s: float | None = None
    frequency_weight: float | None = None

    def __post_init__(self) -> None:
        refuse("fatigue", self, LIMITS["fatigue"])
        if self.condition not in CONDITIONS:
            raise InputError("fatigue.condition", f"{self.condition!r}", ", ".join(CONDITIONS))

    @property
    def of_muscles(self) -> MuscleFatigue:
        """Fitness equation of the `muscles` block."""
        given = {key: value for key, value in asdict(self).items()
                 if key not in ("condition", "endurance") and value is not None}
        common = replace(CONDITIONS[self.condition], **given)
        return replace(common, fatigue_s=self.endurance * common.fatigue_s)


@dataclass(frozen=True, slots=True, kw_only=True)
class Placement:
    """Placement of the arrays on one day, and the skin under them.

    Attributes
    ----------
    along_mm, around_deg: displacement towards the wrist and towards the radial side.
    skin: fraction of the current that passes the skin.
    element_sd: standard deviation of its logarithm between elements.
    skin_seed: seed of the elements' skin, which differs between days.
    """

    along_mm: float = 0.0
    around_deg: float = 0.0
    skin: float = 1.0
    element_sd: float = 0.0
    skin_seed: int = 0

    def __post_init__(self) -> None:
        refuse("placement", self, LIMITS["placement"])


@dataclass(frozen=True, slots=True, kw_only=True)
class Tolerance:
    """Limits of stimulation for the patient, in place of those of the `safety` block.

    They may be lower, for example for insensitive skin. Default: the block's.

    Attributes
    ----------
    current_max_ma: limit of a pulse's current.
    charge_max_uc: limit of a phase's charge.
    charge_per_s_max_uc: limit of one phase's charge, summed over a second on one channel.
    """

    current_max_ma: float | None = None
    charge_max_uc: float | None = None
    charge_per_s_max_uc: float | None = None

    def __post_init__(self) -> None:
        refuse("tolerance", self, LIMITS["tolerance"])


@dataclass(frozen=True, slots=True, kw_only=True)
class Voluntary:
    """Voluntary movement.

    Attributes
    ----------
    limit: greatest effort, as a fraction of each muscle's force; 0: none.
    muscles: greatest effort of single muscles, in place of it.
    """

    limit: float = 1.0
    muscles: dict[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        refuse("voluntary", self, LIMITS["voluntary"], "muscles")


@dataclass(frozen=True, slots=True, kw_only=True)
class Passive:
    """Passive resistance of the relaxed hand.

    Attributes
    ----------
    mcp_n_m_per_rad: stiffness of a finger's MCP joint, tendons included, for a hand of 190 mm.
    stiffness, damping, tension: factors on the joints' stiffness and damping, and on passive tension of the
        muscles.
    rest_deg: resting posture by freedom, where it differs from that of a healthy hand.
    """

    mcp_n_m_per_rad: float = 0.04
    stiffness: float = 1.0
    damping: float = 1.0
    tension: float = 1.0
    rest_deg: dict[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        refuse("passive", self, LIMITS["passive"])
        tree = hand_tree(HandSize())
        try:
            angles = resting_posture(tree, self.rest_deg)
        except InputError as fault:
            raise InputError("passive.rest_deg", fault.found, fault.allowed, fault.remedy) from fault
        require_in_range("passive.rest_deg", tree, angles)


@dataclass(frozen=True, slots=True, kw_only=True)
class Spasticity:
    """Stretch reflex; attributes as in `plants.muscles.patient_drive.StretchReflex`."""

    gain_s: float = 0.5
    threshold_per_s: float = 0.1
    delay_ms: float = 30.0
    limit: float = 0.5
    muscles: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        refuse("spasticity", self, LIMITS["spasticity"])
        chosen(self.muscles, "spasticity.muscles")

    @property
    def reflex(self) -> StretchReflex:
        """Parameter of the `muscles` block."""
        return StretchReflex(gain_s=self.gain_s, threshold_per_s=self.threshold_per_s,
                             delay_ms=self.delay_ms, limit=self.limit, muscles=self.muscles)


@dataclass(frozen=True, slots=True, kw_only=True)
class Tremor:
    """Tremor.

    Attributes
    ----------
    activation: rms of the drive of extensors and, in alternation, of all other muscles.
    frequency_hz: the patient's frequency.
    spread_hz: sd of the components' frequencies.
    muscles: names of the trembling muscles; empty: all.
    """

    activation: float = 0.03
    frequency_hz: float = 6.0
    spread_hz: float = 0.3
    muscles: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        refuse("tremor", self, LIMITS["tremor"])
        chosen(self.muscles, "tremor.muscles")

    @property
    def of_muscles(self) -> MuscleTremor:
        """Parameter of the `muscles` block."""
        return MuscleTremor(activation=self.activation, band_hz=(self.frequency_hz, self.frequency_hz),
                            spread_hz=self.spread_hz, muscles=self.muscles)


OF_SINGLE_MUSCLES = ("strengths", "thresholds", "delays_ms", "naturals")
"""Tables of standard deviations by muscle."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CohortSpread:
    """Standard deviations between patients of one kind; 0: all have the preset's value.

    Attributes
    ----------
    hand_mm, forearm_radius_mm: in mm. delay_ms, muscle_delay_ms: in ms, of all muscles together, and in
        addition of each muscle. tremor_hz: in Hz. voluntary: of greatest efforts above 0. denervated: of
        fractions above 0. All others are of logarithms:
    strength, muscle_strength: strength of all muscles together, and in addition of each muscle.
    threshold, muscle_threshold: likewise. muscle_chronaxie: chronaxie of each muscle.
    natural, muscle_natural: natural frequency, likewise.
    strengths, thresholds, delays_ms, naturals: of single muscles, in place of `muscle_strength`,
        `muscle_threshold`, `muscle_delay_ms`, `muscle_natural`.
    endurance, mcp, spasticity: endurance, MCP stiffness, reflex gain.
    length, joint_mm, axis_deg, width_mm: bones' lengths, first joints of the digits (each direction), tilt of
        each joint's axes (root mean square), and width of the hand, mm.
    motor_along_mm, motor_around_deg, motor_depth_mm: motor points.
    rest_deg: resting posture, of each freedom and, half of it, of all fingers alike.
    """

    hand_mm: float = 0.0
    forearm_radius_mm: float = 0.0
    strength: float = 0.0
    muscle_strength: float = 0.0
    denervated: float = 0.0
    threshold: float = 0.0
    muscle_threshold: float = 0.0
    muscle_chronaxie: float = 0.0
    delay_ms: float = 0.0
    muscle_delay_ms: float = 0.0
    natural: float = 0.0
    muscle_natural: float = 0.0
    endurance: float = 0.0
    voluntary: float = 0.0
    mcp: float = 0.0
    spasticity: float = 0.0
    tremor_hz: float = 0.0
    length: float = 0.0
    joint_mm: float = 0.0
    axis_deg: float = 0.0
    width_mm: float = 0.0
    motor_along_mm: float = 0.0
    motor_around_deg: float = 0.0
    motor_depth_mm: float = 0.0
    rest_deg: float = 0.0
    strengths: dict[str, float] = field(default_factory=dict)
    thresholds: dict[str, float] = field(default_factory=dict)
    delays_ms: dict[str, float] = field(default_factory=dict)
    naturals: dict[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        refuse("cohort", self, spread_limits(tuple(each.name for each in fields(self))),
               *OF_SINGLE_MUSCLES)


@dataclass(frozen=True, slots=True, kw_only=True)
class DaySpread:
    """Standard deviations between one patient's days; 0: all days are alike.

    Attributes
    ----------
    along_mm, around_deg: displacement of the arrays, mm and deg. delay_ms: in ms. All others are of
        logarithms:
    skin, element: fraction of the current that passes the skin, of all elements together and of each.
    strength, threshold, endurance, spasticity: as in a cohort.
    mounting_deg: rotation of each sensor against its segment, root mean square; half of its square is common
        to the sensors of a strip. sag_deg: sag of the sensors on the skin.
    pose_deg: held pose against the standard pose, of each freedom. ruler_mm: measured length and width.
    """

    along_mm: float = 0.0
    around_deg: float = 0.0
    skin: float = 0.0
    element: float = 0.0
    strength: float = 0.0
    threshold: float = 0.0
    delay_ms: float = 0.0
    endurance: float = 0.0
    spasticity: float = 0.0
    mounting_deg: float = 0.0
    sag_deg: float = 0.0
    pose_deg: float = 0.0
    ruler_mm: float = 0.0

    def __post_init__(self) -> None:
        refuse("day", self, spread_limits(tuple(each.name for each in fields(self))))
