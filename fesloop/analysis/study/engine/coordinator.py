"""Runs a study: check it, prepare models, plan, run, and store each result.

Only the coordinator writes, several results at a time. Whatever process is killed, and whenever: a study that
is started again finds the stored results and runs the rest. A result is a function of its run alone, so
neither the number of workers nor the order in which runs end changes any.
"""

from __future__ import annotations

import time
import zlib
from collections import deque
from collections.abc import Collection
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from fesloop.analysis.study.design.cells import Cell, base_cells
from fesloop.analysis.study.design.plan import Resolver, Settings, in_cell, plan
from fesloop.analysis.study.design.study import Study
from fesloop.analysis.study.engine.cluster import connected, require_dask, require_started, require_workers
from fesloop.analysis.study.engine.preparing import Preparations, Prepared, meanwhile, prepare_one
from fesloop.analysis.study.engine.running import (
    died,
    ending,
    lacks_workers,
    put_outcomes,
    refusal,
    run_pending,
    tasks_of,
)
from fesloop.analysis.study.engine.tasks import Done, Nobody, Task, Watch, completed, each_of
from fesloop.analysis.study.engine.worker import ResultSpec, run_one
from fesloop.analysis.study.store.writing import Store
from fesloop.errors import InputError, InputErrors, RunError
from fesloop.experiment.registry import sources

_LOOK_S = 0.5


@dataclass(frozen=True, slots=True, kw_only=True)
class Summary:
    """Outcome of a study.

    Attributes
    ----------
    study: its name. store: its file.
    runs: number of distinct runs. done: number of those done. failed: number by cause.
    wall_s: duration since this start of the study.
    """

    study: str
    store: Path
    runs: int
    done: int
    failed: dict[str, int] = field(default_factory=dict)
    wall_s: float

    def as_table(self) -> dict[str, Any]:
        """The table that `fesloop study --json` prints."""
        return {"study": self.study, "store": str(self.store), "runs": self.runs, "done": self.done,
                "failed": self.failed, "wall_s": self.wall_s}


def run_study(study: Study, out: str | Path = "studies", *, workers: int | None = None,
              scheduler: str | None = None, retry_failed: bool = False, mix_versions: bool = False,
              watch: Watch | None = None) -> Summary:
    """Run all runs of a study that have no result yet; results are stored in `out`/NAME/study.sqlite.

    Parameters
    ----------
    workers: processes on this machine (None: one per core), where no `scheduler` is given.
    scheduler: address of a running Dask cluster.
    retry_failed: run failed runs again. mix_versions: continue with results of other code or libraries.
    watch: receives the progress.

    Raises InputError, InputErrors for a study that cannot be run, before any run; RunError where the
    scheduler is gone or a disk is full; earlier results are kept.
    """
    began = time.perf_counter()
    watch = watch or Nobody()
    require_dask()
    require_started()
    require_workers(workers)
    preparations = Preparations(study)
    with Store(Path(out) / study.name, study, mix_versions=mix_versions) as store:
        known = store.planned == study.cells
        checked = plan(study, meanwhile(study), lambda share: watch.stage("check", share), known=known)
        if study.prepare:
            deque(checked, maxlen=0)
        else:
            store.put_plan(checked)
        if study.prepare or any(store.pending(retry_failed=retry_failed)):
            watch.stage("start workers")
            with connected(workers, scheduler) as client:
                _run_all(client, study, preparations, store, retry_failed, watch)
        done, failed = store.counts()
        return Summary(study=study.name, store=store.path, runs=store.distinct_runs(), done=done,
                       failed=failed, wall_s=time.perf_counter() - began)


def _run_all(client: Any, study: Study, preparations: Preparations, store: Store,
                     retry_failed: bool, watch: Watch) -> None:
    """Try the base experiments, prepare the models that cells need, and run all pending runs."""
    await_workers(client, watch)
    if not store.started:
        _try_bases(client, study, store, watch)
    if study.prepare:
        with TemporaryDirectory(prefix="fesloop-") as folder:
            known = store.planned == study.cells and not _missing(preparations, store, retry_failed)
            settings = _prepare(client, study, preparations, store, Path(folder), retry_failed, watch)
            store.put_plan(plan(study, settings, lambda share: watch.stage("plan", share), checked=True,
                                known=known))
    run_pending(client, study, store, retry_failed, watch)


