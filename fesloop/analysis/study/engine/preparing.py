"""Prepares models of patients, each identified in an experiment of its own before the cells that need it.

A preparation is itself a run, named by the hash of its resolved experiment, and is done once for all cells
that need it. Where it fails, these cells fail with its cause.
"""

from __future__ import annotations

import socket
import zlib
from collections.abc import Iterator, Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

from fesloop.analysis.study.design.cells import Cell, cells_of
from fesloop.analysis.study.design.plan import NotPrepared, Resolver, Settings
from fesloop.analysis.study.design.study import Preparation, Study
from fesloop.analysis.study.engine.worker import (
    NO_CODE,
    NO_ROOM,
    experiment_of,
    failure,
    is_full,
    scratch_folder,
)
from fesloop.analysis.study.store.versions import version_text
from fesloop.errors import FesloopError, InputError, InputErrors, RunError, where_it_broke
from fesloop.experiment.registry import identifier
from fesloop.experiment.running import Experiment, run
from fesloop.forms.toml import toml_value
from fesloop.loop.clock import NS_PER_S
from fesloop.loop.machine import one_blas_thread
from fesloop.models.patient_model import require_usable

Needed = dict[str, tuple[str, bytes]]
"""Key and deflated document of each preparation, by id."""


class Prepared(NamedTuple):
    """Outcome of a preparation: done with the text of a model file, or failed with a cause.

    `worker` and `version` are those of the worker, as in an `Outcome`.
    """

    id: str
    status: str
    cause: str
    content: str
    worker: str
    version: str


def meanwhile(study: Study) -> Settings:
    """Settings that stand in for models not prepared yet."""
    settings = tuple(each for preparation in study.prepare.values() for each in preparation.meanwhile)
    return lambda cell: settings


class Preparations:
    """The preparations that each cell needs, and the simulated time of all.

    Raises InputError, InputErrors for invalid experiments.
    """

    def __init__(self, study: Study) -> None:
        self._study = study
        self._ids: dict[tuple[str, str, tuple[str, ...]], str] = {}
        self.needed: Needed = {}
        self.simulated_s = 0.0
        resolver = Resolver(study)
        for cell in cells_of(study) if study.prepare else ():
            for key, preparation in study.prepare.items():
                self._need(resolver, key, preparation, cell)

    def _need(self, resolver: Resolver, key: str, preparation: Preparation, cell: Cell) -> None:
        settings = _settings(preparation, cell)
        name = self._study.prepared_by(preparation, cell.experiment)
        if (key, name, settings) in self._ids:
            return
        try:
            experiment = resolver.experiment(name, settings, self._study.about.seed)
        except InputError as fault:
            raise InputErrors([_in_study(each, f"{self._study.name}: prepare.{key}", cell)
                               for each in getattr(fault, "faults", [fault])]) from None
        id = experiment.fingerprint()
        self._ids[key, name, settings] = id
        if id not in self.needed:
            self.simulated_s += experiment.trials * experiment.duration_ns / NS_PER_S
        self.needed[id] = key, zlib.compress(experiment.as_json().encode())

    def ids(self, cell: Cell) -> Iterator[tuple[str, str]]:
        """Key and id of each preparation that a cell needs."""
        for key, preparation in self._study.prepare.items():
            name = self._study.prepared_by(preparation, cell.experiment)
            yield key, self._ids[key, name, _settings(preparation, cell)]

    def settings(self, cell: Cell, files: Mapping[str, Path], causes: Mapping[str, str]) -> tuple[str, ...]:
        """Settings of a cell that name its prepared files. Raises NotPrepared where a preparation failed."""
        settings = []
        for key, id in self.ids(cell):
            if id in causes:
                name = self._study.prepared_by(self._study.prepare[key], cell.experiment)
                raise NotPrepared(f"{name}: {causes[id]}")
            settings.append(f"{key}={toml_value(str(files[id]))}")
        return tuple(settings)


def _in_study(fault: InputError, where: str, cell: Cell) -> InputError:
    at = f" ({cell.place})" if cell.levels else ""
    return InputError(f"{where}: {fault.where}", f"{fault.found}{at}", fault.allowed, fault.remedy)


def _settings(preparation: Preparation, cell: Cell) -> tuple[str, ...]:
    return (*preparation.settings,
            *(setting for axis in preparation.axes for setting in cell.by_axis[axis]))


@one_blas_thread()
def prepare_one(id: str, document: bytes, seed: int, code: Mapping[str, str] = NO_CODE) -> Prepared:
    """Run an excitation experiment and identify the excited patient, on a worker.

    `code`: sources of classes that no package registers.
    """
    with TemporaryDirectory(prefix="fesloop-", dir=scratch_folder()) as folder:
        try:
            status, cause, content = "done", "", _model(experiment_of(document, seed, code), Path(folder))
        except FesloopError as fault:
            status, cause, content = "failed", " ".join(str(fault).split()), ""
        except Exception as fault:  # noqa: BLE001 - as in fesloop.analysis.study.engine.worker
            status, cause, content = failure(fault), where_it_broke(fault), ""
        if status == "failed" and is_full(folder):
            status = NO_ROOM
    return Prepared(id, status, cause, content, socket.gethostname(), version_text())


def _model(experiment: Experiment, folder: Path) -> str:
    """Text of the model file of the patient that a run excites.

    Raises RunError where the run fails, InputError where the model explains too little to control by.
    """
    result = run(experiment, folder)
    if result.status != "done":
        raise RunError(result.cause or result.status)
    found, model = identifier()(str(result.recording)).model, folder / "model.toml"
    require_usable("model", found)
    found.save(model)
    return model.read_text(encoding="utf-8")
