"""`fesloop study`."""

from __future__ import annotations

import math
import signal
import sys
from argparse import Namespace
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from fesloop.analysis.study.design.study import Study
from fesloop.analysis.study.design.study_file import read_study
from fesloop.analysis.study.engine.coordinator import Summary, run_study
from fesloop.analysis.study.engine.cost import Cost, cost
from fesloop.analysis.study.results.estimates import Estimate
from fesloop.analysis.study.results.quantities import duration_text
from fesloop.analysis.study.results.study_results import StudyResults, load
from fesloop.apps.cli.output import print_json, print_table
from fesloop.apps.cli.study_progress import StudyProgress
from fesloop.apps.cli.what_next import tell_what_next
from fesloop.errors import FesloopError, InputError

_SHOWN = 10
_WITH_INTERVALS = 3
"""Metrics that a line of the table has room for with their intervals."""


def execute(args: Namespace) -> int:
    """Run a study, or what is left of it; print its table; leave figures beside its results."""
    if args.workers is not None and args.scheduler is not None:
        raise InputError("--workers", "stands beside --scheduler, whose cluster has workers of its own",
                         "one of the two", "remove one")
    study = read_study(args.study, args.form)
    with _terminated_as_interrupted():
        return _dry_run(study, args) if args.dry_run else _run(study, args)


@contextmanager
def _terminated_as_interrupted() -> Iterator[None]:
    """SIGTERM, by which schedulers of clusters end a job, is Ctrl-C: workers and scratch files go."""
    before = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


def _run(study: Study, args: Namespace) -> int:
    watch = StudyProgress(study.name)
    try:
        summary = run_study(study, args.out, workers=args.workers, scheduler=args.scheduler, watch=watch,
                            retry_failed=args.retry_failed, mix_versions=args.mix_versions)
    finally:
        watch.finish()
    results = load(summary.store)
    _show(summary, results)
    figures = _draw(results, study, summary.store.parent)
    for path in figures:
        print(path, file=sys.stderr)
    tell_what_next(summary.store, study.try_next)
    if args.json:
        print_json({**summary.as_table(), "figures": [str(path) for path in figures]})
    else:
        print(summary.store)
    return 0


def _dry_run(study: Study, args: Namespace) -> int:
    """Say what the study would take."""
    watch = StudyProgress(study.name)
    try:
        found = cost(study, args.out, workers=args.workers, scheduler=args.scheduler, watch=watch)
    finally:
        watch.finish()
    _show_cost(study, found)
    if args.json:
        print_json(found.as_table())
    return 0


def _show_cost(study: Study, found: Cost) -> None:
    rows = [["cells", f"{found.cells:,}"], ["replicates", f"{study.about.replicates}"],
            ["runs", f"{found.runs:,}"], ["of these done already", f"{found.done:,}"],
            ["simulated", duration_text(found.simulated_s)],
            ["one run", f"{found.run_s:.2f} s (median of {found.tried} that were tried, "
                        f"{found.least_s:.2f} to {found.most_s:.2f})"],
            ["workers", f"{found.workers}"], ["time left", duration_text(found.left_s)],
            ["disk", f"{found.disk_bytes / 1e6:.1f} MB of {found.free_bytes / 1e6:,.0f} MB that are free"]]
    if study.prepare:
        rows.append(["beside it", f"{', '.join(study.prepare)}, prepared for each patient, not counted"])
    if study.cost:
        rows.append(["cost, as the file says", study.cost])
    print_table(f"{study.name}: what it takes; nothing is kept of what was tried", ("", ""), rows, sys.stderr)


def _draw(results: StudyResults, study: Study, folder: Path) -> list[Path]:
    """The study's figures, and beside them theory's lines, for reports."""
    if not study.figures:
        return []
    from fesloop.show.figures.drawing import draw
    from fesloop.show.figures.theory_overlays import keep_overlays, theory_overlays

    drawn, theory = [], {}
    for figure in study.figures:
        try:
            theory[figure.name] = theory_overlays(study, figure)
            drawn.append(draw(results, figure, folder, theory[figure.name]))
        except FesloopError as fault:
            print(f"fesloop: figure {figure.name} is not drawn: {fault}", file=sys.stderr)
    if any(theory.values()):
        keep_overlays(folder, results.about.get("created", ""), theory)
    return drawn


def _show(summary: Summary, results: StudyResults) -> None:
    """A row a cell, as far as a screen goes, and failures by cause."""
    rows = results.summary()
    axes = list(dict.fromkeys(axis for row in rows for axis in row.levels))
    intervals = len(results.metrics) <= _WITH_INTERVALS and any(
        each.has_interval for row in rows for each in row.metrics.values())
    cells = [[*(str(row.levels.get(axis, "all")) for axis in axes), f"{row.planned - row.waiting}",
              f"{row.failed}", *(_told(estimate, intervals) for estimate in row.metrics.values())]
             for row in rows]
    told = " or ".join(dict.fromkeys(each.statistic for row in rows for each in row.metrics.values()))
    told += " and 95 % interval of what is repeated" if intervals else ""
    print_table(f"{summary.study}: {summary.done} of {summary.runs} runs done; {told}",
                (*axes, "runs", "failed", *results.metrics), cells, sys.stderr)
    for cause, count in list(summary.failed.items())[:_SHOWN]:
        print(f"failed: {count} x {cause}", file=sys.stderr)


def _told(estimate: Estimate, interval: bool) -> str:
    if math.isnan(estimate.value):
        return "-"
    known = interval and estimate.has_interval
    return f"{estimate.value:.3g}" + (f" ({estimate.low:.3g} to {estimate.high:.3g})" if known else "")