def await_workers(client: Any, watch: Watch) -> None:
    """Wait until the cluster has workers, which a job queue may start late."""
    while lacks_workers(client, watch):
        if client.status != "running":
            raise RunError("the scheduler is gone, before any worker connected to it")
        time.sleep(_LOOK_S)


def _missing(preparations: Preparations, store: Store, retry_failed: bool) -> dict[str, Any]:
    """Models that are still to be prepared, by id."""
    there = {id for id, entry in store.prepared().items() if entry[0] == "done" or not retry_failed}
    return {id: each for id, each in preparations.needed.items() if id not in there}


def _prepare(client: Any, study: Study, preparations: Preparations, store: Store, folder: Path,
             retry_failed: bool, watch: Watch) -> Settings:
    """Prepare the models that are missing, as files in `folder`; the settings of each cell that name them."""
    missing = _missing(preparations, store, retry_failed)
    found = {id: entry for id, entry in store.prepared().items() if id not in missing}
    tasks = (Task(id, prepare_one, (id, document, study.about.seed, sources()))
             for id, (_, document) in missing.items())
    for number, each in enumerate(each_of(completed(client, tasks, lambda: lacks_workers(client, watch)))):
        watch.stage("prepare", number / len(missing))
        reason = refusal(each)
        if reason is not None:
            raise reason
        model: Prepared | None = each.outcome
        found[each.id] = (model.status, model.cause, model.content) if model else (*ending(each), "")
        store.put_prepared(each.id, missing[each.id][0], *found[each.id])
    files, causes = {}, {}
    for id, (status, cause, content) in found.items():
        if status == "done":
            files[id] = folder / f"{id}.toml"
            files[id].write_text(content, encoding="utf-8")
        else:
            causes[id] = cause
    return lambda cell: preparations.settings(cell, files, causes)


def _try_bases(client: Any, study: Study, store: Store, watch: Watch) -> None:
    """Run the first run of each base experiment before all others, and keep it.

    Only where that fails is the experiment run without any axis, to see whether the base or the cell is at
    fault: a cell may fail, and is then a row of the results.

    Where a study prepares models, which takes long, the base itself is run with stand-ins for them. Raises
    InputErrors where a base experiment fails; then nothing is kept.
    """
    watch.stage("try the base experiment")
    firsts = {} if study.prepare else store.first_runs()
    tried = list(each_of(completed(client, tasks_of(study, store, sorted(firsts.values())),
                                lambda: lacks_workers(client, watch))))
    for reason in filter(None, map(refusal, tried)):
        raise reason
    well = {each.id for each in tried if ending(each)[0] == "done"}
    suspects = [cell for cell in base_cells(study)
                if cell.experiment not in firsts or firsts[cell.experiment].id not in well]
    _require_sound(client, study, suspects, watch)
    put_outcomes(store, [each for each in tried if not died(each)])


def _require_sound(client: Any, study: Study, cells: Collection[Cell], watch: Watch) -> None:
    """Raise InputErrors where one of the experiments does not run to its end by itself."""
    by_id = {f"base-{cell.number}": cell for cell in cells}
    tasks = (task for id, cell in by_id.items() for task in _task(study, id, cell))
    faults = [_fault(study, by_id[each.id], each)
              for each in each_of(completed(client, tasks, lambda: lacks_workers(client, watch)))
              if ending(each)[0] != "done"]
    if faults:
        raise InputErrors(faults)


def _task(study: Study, id: str, cell: Cell) -> list[Task]:
    """The task of an experiment without any axis; none where it is incomplete without its axes."""
    try:
        experiment = Resolver(study).experiment(
            cell.experiment, (*cell.settings, *meanwhile(study)(cell)), study.about.seed)
    except InputError:
        return []
    document = zlib.compress(experiment.as_json().encode())
    spec = ResultSpec(study.metrics, "none", "", sources())
    return [Task(id, run_one, (experiment.fingerprint(), document, study.about.seed, spec))]


def _fault(study: Study, cell: Cell, each: Done) -> InputError:
    where, _, found = ending(each)[1].partition(": ")
    if where in (f"study.metrics.{metric.name}" for metric in study.metrics):
        return InputError(f"{study.name}: {where}", found)  # of the study file, whose experiment is sound
    return in_cell(InputError(cell.experiment, f"the base experiment itself fails: {ending(each)[1]}",
                              "one that runs to its end", "correct it, or the study's settings and metrics"),
                   study, cell)
