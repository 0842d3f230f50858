"""What an injury has left and brought: effort, stiffness, reflexes, tremor; a section of the file a class."""

from __future__ import annotations

from dataclasses import dataclass, field

from fesloop.errors import InputError
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.skeleton import hand_tree
from plants.hand.joints import require_in_range, resting_posture
from plants.muscles.patient_drive import MuscleTremor, StretchReflex, chosen
from plants.patients.limits import LIMITS, refuse


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
