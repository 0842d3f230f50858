"""A study: a base experiment, the axes along which it varies, and the kept metrics of each run."""

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
    """A number that a study keeps of each run.

    Attributes
    ----------
    name: of the number in the study.
    path: keys of the number in a run's metrics.
    reduction: of a list to a number.
    optional: whether some runs do not have it.
    """

    name: str
    path: tuple[str, ...]
    reduction: str = "last"
    optional: bool = False

    @classmethod
    def parse(cls, name: str, text: str) -> KeptMetric:
        """Parse the text of a study file. Raises InputError for an unknown reduction."""
        path, _, reduction = text.partition(":")
        if reduction and reduction not in _REDUCTIONS:
            raise InputError(f"metrics.{name}", f"{text!r}: unknown reduction {reduction!r}",
                             ", ".join(_REDUCTIONS), did_you_mean(reduction, _REDUCTIONS))
        optional, path = path.endswith("?"), path.removesuffix("?")
        if not all(path.split(".")):
            raise InputError(f"metrics.{name}", f"{text!r}", "a path such as joints.MCP.joint_rmse_deg")
        return cls(name, tuple(path.split(".")), reduction or "last", optional)

    def of(self, metrics: Mapping[str, Any]) -> float | None:
        """The number in a run's metrics; None where it is missing or not finite.

        Raises InputError where the path does not lead to a number, and is not optional.
        """
        value: Any = metrics
        for depth, part in enumerate(self.path):
            if self.optional and isinstance(value, Mapping) and part not in value:
                return None
            if not isinstance(value, Mapping) or part not in value:
                known = [str(key) for key in value] if isinstance(value, Mapping) else []
                containing = [key for key in known if part in key]
                raise InputError(f"study.metrics.{self.name}",
                                 f"a run has no metric {'.'.join(self.path[:depth + 1])!r}",
                                 ", ".join(known), did_you_mean(part, known) or (
                                     f"did you mean {' or '.join(map(repr, containing[:3]))}?"
                                     if containing else ""))
            value = value[part]
        if isinstance(value, (list, tuple)):
            numbers = [self._number(item) for item in value]
            finite = [number for number in numbers if number is not None]
            if len(finite) < len(numbers) or not finite:
                return self._end(numbers)
            return float(_REDUCTIONS[self.reduction](finite))
        return self._number(value)

    def _end(self, numbers: Sequence[float | None]) -> float | None:
        """First or last of a list with missing numbers, if that is the reduction; else None."""
        ends = {"first": 0, "last": -1}
        return numbers[ends[self.reduction]] if numbers and self.reduction in ends else None

    def _number(self, value: Any) -> float | None:
        if value is None:
            return None
        if not isinstance(value, (bool, int, float)):
            raise InputError(f"study.metrics.{self.name}", f"{'.'.join(self.path)!r} is not a number",
                             "a number, or a list of numbers, one per trial",
                             "name one below it" if isinstance(value, Mapping) else "")
        return float(value) if math.isfinite(value) else None


Design = Literal["grid", "random", "sobol"]
Recordings = Literal["none", "failed", "all"]
MOST_RUNS = 1_000_000
"""Most runs of a study, whose plan is in memory and in one file (chosen: some hundred MB)."""
_GREATEST_SEED = 2**62
_LONGEST_NAME = 60


def is_name(text: str) -> bool:
    """Whether a study or a form may have this name, which also names a folder."""
    return text.replace("_", "a").replace("-", "a").isalnum() and len(text) <= _LONGEST_NAME


