"""Trial of a study's base experiments before all other runs; a base that fails by itself ends the study.

The first planned run of each is tried, and kept. Only where that fails is the experiment run without any
axis, to see whether the base or the cell is at fault: a cell may fail, and is then a row of the results.
"""

from __future__ import annotations

import zlib
from collections.abc import Collection
from typing import Any

from fesloop.analysis.study.design.cells import Cell, base_cells
from fesloop.analysis.study.design.plan import Resolver, Settings, in_cell
from fesloop.analysis.study.design.study import Study
from fesloop.analysis.study.engine.running import died, ending, put_outcomes, refusal, report_lack, tasks_of
from fesloop.analysis.study.engine.tasks import Done, Task, Watch, completed, each_of
from fesloop.analysis.study.engine.worker import ResultSpec, run_one
from fesloop.analysis.study.store.writing import Store
from fesloop.errors import InputError, InputErrors


def meanwhile(study: Study) -> Settings:
    """Settings that stand in for models not prepared yet."""
    settings = tuple(each for preparation in study.prepare.values() for each in preparation.meanwhile)
    return lambda cell: settings


def try_bases(client: Any, study: Study, store: Store, watch: Watch) -> None:
    """Run the first run of each base experiment, and keep it.

    Where a study prepares models, which takes long, the base itself is run with stand-ins for them. Raises
    InputErrors where a base experiment fails; then nothing is kept.
    """
    watch.stage("try the base experiment")
    firsts = {} if study.prepare else store.first_runs()
    tried = list(each_of(completed(client, tasks_of(study, store, sorted(firsts.values())),
                                lambda: report_lack(client, watch))))
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
              for each in each_of(completed(client, tasks, lambda: report_lack(client, watch)))
              if ending(each)[0] != "done"]
    if faults:
        raise InputErrors(faults)


def _task(study: Study, id: str, cell: Cell) -> list[Task]:
    """The task of an experiment without any axis; none where it is incomplete without its axes."""
    try:
        experiment = Resolver(study.folder).experiment(
            cell.experiment, (*cell.settings, *meanwhile(study)(cell)), study.about.seed)
    except InputError:
        return []
    document = zlib.compress(experiment.as_json().encode())
    spec = ResultSpec(study.metrics, "none", "")
    return [Task(id, run_one, (experiment.fingerprint(), document, study.about.seed, spec))]


def _fault(study: Study, cell: Cell, each: Done) -> InputError:
    return in_cell(InputError(cell.experiment, f"the base experiment itself fails: {ending(each)[1]}",
                              "one that runs to its end", "correct it, or the study's settings and metrics"),
                   study, cell)
