"""A study: a base experiment, axes along which it is varied, and what is kept of each run."""

from __future__ import annotations

import math
import statistics
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from fesloop.analysis.study.design.axes import Axis, seed_fault, sets_seed
from fesloop.analysis.study.design.figure_specs import OWN_COLUMNS, Figure
from fesloop.errors import InputError, InputErrors, did_you_mean

_REDUCTIONS: dict[str, Callable[[Sequence[float]], float]] = {
    "first": lambda values: values[0], "last": lambda values: values[-1], "mean": statistics.fmean,
    "median": statistics.median, "min": min, "max": max}


@dataclass(frozen=True, slots=True)
class KeptMetric:
    """A number that is kept.

    Attributes
    ----------
    name: under which it is kept.
    path: where it stands in a run's metrics.
    reduction: what is taken of a list.
    """

    name: str
    path: tuple[str, ...]
    reduction: str = "last"

    @classmethod
    def parse(cls, name: str, text: str) -> KeptMetric:
        """From a study file's text. Raises InputError for a reduction that is not there."""
        path, _, reduction = text.partition(":")
        if reduction and reduction not in _REDUCTIONS:
            raise InputError(f"metrics.{name}", f"{text!r} asks for {reduction!r} of a list",
                             ", ".join(_REDUCTIONS), did_you_mean(reduction, _REDUCTIONS))
        if not all(path.split(".")):
            raise InputError(f"metrics.{name}", f"{text!r}", "a path such as joints.MCP.joint_rmse_deg")
        return cls(name, tuple(path.split(".")), reduction or "last")

    def of(self, metrics: Mapping[str, Any]) -> float | None:
        """The number; None where the run has it not, or not a finite one.

        Raises InputError where the path leads to no number in what the run has.
        """
        value: Any = metrics
        for depth, part in enumerate(self.path):
            if not isinstance(value, Mapping) or part not in value:
                known = list(value) if isinstance(value, Mapping) else []
                raise InputError(f"study.metrics.{self.name}",
                                 f"a run has no metric {'.'.join(self.path[:depth + 1])!r}",
                                 ", ".join(map(str, known)), did_you_mean(part, map(str, known)))
            value = value[part]
        if isinstance(value, (list, tuple)):
            numbers = [self._number(item) for item in value]
            finite = [number for number in numbers if number is not None]
            if len(finite) < len(numbers) or not finite:
                return self._end(numbers)
            return float(_REDUCTIONS[self.reduction](finite))
        return self._number(value)

    def _end(self, numbers: Sequence[float | None]) -> float | None:
        """Of a list that is not all numbers: its first or last, if that is asked for."""
        ends = {"first": 0, "last": -1}
        return numbers[ends[self.reduction]] if numbers and self.reduction in ends else None

    def _number(self, value: Any) -> float | None:
        if value is None:
            return None
        if not isinstance(value, (bool, int, float)):
            raise InputError(f"study.metrics.{self.name}", f"{'.'.join(self.path)!r} is no number",
                             "a number, or a list of numbers, one a trial",
                             "go on to one below it" if isinstance(value, Mapping) else "")
        return float(value) if math.isfinite(value) else None


Design = Literal["grid", "random", "sobol"]
Recordings = Literal["none", "failed", "all"]
MOST_RUNS = 1_000_000
"""A plan is held in memory and in one file (chosen: some hundred MB)."""
_GREATEST_SEED = 2**62
_LONGEST_NAME = 60


def is_name(text: str) -> bool:
    """Whether a study or a form may have this name: a folder is called by it."""
    return text.replace("_", "a").replace("-", "a").isalnum() and len(text) <= _LONGEST_NAME


@dataclass(frozen=True, slots=True, kw_only=True)
class About:
    """The table [study] of a study file.

    Attributes
    ----------
    name: of the study; its results stand in a folder of this name.
    experiment: that is varied: name of a shipped one, or a path, seen from the study file.
    settings: of every run, as of `fesloop run --set`.
    replicates: runs of each cell; replicate r has the seed `seed` + r in every cell, so that what is random
        is the same in all cells (common random numbers), and what differs is the cell.
    design: how cells are laid over the axes: each with each, or `samples` points, independent or of a Sobol
        sequence, drawn by `seed`.
    recordings: which recordings are kept beside the results.
    metrics: what is kept of a run: name to path in its metrics
    (`fesloop.analysis.study.design.study`).
    """

    name: str
    experiment: str
    description: str = ""
    settings: tuple[str, ...] = ()
    replicates: int = 1
    seed: int = 1
    design: Design = "grid"
    samples: int = 0
    recordings: Recordings = "none"
    metrics: dict[str, str]

    def __post_init__(self) -> None:
        if not is_name(self.name):
            raise InputError("name", f"{self.name[:_LONGEST_NAME]!r}",
                             f"letters, digits, - and _, at most {_LONGEST_NAME}")
        if self.replicates < 1:
            raise InputError("replicates", f"{self.replicates}", "1 or more")
        if not 0 <= self.seed <= _GREATEST_SEED:
            raise InputError("seed", f"{self.seed}", f"an integer, 0 or more, at most {_GREATEST_SEED}")
        if self.design == "grid" and self.samples:
            raise InputError("samples", f"{self.samples} in a grid, which has as many cells as its axes give",
                             "none", 'remove it, or take design = "random" or "sobol"')
        if self.design != "grid" and self.samples < 1:
            raise InputError("samples", f"{self.samples}", "1 or more", "say how many points are drawn")
        if not self.metrics:
            raise InputError("metrics", "there is none", 'one or more, such as error_deg = "joint_rmse_deg"')


