"""Plan of a study: each cell resolved into an experiment, whose hash names its runs."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from fesloop.analysis.study.design.cells import Cell, cells_of, covering
from fesloop.analysis.study.design.study import Study
from fesloop.errors import InputError, InputErrors
from fesloop.experiment.files.parse import from_document, read
from fesloop.experiment.files.settings import apply_settings
from fesloop.experiment.files.variants import pick
from fesloop.experiment.running import Experiment
from fesloop.loop.clock import NS_PER_S
from fesloop.loop.realtime import is_live

_MOST_FAULTS = 10
_SETTING = "--set "

Settings = Callable[[Cell], tuple[str, ...]]
"""Settings of a cell that name its prepared models."""


class NotPrepared(Exception):
    """The preparation for a cell failed; the text gives the cause."""


@dataclass(frozen=True, slots=True)
class PlannedRun:
    """A run of a cell.

    Attributes
    ----------
    cell, replicate: their numbers.
    seed: of the experiment.
    id: fingerprint of the resolved experiment; cells that resolve to the same experiment share it.
    """

    cell: int
    replicate: int
    seed: int
    id: str


@dataclass(frozen=True, slots=True)
class PlannedCell:
    """A cell and its runs.

    Attributes
    ----------
    cell: the cell.
    document: JSON text of its resolved experiment, with the seed of the first replicate; "" without one.
    runs: one per replicate.
    simulated_s: simulated time of one run.
    cause: of a failed preparation, "" where the runs can be run.
    """

    cell: Cell
    document: str
    runs: tuple[PlannedRun, ...]
    simulated_s: float
    cause: str = ""


class Resolver:
    """Resolves cells of a study into experiments; each file is read once.

    Paths in settings start from the folder of the study.
    """

    def __init__(self, study: Study) -> None:
        self._folder = study.folder
        self._documents: dict[str, Mapping[str, Any]] = dict(study.experiments)

    def experiment(self, name: str, settings: Sequence[str], seed: int) -> Experiment:
        """The experiment with settings and a seed, as `fesloop.load`. Raises InputError, InputErrors."""
        if name not in self._documents:
            self._documents[name] = read(name)[1]
        picked = pick(self._documents[name], settings, name)
        every = [*picked.settings, f"experiment.seed={seed}"]
        return from_document(apply_settings(picked.document, every, picked.name, tuple(picked.options),
                                            self._folder), picked.name)


def plan(study: Study, prepared: Settings, progress: Callable[[float], None] | None = None, *,
         checked: bool = False, known: bool = False) -> Iterator[PlannedCell]:
    """All cells with their runs; of a plan that is `known`, those that show whether it is the same.

    After the last cell, raises InputErrors with the faults of all cells, each once and with its first cell;
    of many faults, further ones are counted. With `checked`, all cells are sound but for what was prepared
    for them: a cell that its model makes invalid has failed runs with that cause.
    """
    resolver, faults = Resolver(study), dict[str, InputError]()
    for cell in covering(study) if known else cells_of(study):
        try:
            experiment = resolver.experiment(cell.experiment, (*cell.settings, *prepared(cell)),
                                             study.about.seed)
            _refuse_live(experiment)
        except InputError as fault:
            if checked:
                yield _not_prepared(study, cell, " ".join(str(fault).split()))
            else:
                for each in getattr(fault, "faults", [fault]):
                    faults.setdefault(str(each), in_cell(each, study, cell))
        except NotPrepared as fault:
            if not faults:
                yield _not_prepared(study, cell, str(fault))
        else:
            if not faults:
                yield _planned(study, cell, experiment)
        if progress is not None:
            progress((cell.number + 1) / study.cells)
    if faults:
        shown = list(faults.values())[:_MOST_FAULTS]
        if len(faults) > _MOST_FAULTS:
            shown.append(InputError(study.name, f"{len(faults) - _MOST_FAULTS} more faults like these"))
        raise InputErrors(shown)


def _refuse_live(experiment: Experiment) -> None:
    """Raise InputError for live blocks: a study runs many runs at once, none in real time."""
    for node in experiment.wiring.nodes:
        if is_live(node):
            raise InputError(f"blocks.{node.name}", "is live, and a study runs nothing in real time",
                             "simulated and recorded blocks",
                             "take an experiment without streams and devices")


def in_cell(fault: InputError, study: Study, cell: Cell) -> InputError:
    """The fault of a cell's experiment with the cell, and the axis that sets the key if one does."""
    where = fault.where
    if where.startswith(_SETTING):
        key = where.removeprefix(_SETTING).partition("=")[0]
        axis = next((name for name, settings in cell.by_axis.items()
                     if any(each.partition("=")[0] == key for each in settings)), None)
        where = f"axes.{axis}: {where}" if axis else f"study.settings: {where}"
    at = f" ({cell.place})" if cell.levels else ""
    return InputError(f"{study.name}: {where}", f"{fault.found}{at}", fault.allowed, fault.remedy)


def _planned(study: Study, cell: Cell, experiment: Experiment) -> PlannedCell:
    document = experiment.document()
    runs = tuple(PlannedRun(cell.number, replicate, seed, _fingerprint(document, seed))
                 for replicate, seed in enumerate(_seeds(study)))
    simulated_s = experiment.trials * experiment.duration_ns / NS_PER_S
    return PlannedCell(cell, experiment.as_json(), runs, simulated_s)


def _not_prepared(study: Study, cell: Cell, cause: str) -> PlannedCell:
    """Runs whose preparation failed, named by the hash of their experiment, settings and cause."""
    known = {"experiment": {"name": cell.experiment}, "settings": list(cell.settings), "cause": cause}
    runs = tuple(PlannedRun(cell.number, replicate, seed, _fingerprint(known, seed))
                 for replicate, seed in enumerate(_seeds(study)))
    return PlannedCell(cell, "", runs, 0.0, cause)


def _seeds(study: Study) -> range:
    return range(study.about.seed, study.about.seed + study.about.replicates)


def _fingerprint(document: dict[str, Any], seed: int) -> str:
    """Fingerprint of the experiment with another seed."""
    with_seed = {**document, "experiment": {**document["experiment"], "seed": seed}}
    return hashlib.sha256(json.dumps(with_seed, sort_keys=True, separators=(",", ":")).encode()).hexdigest()
