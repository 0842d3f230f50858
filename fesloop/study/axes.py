"""Axes of a study: what is varied, and over which levels."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Literal

from fesloop.errors import InputError
from fesloop.experiment.toml_text import toml_value

LevelValue = float | int | str | bool
_MOST_LEVELS = 10**12
_DIGITS = 12
"""Levels between two ends are rounded to so many, or tenths would be told as 0.30000000000000004."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Level:
    """A place on an axis.

    Attributes
    ----------
    value: by which tables and figures name it.
    settings: that make it, as of `fesloop run --set`.
    experiment: that takes the base's place; None: the base.
    """

    value: LevelValue
    settings: tuple[str, ...]
    experiment: str | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Option:
    """A level with a name: some settings, and if wanted another experiment."""

    settings: tuple[str, ...] = ()
    experiment: str | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Cohort:
    """Members of a cohort of patients: `members` of them, from number `first` on."""

    patient: str
    members: int
    cohort: int = 0
    first: int = 0

    def __post_init__(self) -> None:
        if self.members < 1:
            raise InputError("members", f"{self.members}", "1 or more")


@dataclass(frozen=True, slots=True, kw_only=True)
class Axis:
    """One thing that is varied: over values of a key, over named options, or over patients.

    Attributes
    ----------
    key: that is set, as of `fesloop run --set`, or several that are set alike; empty: the axis's name.
    values: levels of the key.
    start, stop, count: instead, so many levels from one number to another (`from`, `to` in files); a design
        that draws points takes any number between, and no count.
    scale: how they are spaced.
    options: instead, named levels of some settings each.
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
        """Whether it is a span of numbers."""
        return self.start is not None

    def faults(self, name: str, *, sampled: bool) -> Iterator[InputError]:
        """What is wrong with it, named by its keys; `sampled`: whether a design draws points."""
        given = [key for key, there in (("values", self.values), ("from", self.start is not None),
                                        ("options", self.options), ("cohort", self.cohort is not None))
                 if there]
        if len(given) != 1:
            yield InputError(given[1] if given else "values", "stands beside " + given[0] if given
                             else "is missing", "one of values, from and to, options, cohort")
        if self.key and (self.options or self.cohort):
            yield InputError("key", "stands beside options or cohort, which set keys of their own",
                             "values, or from and to", "remove it")
        if len(set(map(repr, self.values))) < len(self.values):
            yield InputError("values", "the same value more than once", "each once")
        yield from self._faults_of_span(sampled)
        if any(key.split("=")[0].strip() in ("experiment.seed", "seed") for key in self.keys(name)):
            yield InputError("key", "the seed", "any other key",
                             "runs with other seeds are study.replicates")

    def _faults_of_span(self, sampled: bool) -> Iterator[InputError]:
        if self.start is None:
            for key, value in (("to", self.stop), ("count", self.count)):
                if value is not None:
                    yield InputError(key, "is given without from", "from, to and count")
            return
        if self.stop is None or not (math.isfinite(self.start) and math.isfinite(self.stop)
                                     and self.start < self.stop):
            yield InputError("to", "is missing" if self.stop is None else f"{self.stop:g}",
                             f"a number above from, {self.start:g}")
        if self.scale == "log" and self.start <= 0.0:
            yield InputError("from", f"{self.start:g}", 'a number above 0, for scale = "log"')
        if sampled and self.count is not None:
            yield InputError("count", f"{self.count}", "none, for a design that draws points", "remove it")
        if not sampled and (self.count is None or not 2 <= self.count <= _MOST_LEVELS):
            yield InputError("count", "is missing" if self.count is None else f"{self.count}",
                             "2 or more levels")

    def keys(self, name: str) -> tuple[str, ...]:
        """The keys that are set."""
        if self.options or self.cohort:
            return ()
        return ((self.key,) if isinstance(self.key, str) else self.key) or (name,)

    def count_of_levels(self, name: str) -> int:
        """How many there are, without making them."""
        if self.continuous:
            return self.count or 1
        if self.cohort is not None:
            return self.cohort.members
        return len(self.options) or len(self.values)

    def level(self, name: str, number: int) -> Level:
        """One of a grid's levels."""
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

    def drawn(self, name: str, share: float) -> Level:
        """The level at a number of [0, 1) of a design that draws points."""
        if self.continuous:
            return self._of_value(name, self._between(share))
        return self.level(name, int(share * self.count_of_levels(name)))

    def _between(self, share: float) -> float:
        assert self.start is not None
        assert self.stop is not None
        if self.scale == "log":
            value = self.start * (self.stop / self.start) ** share
        else:
            value = self.start + share * (self.stop - self.start)
        return float(f"{value:.{_DIGITS}g}")

    def _of_value(self, name: str, value: LevelValue) -> Level:
        return Level(value=value, settings=tuple(f"{key}={toml_value(value)}" for key in self.keys(name)))

    def _member(self, cohort: Cohort, number: int) -> Level:
        return Level(value=number, settings=(f"patient.file={toml_value(cohort.patient)}",
                                             f"patient.cohort={cohort.cohort}", f"patient.member={number}"))