@dataclass(frozen=True, slots=True, kw_only=True)
class Preparation:
    """An experiment that is run and identified before others can be, once for each patient.

    Attributes
    ----------
    experiment: that excites the patient, such as identify_grasp.
    settings: of it, as of `fesloop run --set`.
    axes: whose settings it takes over: those that tell patients apart.
    meanwhile: settings that stand in for the model while the study is checked.
    """

    experiment: str
    settings: tuple[str, ...] = ()
    axes: tuple[str, ...] = ()
    meanwhile: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Study:
    """A study, checked as far as it can be without its experiments.

    Attributes
    ----------
    about: the table [study].
    axes: by name, in the order of the file.
    prepare: settings that come out of an experiment of their own, by key.
    figures: drawn when it ends.
    form, cost: which form of the file this is, "" for the file itself, and what it costs.
    folder: that paths start from; None for a shipped study.
    try_next: commands that go on from it, for people.
    document: its tables but for [guide], settled, as a file of it would say.

    Raises InputErrors naming every fault.
    """

    about: About
    axes: Mapping[str, Axis]
    prepare: Mapping[str, Preparation] = field(default_factory=dict)
    figures: tuple[Figure, ...] = ()
    form: str = ""
    cost: str = ""
    folder: Path | None = None
    try_next: tuple[str, ...] = ()
    document: Mapping[str, Any]

    def __post_init__(self) -> None:
        faults = [seed_fault("study.settings") for each in self.about.settings if sets_seed(each)]
        faults += [*self._faults_of_axes(), *self._faults_of_metrics()]
        for number, figure in enumerate(self.figures):
            where = f"figures[{number}]"
            faults += [InputError(f"{where}.{fault.where}", fault.found, fault.allowed, fault.remedy)
                       for fault in figure.faults(tuple(self.axes), tuple(self.about.metrics))]
            if figure.theory != "none" and figure.x in self.axes and not self.axes[figure.x].numeric:
                faults.append(InputError(f"{where}.theory", f"{figure.x} is no axis of numbers",
                                         "an x that is one", 'take theory = "none"'))
            first = [each.name for each in self.figures].index(figure.name)
            if first < number:
                faults.append(InputError(f"{where}.name", f"{figure.name!r} is that of figures[{first}] too",
                                         "a name of its own: it names a file"))
        if not faults and self.runs > MOST_RUNS:
            cells = self.runs // self.about.replicates
            faults.append(InputError("axes", f"{cells:,} cells x {self.about.replicates} replicates",
                                     f"at most {MOST_RUNS:,} runs",
                                     'take fewer levels, or design = "sobol" with samples'))
        if faults:
            raise InputErrors(faults)

    def _faults_of_axes(self) -> list[InputError]:
        reserved = {*OWN_COLUMNS, *self.about.metrics}
        faults = [InputError(f"axes.{name}", "is a column of every table of results", "another name",
                             "rename it, and give it a key") for name in self.axes if name in reserved]
        for name, axis in self.axes.items():
            faults += [InputError(f"axes.{name}.{fault.where}", fault.found, fault.allowed, fault.remedy)
                       for fault in axis.faults(name, sampled=self.about.design != "grid")]
        owners: dict[str, str] = {}
        for name, axis in self.axes.items():
            faults += [InputError(f"axes.{name}.key", f"{key!r} is that of axis {owners[key]!r} too",
                                  "a key that no other axis sets")
                       for key in axis.keys(name) if key in owners]
            owners |= dict.fromkeys(axis.keys(name), name)
        patients = [name for name, axis in self.axes.items() if axis.cohort is not None]
        faults += [InputError(f"axes.{name}.cohort", f"patients are those of axis {patients[0]!r} already",
                              "one axis that is a cohort", "make the cohorts two studies, or named options")
                   for name in patients[1:]]
        for key, preparation in self.prepare.items():
            faults += [InputError(f"prepare.{key}.axes", f"there is no axis {axis!r}",
                                  ", ".join(self.axes) or "none")
                       for axis in preparation.axes if axis not in self.axes]
        return faults

    def _faults_of_metrics(self) -> list[InputError]:
        faults = [InputError(f"study.metrics.{name}", "is a column of every table of results", "another name")
                  for name in self.about.metrics if name in OWN_COLUMNS]
        for name, path in self.about.metrics.items():
            try:
                KeptMetric.parse(name, path)
            except InputError as fault:
                faults.append(InputError(f"study.metrics.{name}", fault.found, fault.allowed, fault.remedy))
        return faults

    @property
    def name(self) -> str:
        """Of the study in this form."""
        return f"{self.about.name}-{self.form}" if self.form else self.about.name

    @property
    def cells(self) -> int:
        """How many."""
        if self.about.design != "grid":
            return self.about.samples
        count = 1
        for name, axis in self.axes.items():
            count *= axis.count_of_levels(name)
        return count

    @property
    def runs(self) -> int:
        """How many are planned."""
        return self.cells * self.about.replicates

    @property
    def metrics(self) -> tuple[KeptMetric, ...]:
        """What is kept of each run."""
        return tuple(KeptMetric.parse(name, path) for name, path in self.about.metrics.items())

    def experiment(self, name: str) -> str:
        """Name of a shipped experiment, or the path of a file, as seen from here."""
        is_path = name.endswith((".toml", ".h5")) or "/" in name
        return str(self.folder / name) if is_path and self.folder is not None else name
