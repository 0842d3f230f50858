"""`fesloop reproduce`."""

from __future__ import annotations

import os
import sys
from argparse import Namespace
from importlib import import_module
from pathlib import Path
from tempfile import TemporaryFile

from fesloop.apps.cli.output import as_json, print_json, print_table, progress_bar
from fesloop.apps.reproduce.comparison import Row, share_that_holds
from fesloop.apps.reproduce.result import Reproduction
from fesloop.errors import InputError, did_you_mean

PAPERS = ("kortier2014", "salchow2019", "hour", "array_search", "grasp_ilc", "grasp_trackers", "grasp_mpc",
          "linear_theory", "error_replay")


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
    """Print the rows of the comparison, then the sweeps."""
    cells = [[row.table, row.row, _theirs(row), _ours(row), row.unit, "yes" if row.holds else "NO"]
             for row in found.rows]
    print_table(f"{found.paper}: published and reproduced, {found.cohort}, median (5-95 %)",
                ("table", "row", "published", "reproduced", "unit", "holds"), cells, sys.stderr)
    print(f"{100.0 * share_that_holds(found.rows):.0f} % of {len(found.rows)} rows hold", file=sys.stderr)
    for sweep in found.sweeps.values():
        print(file=sys.stderr)
        rows = [[name, *(f"{value:.2f}" for value in values)] for name, values in sweep.rows]
        print_table(f"{sweep.title}, {sweep.unit}", ("", *sweep.columns), rows, sys.stderr)


def _theirs(row: Row) -> str:
    return row.theirs if isinstance(row.theirs, str) else f"{row.theirs:g}"


def _ours(row: Row) -> str:
    return str(row.ours)
