"""Axes of a study: the varied keys, and their levels."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Literal

from fesloop.errors import InputError
from fesloop.experiment.files.overlay import key_parts
from fesloop.forms.toml import toml_value

LevelValue = float | int | str | bool
_DIGITS = 12
"""Significant digits of levels between two ends, so that tenths do not read 0.30000000000000004."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Level:
    """A level of an axis.

    Attributes
    ----------
    value: its name in tables and figures.
    settings: of the level, as for `fesloop run --set`.
    experiment: replaces the base experiment; None: the base.
    """

    value: LevelValue
    settings: tuple[str, ...]
    experiment: str | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Option:
    """A named level: settings, and optionally another experiment."""

    settings: tuple[str, ...] = ()
    experiment: str | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Cohort:
    """Patients of a cohort: `members` of them, starting at number `first`.

    Attributes
    ----------
    patient: preset or file; "": that of another axis or of the study's settings.
    members, first, cohort: how many, from which number on, and of which cohort.
    day: the day of each; None: none.
    """

    members: int
    patient: str = ""
    cohort: int = 0
    first: int = 0
    day: int | None = None

    def __post_init__(self) -> None:
        if self.members < 1:
            raise InputError("members", f"{self.members}", "1 or more")


@dataclass(frozen=True, slots=True, kw_only=True)
class Axis:
    """A dimension along which a study varies: values of a key, named options, or patients.

    Attributes
    ----------
    key: the key to set, as for `fesloop run --set`, or several keys set to the same value; empty: the axis's
        name.
    values: levels of the key.
    start, stop, count: instead, `count` levels from one number to another (`from`, `to` in files); a random
        or Sobol design takes any number between, and no count.
    scale: spacing of these levels.
    options: instead, named levels with settings.
    cohort: instead, patients.
    label, unit: for figures.
    """

    key: str | tuple[str, ...] = ()
    values: tuple[LevelValue, ...] = ()
    start: float | None = None
    stop: float | None = None
    count: int | None = None
    scale: Literal["linear", "log"] = "linear"
    options: dict[str, Option] = field(default_factory=dict)
    cohort: Cohort | None = None
    label: str = ""
    unit: str = ""

    @property
    def continuous(self) -> bool:
        """Whether the axis is a span of numbers."""
        return self.start is not None

    @property
    def numeric(self) -> bool:
        """Whether the levels are numbers."""
        return not self.options and all(type(value) in (int, float) for value in self.values)

    def faults(self, name: str, *, sampled: bool) -> Iterator[InputError]:
        """Faults of the axis, each at its key; `sampled`: whether the design draws points."""
        given = [key for key, there in (("values", self.values), ("from", self.start is not None),
                                        ("options", self.options), ("cohort", self.cohort is not None))
                 if there]
        if len(given) != 1:
            yield InputError(given[1] if given else "values", f"is given as well as {given[0]}" if given
                             else "is missing or empty", "one of values, from and to, options, cohort")
        if self.key and (self.options or self.cohort):
            yield InputError("key", "is given as well as options or cohort, which set keys of their own",
                             "values, or from and to", "remove it")
        if len(set(self.values)) < len(self.values):
            yield InputError("values", "the same value more than once", "each once")
        for value in self.values:
            if isinstance(value, float) and not math.isfinite(value):
                yield InputError("values", f"{value:g}", "finite numbers, text, true and false",
                                 "make it one of named options")
        yield from self._faults_of_span(sampled)
        yield from self._faults_of_keys(name)

    def _faults_of_keys(self, name: str) -> Iterator[InputError]:
        for key in self.keys(name):
            if "=" in key:
                yield InputError("key", f"{key!r} has a value", "a key alone", "give the value in values")
            elif sets_seed(key):
                yield seed_fault("key")
        for option, chosen in self.options.items():
            yield from (seed_fault(f"options.{option}.settings") for each in chosen.settings
                        if sets_seed(each))

    def _faults_of_span(self, sampled: bool) -> Iterator[InputError]:
        if self.start is None:
            for key, value in (("to", self.stop), ("count", self.count)):
                if value is not None:
                    yield InputError(key, "is given without from", "from, to and count")
            return
        if not math.isfinite(self.start):
            yield InputError("from", f"{self.start:g}", "a finite number")
        elif self.stop is None or not self.start < self.stop < math.inf:
            yield InputError("to", "is missing" if self.stop is None else f"{self.stop:g}",
                             f"a finite number above from, {self.start:g}")
        if self.scale == "log" and self.start <= 0.0:
            yield InputError("from", f"{self.start:g}", 'a number above 0, for scale = "log"')
        if sampled and self.count is not None:
            yield InputError("count", f"{self.count}", "none, for a design that draws points", "remove it")
        if not sampled and (self.count is None or self.count < 2):
            yield InputError("count", "is missing" if self.count is None else f"{self.count}",
                             "2 or more levels")

    def keys(self, name: str) -> tuple[str, ...]:
        """The keys that the axis sets."""
        if self.options or self.cohort:
            return ()
        return ((self.key,) if isinstance(self.key, str) else self.key) or (name,)

    def count_of_levels(self, name: str) -> int:
        """Number of levels, without making them."""
        if self.continuous:
            return self.count or 1
        if self.cohort is not None:
            return self.cohort.members
        return len(self.options) or len(self.values)

    def level(self, name: str, number: int) -> Level:
        """A level of a grid, by its number."""
        if self.options:
            option = list(self.options)[number]
            return Level(value=option, settings=self.options[option].settings,
                         experiment=self.options[option].experiment)
        if self.cohort is not None:
            return self._member(self.cohort, self.cohort.first + number)
        if self.continuous:
            assert self.count is not None
            return self._of_value(name, self._between(number / (self.count - 1)))
        return self._of_value(name, self.values[number])

    def sampled(self, name: str, share: float) -> Level:
        """The level at a number of [0, 1), of a random or Sobol design."""
        if self.continuous:
            return self._of_value(name, self._between(share))
        return self.level(name, int(share * self.count_of_levels(name)))

    def _between(self, share: float) -> float:
        assert self.start is not None
        assert self.stop is not None
        if self.scale == "log":
            value = math.exp((1.0 - share) * math.log(self.start) + share * math.log(self.stop))
        else:
            value = (1.0 - share) * self.start + share * self.stop
        return min(self.stop, max(self.start, float(f"{value:.{_DIGITS}g}")))

    def _of_value(self, name: str, value: LevelValue) -> Level:
        return Level(value=value, settings=tuple(f"{key}={toml_value(value)}" for key in self.keys(name)))

    def _member(self, cohort: Cohort, number: int) -> Level:
        settings = [f"patient.cohort={cohort.cohort}", f"patient.member={number}"]
        if cohort.patient:
            settings.insert(0, f"patient.file={toml_value(cohort.patient)}")
        if cohort.day is not None:
            settings.append(f"patient.day={cohort.day}")
        return Level(value=number, settings=tuple(settings))


def sets_seed(setting: str) -> bool:
    """Whether a key, or a setting, sets the experiment's seed."""
    return key_parts(setting.partition("=")[0].strip()) in (["experiment", "seed"], ["seed"])


def seed_fault(where: str) -> InputError:
    """The error for a setting of the seed, which the study itself sets."""
    return InputError(where, "sets the seed, which study.seed and replicates determine", "any other key",
                      "runs with other seeds are study.replicates")
