"""How patients of one kind differ, and one patient's days, as a patient's file states it."""

from __future__ import annotations

from dataclasses import dataclass, fields

from plants.patients.limits import refuse, spread_limits


@dataclass(frozen=True, slots=True, kw_only=True)
class CohortSpread:
    """Standard deviations between patients of one kind; 0: all have the preset's number.

    Attributes
    ----------
    hand_mm, forearm_radius_mm: mm. delay_ms: ms. tremor_hz: Hz. voluntary: of the greatest efforts above 0.
    denervated: of the shares above 0. All others are of logarithms:
    strength, muscle_strength: of all muscles together, and further of each for itself.
    threshold, muscle_threshold: likewise.
    natural, endurance, mcp, spasticity: speed, endurance, MCP stiffness, reflex gain.
    """

    hand_mm: float = 0.0
    forearm_radius_mm: float = 0.0
    strength: float = 0.0
    muscle_strength: float = 0.0
    denervated: float = 0.0
    threshold: float = 0.0
    muscle_threshold: float = 0.0
    delay_ms: float = 0.0
    natural: float = 0.0
    endurance: float = 0.0
    voluntary: float = 0.0
    mcp: float = 0.0
    spasticity: float = 0.0
    tremor_hz: float = 0.0

    def __post_init__(self) -> None:
        refuse("cohort", self, spread_limits(tuple(each.name for each in fields(self))))


@dataclass(frozen=True, slots=True, kw_only=True)
class DaySpread:
    """Standard deviations between one patient's days; 0: no day differs.

    Attributes
    ----------
    along_mm, around_deg: of the arrays' place, mm and deg. delay_ms: ms. All others are of logarithms:
    skin, element: share of the current that passes, of all elements together and of each for itself.
    strength, threshold, endurance, spasticity: as in a cohort.
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

    def __post_init__(self) -> None:
        refuse("day", self, spread_limits(tuple(each.name for each in fields(self))))