@dataclass(frozen=True, slots=True, kw_only=True)
class About:
    """The table [study] of a study file.

    Attributes
    ----------
    name: of the study, and of the folder of its results.
    experiment: name of a shipped base experiment, or a path relative to the study file.
    settings: of every run, as for `fesloop run --set`.
    replicates: runs of each cell; replicate r has the seed `seed` + r in every cell, so that all cells have
        the same noise (common random numbers), and differences are those of the cells.
    design: cells over the axes: all combinations of levels (grid), or `samples` points, independent or of a
        Sobol sequence, from `seed`.
    recordings: recordings to keep besides the results.
    metrics: kept metrics: name to path in a run's metrics (`KeptMetric`).
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
            raise InputError("samples", f"{self.samples}", "1 or more", "give the number of points")
        if not self.metrics:
            raise InputError("metrics", "there is none", 'one or more, such as error_deg = "joint_rmse_deg"')


@dataclass(frozen=True, slots=True, kw_only=True)
class Preparation:
    """An experiment from which a model is identified before other runs, once for each patient.

    Attributes
    ----------
    experiment: excites the patient, such as identify_grasp.
    experiments: others in its place, by the experiment of the runs that need the model.
    settings: of this experiment, as for `fesloop run --set`.
    axes: axes whose settings apply to it: those that select patients.
    meanwhile: settings that stand in for the model while the study is checked.
    """

    experiment: str
    experiments: Mapping[str, str] = field(default_factory=dict)
    settings: tuple[str, ...] = ()
    axes: tuple[str, ...] = ()
    meanwhile: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Study:
    """A study, checked as far as possible without its experiments.

    Attributes
    ----------
    about: the table [study].
    axes: by name, in the order of the file.
    prepare: preparations, by the key that takes the model.
    figures: drawn when the study ends.
    form, cost: form of the file, "" for the file itself, and its cost in words.
    folder: start of relative paths; None for a shipped study.
    experiments: documents of experiments that were given as objects, by the names that stand for them.
    try_next: suggested next commands.
    document: all tables but [guide], in this form.

    Raises InputErrors naming every fault.
    """

    about: About
    axes: Mapping[str, Axis]
    prepare: Mapping[str, Preparation] = field(default_factory=dict)
    figures: tuple[Figure, ...] = ()
    form: str = ""
    cost: str = ""
    folder: Path | None = None
    experiments: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
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
                faults.append(InputError(f"{where}.theory", f"{figure.x} is not an axis of numbers",
                                         "a numeric x", 'take theory = "none"'))
            first = [each.name for each in self.figures].index(figure.name)
            if first < number:
                faults.append(InputError(
                    f"{where}.name", f"{figure.name!r} is also the name of figures[{first}]",
                    "another name, as it names a file"))
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
            faults += [InputError(f"axes.{name}.key", f"axis {owners[key]!r} sets {key!r} as well",
                                  "a key that no other axis sets")
                       for key in axis.keys(name) if key in owners]
            owners |= dict.fromkeys(axis.keys(name), name)
        patients = [name for name, axis in self.axes.items() if axis.cohort is not None]
        faults += [InputError(f"axes.{name}.cohort", f"axis {patients[0]!r} is a cohort as well",
                              "one cohort", "make the cohorts two studies, or named options")
                   for name in patients[1:]]
        for key, preparation in self.prepare.items():
            faults += [InputError(f"prepare.{key}.axes", f"there is no axis {axis!r}",
                                  ", ".join(self.axes) or "none")
                       for axis in preparation.axes if axis not in self.axes]
            runs = [self.about.experiment, *(option.experiment for axis in self.axes.values()
                                             for option in axis.options.values() if option.experiment)]
            faults += [InputError(f"prepare.{key}.experiments", f"no run is of {name!r}", ", ".join(runs),
                                  did_you_mean(name, runs))
                       for name in preparation.experiments if name not in runs]
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
        """Name of the study in this form."""
        return f"{self.about.name}-{self.form}" if self.form else self.about.name

    @property
    def cells(self) -> int:
        """Number of cells."""
        if self.about.design != "grid":
            return self.about.samples
        count = 1
        for name, axis in self.axes.items():
            count *= axis.count_of_levels(name)
        return count

    @property
    def runs(self) -> int:
        """Number of planned runs."""
        return self.cells * self.about.replicates

    @property
    def metrics(self) -> tuple[KeptMetric, ...]:
        """Kept metrics of each run."""
        return tuple(KeptMetric.parse(name, path) for name, path in self.about.metrics.items())

    def prepared_by(self, preparation: Preparation, experiment: str) -> str:
        """Name or path of the experiment that prepares the runs of one."""
        others = {self.experiment(run): other for run, other in preparation.experiments.items()}
        return self.experiment(others.get(experiment, preparation.experiment))

    def experiment(self, name: str) -> str:
        """Name of a shipped experiment, or path of a file relative to the working directory."""
        is_path = name.endswith((".toml", ".h5")) or "/" in name
        return str(self.folder / name) if is_path and self.folder is not None else name
