"""Measures of one patient, in the terms of those who examine patients; a section of the file a class."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field, replace
from typing import Literal

from fesloop.errors import InputError
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.skeleton import hand_tree
from plants.hand.model import require_in_range, resting_posture
from plants.muscles.fitness import CONDITIONS, MuscleFatigue
from plants.muscles.patient_drive import MuscleTremor, StretchReflex, chosen
from plants.patients.limits import LIMITS, refuse


@dataclass(frozen=True, slots=True, kw_only=True)
class Anthropometry:
    """Measures of hand and forearm.

    Attributes
    ----------
    side: of the body.
    hand_mm: from the wrist's crease to the tip of the middle finger.
    forearm_mm: from elbow to wrist; left out: in proportion to the hand.
    forearm_radius_mm: of the cylinder that stands for the forearm.
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
        """The hand's measures as skeleton and trackers take them."""
        return HandSize(side=self.side, hand_mm=self.hand_mm, forearm_mm=self.forearm_mm)


@dataclass(frozen=True, slots=True, kw_only=True)
class Strength:
    """Peak forces, over those of an able-bodied adult with a hand of the same size.

    Attributes
    ----------
    overall: factor on all muscles.
    muscles: further factors on single muscles, such as those wasted by disuse.
    denervated: share of a muscle's fibres whose nerve is dead. Neither will, reflex nor stimulation moves
        them: pulses of less than a millisecond excite nerves alone.
    """

    overall: float = 1.0
    muscles: dict[str, float] = field(default_factory=dict)
    denervated: dict[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        refuse("strength", self, LIMITS["strength"], "muscles", "denervated")


@dataclass(frozen=True, slots=True, kw_only=True)
class Recruitment:
    """How strongly motor axons must be stimulated.

    Attributes
    ----------
    threshold: factor on the thresholds of all axons (their median: `plants.electrodes.axons`).
    thresholds: further factors on those of single muscles.
    spread: standard deviation of the logarithm of thresholds within a muscle.
    chronaxie_us: of the axons.
    axon_seed: of the places of the axons: another person, another number.
    """

    threshold: float = 1.0
    thresholds: dict[str, float] = field(default_factory=dict)
    spread: float = 0.25
    chronaxie_us: float = 200.0
    axon_seed: int = 0

    def __post_init__(self) -> None:
        refuse("recruitment", self, LIMITS["recruitment"], "thresholds")


@dataclass(frozen=True, slots=True, kw_only=True)
class MuscleDynamics:
    """How stimulated muscle contracts.

    Attributes
    ----------
    model: of the `muscles` block.
    delay_ms: electromechanical delay.
    natural_rad_s: of linear activation dynamics, critically damped; of will and reflex, too.
    fusion_hz: stimulation frequency of half the fused force.
    """

    model: Literal["hammerstein", "riener", "ding2003", "ding2007"] = "hammerstein"
    delay_ms: float = 20.0
    natural_rad_s: float = 25.0
    fusion_hz: float = 10.0

    def __post_init__(self) -> None:
        refuse("muscle", self, LIMITS["muscle"])


@dataclass(frozen=True, slots=True, kw_only=True)
class Fatigue:
    """How muscles tire and recover.

    Attributes
    ----------
    condition: whose numbers these are (`plants.muscles.fitness`).
    endurance: factor on the time that it takes to tire.
    floor, fatigue_s, recovery_s, frequency_weight: in place of the condition's numbers.
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
        """The fitness equation's numbers."""
        given = {key: value for key, value in asdict(self).items()
                 if key not in ("condition", "endurance") and value is not None}
        common = replace(CONDITIONS[self.condition], **given)
        return replace(common, fatigue_s=self.endurance * common.fatigue_s)


@dataclass(frozen=True, slots=True, kw_only=True)
class Placement:
    """How the arrays were put on this day, and the skin under them.

    Attributes
    ----------
    along_mm, around_deg: from where they should lie, towards the wrist and towards the radial side.
    skin: share of the current that passes.
    element_sd: standard deviation of its logarithm between elements.
    skin_seed: of the elements: another day, another number.
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
    """What the patient may be given: limits of the `safety` block in place of its own.

    Less than it allows where skin does not feel, for one. Left out: the block's.

    Attributes
    ----------
    current_max_ma: of a pulse.
    charge_max_uc: of a phase.
    charge_per_s_max_uc: of one phase, summed up over a second on one channel.
    """

    current_max_ma: float | None = None
    charge_max_uc: float | None = None
    charge_per_s_max_uc: float | None = None

    def __post_init__(self) -> None:
        refuse("tolerance", self, LIMITS["tolerance"])


@dataclass(frozen=True, slots=True, kw_only=True)
class Voluntary:
    """What the patient can do at will.

    Attributes
    ----------
    limit: greatest effort, of each muscle's force; 0: none.
    muscles: the greatest effort of single muscles, in place of it.
    """

    limit: float = 1.0
    muscles: dict[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        refuse("voluntary", self, LIMITS["voluntary"], "muscles")


@dataclass(frozen=True, slots=True, kw_only=True)
class Passive:
    """What resists movement in the relaxed hand.

    Attributes
    ----------
    mcp_n_m_per_rad: stiffness of a finger's MCP joint, tendons included, of a hand of 190 mm.
    stiffness, damping, tension: factors on the joints' stiffness and damping, and on passive tension of the
        muscles.
    rest_deg: resting posture by freedom, where it differs from health's.
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
    """Stretch reflex; attributes as of `plants.muscles.patient_drive.StretchReflex`."""

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
        """As the `muscles` block takes it."""
        return StretchReflex(gain_s=self.gain_s, threshold_per_s=self.threshold_per_s,
                             delay_ms=self.delay_ms, limit=self.limit, muscles=self.muscles)


@dataclass(frozen=True, slots=True, kw_only=True)
class Tremor:
    """Tremor.

    Attributes
    ----------
    activation: rms of what goes to extensors and, in turn, to all others.
    frequency_hz: the patient's.
    spread_hz: how far its components lie from it, sd.
    muscles: names of those that tremble; empty: all.
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
        """As the `muscles` block takes it."""
        return MuscleTremor(activation=self.activation, band_hz=(self.frequency_hz, self.frequency_hz),
                            spread_hz=self.spread_hz, muscles=self.muscles)
