"""Runs the pending runs of a study on a cluster, and stores their results."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby
from operator import attrgetter
from typing import Any

from fesloop.analysis.study.design.study import Study
from fesloop.analysis.study.engine.cluster import threads
from fesloop.analysis.study.engine.preparing import Prepared
from fesloop.analysis.study.engine.tasks import Done, Task, Watch, completed
from fesloop.analysis.study.engine.worker import NO_ROOM, Outcome, ResultSpec, run_one
from fesloop.analysis.study.store.versions import version_text
from fesloop.analysis.study.store.writing import PendingRun, Store, StoredResult
from fesloop.errors import RunError
from fesloop.experiment.registry import sources

DIED = "the worker process died each time it was tried (out of memory, or a crash in compiled code)"


@dataclass(slots=True)
class Tally:
    """Numbers of runs that are done, and that failed by cause."""

    done: int
    failed: dict[str, int]

    def add(self, results: Sequence[StoredResult]) -> None:
        """Count results."""
        for each in results:
            if each.status == "done":
                self.done += 1
            else:
                self.failed[each.cause] = self.failed.get(each.cause, 0) + 1


def run_pending(client: Any, study: Study, store: Store, retry_failed: bool, watch: Watch) -> None:
    """Run all pending runs, and store their results."""
    total, tally = store.distinct_runs(), Tally(*store.counts())
    if retry_failed:
        tally.failed = store.not_prepared()
    watch.runs(tally.done, tally.failed, total)

    def wait() -> None:
        if not lacks_workers(client, watch):
            watch.runs(tally.done, tally.failed, total)

    def note(several: Iterable[Done]) -> None:
        tally.add(put_outcomes(store, several))
        watch.runs(tally.done, tally.failed, total)

    lost = set[str]()
    for several in completed(client, tasks_of(study, store, store.pending(retry_failed=retry_failed)), wait):
        lost |= {each.id for each in several if died(each)}
        note(each for each in several if not died(each))
    # A run on one worker with another run that kills it is lost as well: each lost run is tried with no other
    # on the cluster, and fails only if its worker dies again.
    for suspect in store.pending(retry_failed=retry_failed) if lost else ():
        if suspect.id in lost:
            for several in completed(client, tasks_of(study, store, [suspect]), wait):
                note(several)


def lacks_workers(client: Any, watch: Watch) -> bool:
    """Whether the cluster has no workers, which `watch` is told."""
    lack = not threads(client)
    if lack:
        watch.stage("wait for workers")
    return lack


def put_outcomes(store: Store, several: Iterable[Done]) -> list[StoredResult]:
    """Store the outcomes of runs; then raise RunError for the first that is no result."""
    results, refusals = [], []
    for each in several:
        reason = refusal(each)
        if reason is None:
            results.append(_result(each))
        else:
            refusals.append(reason)
    store.put(results)
    if refusals:
        raise refusals[0]
    return results


def died(each: Done) -> bool:
    """Whether the worker of a run died."""
    return type(each.fault).__name__ == "KilledWorker"


def tasks_of(study: Study, store: Store, pending: Iterable[PendingRun]) -> Iterator[Task]:
    """Tasks of pending runs, cell by cell."""
    spec = ResultSpec(study.metrics, study.about.recordings,
                      str((store.path.parent / "recordings").absolute()), sources())
    for number, runs in groupby(pending, attrgetter("cell")):
        document = store.document(number)
        for each in runs:
            yield Task(each.id, run_one, (each.id, document, each.seed, spec))


def _result(each: Done) -> StoredResult:
    """The stored result of a run."""
    if each.outcome is None:
        return StoredResult(id=each.id, status="failed", cause=ending(each)[1], metrics={}, wall_s=0.0,
                            worker="")
    outcome: Outcome = each.outcome
    return StoredResult(id=outcome.id, status=outcome.status, cause=outcome.cause, metrics=outcome.metrics,
                        wall_s=outcome.wall_s, worker=outcome.worker, recording=outcome.recording)


def refusal(each: Done) -> RunError | None:
    """The error that ends the study: a worker has no room, no fesloop, or another version of it."""
    if each.outcome is None:
        return None if died(each) else RunError(
            f"a worker cannot do a run of fesloop ({ending(each)[1]}); earlier results are kept; install the "
            "same fesloop for all workers, and start the study again to continue")
    outcome: Outcome | Prepared = each.outcome
    if outcome.status == NO_ROOM:
        return RunError(f"a worker's disk is full ({outcome.worker}: {outcome.cause}); earlier results "
                        "are kept; make room, and start the study again to continue")
    if outcome.version != version_text():
        return RunError(f"a worker that joined later has another version ({outcome.worker}); earlier results "
                        "are kept; install the same versions, and start the study again to continue")
    return None


def ending(each: Done) -> tuple[str, str]:
    """Status and cause of a run."""
    if each.outcome is not None:
        return each.outcome.status, each.outcome.cause
    if died(each):
        return "failed", DIED
    return "failed", " ".join(f"{type(each.fault).__name__}: {each.fault}".split())
