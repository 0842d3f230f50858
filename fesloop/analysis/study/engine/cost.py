"""Estimates the cost of a study before it is run: number of runs, time, disk space."""

from __future__ import annotations

import json
import shutil
import statistics
import zlib
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from fesloop.analysis.study.design.plan import PlannedCell, plan
from fesloop.analysis.study.design.study import Study
from fesloop.analysis.study.engine.cluster import (
    connected,
    require_dask,
    require_started,
    require_workers,
    threads,
)
from fesloop.analysis.study.engine.coordinator import await_workers
from fesloop.analysis.study.engine.preparing import Preparations, meanwhile
from fesloop.analysis.study.engine.running import DIED
from fesloop.analysis.study.engine.tasks import Task, Watch, completed
from fesloop.analysis.study.engine.worker import Outcome, ResultSpec, run_one
from fesloop.analysis.study.results.study_results import load
from fesloop.analysis.study.store.file import FILE
from fesloop.analysis.study.store.writing import decisive
from fesloop.errors import RunError
from fesloop.experiment.registry import sources
from fesloop.given_files import exists, is_file

_TRIED = 8
"""Number of cells that are tried, spread evenly over the study (chosen)."""
_ROW_BYTES = 500
"""Size of a result and its plan in the store, besides metrics and documents (measured: 350 to 450)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Cost:
    """Cost of a study.

    Attributes
    ----------
    cells, runs: numbers of them; runs that several cells share count once. done: runs that have a result.
    simulated_s: simulated time of all runs.
    tried: number of runs that were tried. run_s, least_s, most_s: median, least and greatest of their times.
    workers: threads of the cluster. left_s: time until all runs are done, without preparations.
    prepared: number of models to prepare. prepared_s: time that all of them take at the pace of the trial
        runs, without the fits.
    disk_bytes: size of results and kept recordings. free_bytes: free space on the disk.
    """

    cells: int
    runs: int
    done: int
    simulated_s: float
    tried: int
    run_s: float
    least_s: float
    most_s: float
    workers: int
    left_s: float
    prepared: int
    prepared_s: float
    disk_bytes: int
    free_bytes: int

    def as_table(self) -> dict[str, Any]:
        """The table that `fesloop study --dry-run --json` prints."""
        return asdict(self)


def cost(study: Study, out: str | Path = "studies", *, workers: int | None = None,
         scheduler: str | None = None, watch: Watch) -> Cost:
    """Check the study, try a few of its runs, and estimate the cost of all. Nothing is kept.

    Parameters as in `fesloop.analysis.study.engine.coordinator.run_study`. Raises the errors that this raises
    before any run, and RunError where no tried run ends well.
    """
    require_dask()
    require_started()
    require_workers(workers)
    folder = Path(out) / study.name
    there = next(each for each in (folder, *folder.absolute().parents) if exists(each))
    ids, simulated_s, sample = _gone_through(study, watch)
    preparations = Preparations(study)
    done = _done(folder, study) & ids if not study.prepare else _done(folder, study)
    with connected(workers, scheduler) as client:
        await_workers(client, watch)
        count = threads(client)
        outcomes = _tried(client, study, sample, watch)
    ended = [each.wall_s for each in outcomes if each.status == "done"]
    if not ended:
        raise RunError(f"{study.name}: none of {len(sample)} tried runs ended well: "
                       f"{outcomes[0].cause if outcomes else DIED}")
    pace = statistics.fmean(ended) * study.cells * study.about.replicates / simulated_s
    return Cost(cells=study.cells, runs=len(ids), done=len(done), simulated_s=simulated_s, tried=len(ended),
                run_s=statistics.median(ended), least_s=min(ended), most_s=max(ended), workers=count,
                left_s=(len(ids) - len(done)) * statistics.fmean(ended) / count,
                prepared=len(preparations.needed),
                prepared_s=preparations.simulated_s * pace / count,
                disk_bytes=_disk_bytes(study, len(ids), sample, outcomes),
                free_bytes=shutil.disk_usage(there).free)


def _gone_through(study: Study, watch: Watch) -> tuple[set[str], float, list[PlannedCell]]:
    """Ids of all runs, their simulated seconds, and some cells spread over the study."""
    ids, simulated_s, sample = set[str](), 0.0, list[PlannedCell]()
    chosen = {(2 * i + 1) * study.cells // (2 * _TRIED) for i in range(_TRIED)}
    for each in plan(study, meanwhile(study), lambda share: watch.stage("check", share)):
        ids.update(run.id for run in each.runs)
        simulated_s += each.simulated_s * len(each.runs)
        if each.cell.number in chosen:
            sample.append(each)
    return ids, simulated_s, sample


def _done(folder: Path, study: Study) -> set[str]:
    """Ids of runs that have a result of this study."""
    if not is_file(folder / FILE):
        return set()
    results = load(folder)
    same = decisive(results.study) == decisive(json.loads(json.dumps(study.document)))
    return set(results.frame()["id"]) if same else set()


def _tried(client: Any, study: Study, sample: Sequence[PlannedCell], watch: Watch) -> list[Outcome]:
    """Outcomes of a run of each cell, after each worker has run the first cell to load compiled code."""
    with TemporaryDirectory(prefix="fesloop-") as folder:
        spec = ResultSpec(study.metrics, "none", folder, sources())
        first = [sample[0]] * len(client.nthreads())
        outcomes: list[Outcome] = []
        for several in (first, sample):
            tasks = (Task(f"try-{number}", run_one, (
                each.runs[0].id, zlib.compress(each.document.encode()), each.runs[0].seed, spec))
                for number, each in enumerate(several))
            outcomes.clear()
            for done in completed(client, tasks):
                outcomes += [each.outcome for each in done if each.outcome is not None]
                watch.stage("try", len(outcomes) / len(several))
        return outcomes


def _disk_bytes(study: Study, runs: int, sample: Sequence[PlannedCell], outcomes: Sequence[Outcome]) -> int:
    """Size of the store and of all kept recordings."""
    document = statistics.fmean(len(zlib.compress(each.document.encode())) for each in sample)
    row = _ROW_BYTES + len(json.dumps(outcomes[0].metrics))
    recordings = statistics.fmean(each.recording_bytes for each in outcomes)
    kept = runs if study.about.recordings == "all" else 0
    return round(study.cells * document + runs * row + kept * recordings)
