"""`fesloop study`."""

from __future__ import annotations

import shutil
import signal
import sys
import time
from argparse import Namespace
from collections import deque
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from fesloop.analysis.study.design.study import Study
from fesloop.analysis.study.design.study_file import read_study
from fesloop.analysis.study.engine.coordinator import run_study
from fesloop.analysis.study.engine.cost import Cost, cost
from fesloop.analysis.study.results.quantities import duration_text
from fesloop.analysis.study.results.shown import results_table
from fesloop.analysis.study.results.study_results import StudyResults, load
from fesloop.apps.cli.output import print_json, print_next_commands, print_table
from fesloop.errors import InputError

_LINE_INTERVAL_S = 15.0
"""Interval between lines where there is no terminal."""
_REFRESH_S = 0.5
"""Interval between refreshes of the line on a terminal."""
_LOOK_BACK_S = 60.0
_SHOWN_RUNS = 60


class StudyProgress:
    """Progress of a study on standard error (a `fesloop.analysis.study.engine.tasks.Watch`)."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._terminal = sys.stderr.isatty()
        self._printed_at = -_LINE_INTERVAL_S
        self._stage = ""
        self._past: deque[tuple[float, int]] = deque()

    def stage(self, text: str, fraction: float | None = None) -> None:
        """Show a stage before the runs, and the fraction done."""
        line = f"{self._name}: {text}"
        if self._terminal and fraction is not None:
            line += f" {100.0 * fraction:.0f} %"
        if self._terminal or text != self._stage:
            self._print(line, at_once=text != self._stage)
        self._stage = text

    def runs(self, done: int, failed: Mapping[str, int], total: int) -> None:
        """Show how many runs are done, how many failed by cause, and how many there are."""
        over = done + sum(failed.values())
        self._past.append((time.monotonic(), over))
        while self._past[-1][0] - self._past[0][0] > _LOOK_BACK_S:
            self._past.popleft()
        line = f"{self._name}: {over} of {total} runs"
        rate = self._rate()
        if rate > 0.0 and over < total:
            line += f", {_rate_text(rate)}, {duration_text((total - over) / rate)} left"
        if failed:
            worst = max(failed, key=failed.__getitem__)
            line += f", {sum(failed.values())} failed, most: {worst[:_SHOWN_RUNS]}"
        self._print(line, at_once=over == total)

    def finish(self) -> None:
        """Remove the line."""
        if self._terminal:
            print("\r\x1b[K", end="", file=sys.stderr, flush=True)

    def _rate(self) -> float:
        """Mean rate over the last minute, runs a second."""
        (first_s, first), (last_s, last) = self._past[0], self._past[-1]
        return (last - first) / (last_s - first_s) if last_s > first_s else 0.0

    def _print(self, line: str, *, at_once: bool) -> None:
        now = time.monotonic()
        if not at_once and now - self._printed_at < (_REFRESH_S if self._terminal else _LINE_INTERVAL_S):
            return
        self._printed_at = now
        if self._terminal:
            # A line that wraps could not be erased.
            line = line[:shutil.get_terminal_size().columns - 1]
            print(f"\r\x1b[K{line}", end="", file=sys.stderr, flush=True)
        else:
            print(line, file=sys.stderr, flush=True)


def _rate_text(rate: float) -> str:
    return f"{rate:.1f} a second" if rate >= 1.0 else f"{60.0 * rate:.1f} a minute"


_SHOWN = 10


def execute(args: Namespace) -> int:
    """Run a study, or its remaining runs; print its table; write figures beside its results."""
    if args.workers is not None and args.scheduler is not None:
        raise InputError("--workers", "is given together with --scheduler, whose cluster has its own workers",
                         "one of the two", "remove one")
    study = read_study(args.study, args.form)
    with _terminated_as_interrupted():
        return _dry_run(study, args) if args.dry_run else _run(study, args)


@contextmanager
def _terminated_as_interrupted() -> Iterator[None]:
    """Context in which SIGTERM, sent by cluster schedulers, acts as Ctrl-C, which ends the workers."""
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
    _show(results)
    figures = _draw(results, study, summary.store.parent)
    for path in figures:
        print(path, file=sys.stderr)
    print_next_commands(summary.store, study.try_next)
    if args.json:
        print_json({**summary.as_table(), "figures": [str(path) for path in figures]})
    else:
        print(summary.store)
    return 0


def _dry_run(study: Study, args: Namespace) -> int:
    """Print how long the study would take, and how much disk."""
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
            ["one run", f"{found.run_s:.2f} s (median of {found.tried} trial runs, "
                        f"{found.least_s:.2f} to {found.most_s:.2f})"],
            ["workers", f"{found.workers}"],
            ["time left, after the models" if study.prepare else "time left", duration_text(found.left_s)],
            ["disk", f"{found.disk_bytes / 1e6:.1f} MB of {found.free_bytes / 1e6:,.0f} MB that are free"]]
    if study.prepare:
        rows.append(["models before these", f"{found.prepared:,}, about {duration_text(found.prepared_s)} at "
                     "the pace of the trial runs, and their fits"])
    if study.cost:
        rows.append(["cost stated in the file", study.cost])
    print_table(f"{study.name}: cost; results of the trial runs are not kept", ("", ""), rows, sys.stderr)


def _draw(results: StudyResults, study: Study, folder: Path) -> list[Path]:
    """Draw the study's figures; say which cannot be drawn."""
    if not study.figures:
        return []
    from fesloop.show.figures.drawing import draw_all

    drawn, faults = draw_all(results, study, folder)
    for name, fault in faults.items():
        print(f"fesloop: figure {name} cannot be drawn: {fault}", file=sys.stderr)
    return drawn


def _show(results: StudyResults) -> None:
    """Print a row for each cell, and failures by cause."""
    table = results_table(results)
    print_table(table.title, table.columns, table.rows, sys.stderr)
    for cause, count in list(results.failures().items())[:_SHOWN]:
        print(f"failed: {count} x {cause}", file=sys.stderr)
