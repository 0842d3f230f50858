"""One patient: all that the blocks between stimulator and skeleton are told of a person."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, cast

from fesloop.errors import InputError, InputErrors
from fesloop.forms.schema import plain
from fesloop.hand.anthropometry import HandSize
from plants.patients import blocks as patient_blocks
from plants.patients.sections import (
    Anthropometry,
    Fatigue,
    MuscleDynamics,
    Passive,
    Placement,
    Recruitment,
    Spasticity,
    Strength,
    Tolerance,
    Tremor,
    Voluntary,
)
from plants.patients.spreads import CohortSpread, DaySpread
from plants.patients.variation import member_of, on_day_of

GREATEST_NUMBER = 2**31 - 1
"""Of cohorts, members and days (chosen)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Patient:
    """A person, in domain terms. A preset is the middle of its kind; `member` and `on_day` draw from there.

    Attributes
    ----------
    name: of the preset, and of whom was drawn from it: "sci_c6", "sci_c6.1.3" (cohort 1, member 3),
        "sci_c6.1.3 day 2". Draws depend on it.
    description: for people.
    anthropometry, strength, recruitment, muscle, voluntary, passive, placement: what is not said is as in an
        able-bodied adult.
    tolerance: what the patient may be given, where that is less than the `safety` block allows.
    fatigue, spasticity, tremor: None for a patient without.
    cohort, day: how patients of this kind differ, and the days of this one; None once drawn.

    Raises InputErrors naming all that contradicts itself.
    """

    name: str
    description: str = ""
    anthropometry: Anthropometry = field(default_factory=Anthropometry)
    strength: Strength = field(default_factory=Strength)
    recruitment: Recruitment = field(default_factory=Recruitment)
    muscle: MuscleDynamics = field(default_factory=MuscleDynamics)
    fatigue: Fatigue | None = None
    voluntary: Voluntary = field(default_factory=Voluntary)
    passive: Passive = field(default_factory=Passive)
    spasticity: Spasticity | None = None
    tremor: Tremor | None = None
    placement: Placement = field(default_factory=Placement)
    tolerance: Tolerance = field(default_factory=Tolerance)
    cohort: CohortSpread | None = None
    day: DaySpread | None = None

    def __post_init__(self) -> None:
        faults = list(self._contradictions())
        if faults:
            raise InputErrors(faults)

    @property
    def hand_size(self) -> HandSize:
        """What trackers and other blocks that know the hand are told."""
        return self.anthropometry.size

    def hand(self) -> dict[str, Any]:
        """Parameters of the `hand` and the `myohand` plant."""
        return patient_blocks.hand(self)

    def muscles(self, model: str = "") -> dict[str, Any]:
        """Parameters of the `muscles` plant, its model in place of the patient's where it is named."""
        return patient_blocks.muscles(self, model)

    def electrodes(self, elements: int = 59) -> dict[str, Any]:
        """Parameters of the `electrodes` block with that many elements."""
        return patient_blocks.electrodes(self, elements)

    def parameters(self, kind: str, own: Mapping[str, Any]) -> dict[str, Any]:
        """Plain parameters of a block of that kind, of which an experiment file itself says `own`."""
        return patient_blocks.table_of(self, kind, own)

    def table(self) -> dict[str, Any]:
        """Plain tables of the patient's file."""
        return cast("dict[str, Any]", plain(self))

    def _contradictions(self) -> Iterator[InputError]:
        if not self.name:
            yield InputError("name", "is empty", "a name: draws depend on it")
        dead = {name for name, share in self.strength.denervated.items() if share >= 1.0}
        alive = "a muscle with some nerve left, see strength.denervated"
        for name in sorted(dead.intersection(self.spasticity.muscles if self.spasticity else ())):
            yield InputError("spasticity.muscles", f"{name} is wholly denervated: it has no reflex", alive)
        for name in sorted(dead.intersection(self.tremor.muscles if self.tremor else ())):
            yield InputError("tremor.muscles", f"{name} is wholly denervated: it cannot tremble", alive)
        for name in sorted(dead):
            if self.voluntary.muscles.get(name, 0.0) > 0.0:
                yield InputError(f"voluntary.muscles.{name}", "is moved at will, but wholly denervated",
                                 alive)
        if self.spasticity and not (self.spasticity.gain_s and self.spasticity.limit):
            yield InputError("spasticity", "a reflex that drives nothing", "gain_s and limit above 0",
                             "leave the section out for a patient without")

    def member(self, *, cohort: int, number: int) -> Patient:
        """One of the patients of this kind: the same for the same cohort and number, whoever else is drawn.

        Raises InputError for one who was drawn already, or of whose kind no differences are stated.
        """
        _require_number("cohort", cohort)
        _require_number("member", number)
        if self.cohort is None:
            raise InputError(self.name, "states no [cohort] from which members could be drawn", "a preset",
                             "add the table, empty if all are alike")
        drawn = member_of(self, self.cohort, cohort, number)
        return replace(drawn, name=f"{self.name}.{cohort}.{number}", cohort=None)

    def on_day(self, number: int) -> Patient:
        """The patient on one day: electrodes, skin and condition of that day.

        Raises InputError where a day was drawn already, or no differences are stated.
        """
        _require_number("day", number)
        if self.day is None:
            raise InputError(self.name, "states no [day] from which days could be drawn", "such a patient",
                             "add the table, empty if all are alike")
        return replace(on_day_of(self, self.day, number), name=f"{self.name} day {number}",
                       cohort=None, day=None)


def _require_number(key: str, number: int) -> None:
    if not 0 <= number <= GREATEST_NUMBER:
        raise InputError(key, f"{number}", f"0 to {GREATEST_NUMBER}")
