"""`fesloop reproduce`."""

from __future__ import annotations

import math
import os
import sys
from argparse import Namespace
from importlib import import_module
from pathlib import Path
from tempfile import TemporaryFile

from fesloop.apps.cli.output import as_json, print_json, print_table, progress_bar
from fesloop.apps.reproduce.comparison import FigureScores, PatternScores, Row, share_that_holds
from fesloop.apps.reproduce.published import HALVES
from fesloop.apps.reproduce.result import Reproduction, summary_lines
from fesloop.errors import InputError, did_you_mean

PAPERS = ("kortier2014", "salchow2019", "hour", "array_search", "grasp_ilc", "grasp_trackers", "grasp_mpc",
          "three_trials", "linear_theory", "error_replay", "people")


def execute(args: Namespace) -> int:
    """Run a paper's experiments; print them beside the published figures; write tables and figures."""
    if args.paper not in PAPERS:
        raise InputError(f"reproduce {args.paper}", "there is no such paper", ", ".join(PAPERS),
                         did_you_mean(args.paper, PAPERS))
    paper = import_module(f"fesloop.apps.reproduce.{args.paper}")
    subjects = paper.SUBJECTS if args.subjects is None else args.subjects
    if not 1 <= subjects <= 10_000:
        raise InputError("--subjects", f"{subjects}", "1 to 10000")
    workers = os.cpu_count() or 1 if args.workers is None else args.workers
    if not 1 <= workers <= 1024:
        raise InputError("--workers", f"{workers}", "1 to 1024 processes")
    folder = Path(args.out) / args.paper
    _make(folder)
    with progress_bar(f"reproduce {args.paper}") as bar:
        found = paper.run(subjects, workers, bar)
    _show(found)
    _write(found, folder)
    if args.json:
        print_json(found.as_table())
    else:
        print(folder)
    return 0


def _make(folder: Path) -> None:
    """Make the folder before the work, and check that it can be written."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with TemporaryFile(dir=folder):
            pass
    except OSError as fault:
        raise _unwritable(folder, fault) from None


def _write(found: Reproduction, folder: Path) -> None:
    """Write the tables as JSON, and the figures."""
    from fesloop.apps.reproduce.figures import draw

    try:
        (folder / "table.json").write_text(as_json(found.as_table()) + "\n")
        draw(found, folder)
    except OSError as fault:
        raise _unwritable(folder, fault) from None


def _unwritable(folder: Path, fault: OSError) -> InputError:
    return InputError(f"--out {folder}", f"cannot be written: {fault.strerror}",
                      "a folder that can be written")


def _show(found: Reproduction) -> None:
    """Print the rows of the comparison, fitted and predicted ones apart, then the sweeps."""
    plain = [row for row in found.rows if row.scores is None]
    if plain:
        print_table(f"{found.paper}: published and reproduced, {found.cohort}, median (5-95 %)",
                    (*_COLUMNS, "holds"), [[*_cells(row), _holds(row)] for row in plain], sys.stderr)
    for half in HALVES:
        scored = [(row, row.scores) for row in found.rows
                  if isinstance(row.scores, FigureScores) and row.scores.half == half]
        if scored:
            print_table(f"{found.paper}: published and {half}, {found.cohort}, median (5-95 %)",
                        (*_COLUMNS, "PIT", "log score", "baseline's", "band/sd", "holds"),
                        [[*_cells(row), *map(_score, (scores.pit, scores.log_score, scores.baseline_log_score,
                                                      scores.band_over_sd)), _holds(row)]
                         for row, scores in scored], sys.stderr)
    patterns = [(row, row.scores) for row in found.rows if isinstance(row.scores, PatternScores)]
    if patterns:
        print_table(f"{found.paper}: patterns", ("table", "pattern", "published", "reproduced", "baseline",
                                                 "holds"),
                    [[row.table, row.row, str(row.theirs), str(row.ours),
                      f"{100.0 * scores.baseline_share:.0f} %", _holds(row)] for row, scores in patterns],
                    sys.stderr)
    print(f"{100.0 * share_that_holds(found.rows):.0f} % of {len(found.rows)} rows hold", file=sys.stderr)
    if found.baseline:
        print("\n".join(summary_lines(found.as_table())), file=sys.stderr)
    for sweep in found.sweeps.values():
        print(file=sys.stderr)
        rows = [[name, *(f"{value:.2f}" for value in values)] for name, values in sweep.rows]
        print_table(f"{sweep.title}, {sweep.unit}", ("", *sweep.columns), rows, sys.stderr)


_COLUMNS = ("table", "row", "published", "reproduced", "unit")


def _cells(row: Row) -> list[str]:
    theirs = row.theirs if isinstance(row.theirs, str) else f"{row.theirs:g}"
    return [row.table, row.row, theirs, str(row.ours), row.unit]


def _holds(row: Row) -> str:
    return "yes" if row.holds else "NO"


def _score(value: float) -> str:
    return "-" if math.isnan(value) else f"{value:.2f}"
