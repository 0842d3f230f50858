"""`fesloop run`."""

from __future__ import annotations

import sys
from argparse import Namespace
from collections import Counter
from pathlib import Path
from typing import Any

from fesloop.cli.output import print_json, print_table, progress_bar
from fesloop.experiment.parse import load
from fesloop.experiment.reading import Recording
from fesloop.experiment.trial import Result, run

_EXIT_CODES = {"done": 0, "failed": 1, "interrupted": 130}


def execute(args: Namespace) -> int:
    """Run, print the summary, and give the exit code that the run's status stands for."""
    experiment = load(args.experiment, args.settings, args.seed)
    with progress_bar(experiment.name) as bar:
        result = run(experiment, Path(args.out), realtime=args.realtime, progress=bar)
    if result.cause:
        print(f"fesloop: {result.cause}", file=sys.stderr)
    _summarise(result)
    if args.json:
        print_json(result.as_table())
    else:
        print(result.recording)
    return _EXIT_CODES[result.status]


def _summarise(result: Result) -> None:
    rows = [["status", result.status], ["seed", str(result.seed)]]
    rows += [[name, text] for name, text in _flat("", result.metrics)]
    rows += [["wall time", f"{result.wall_s:.2f} s"], ["real-time factor", f"{result.realtime_factor:.1f}"]]
    if result.deadlines:
        rows.append(["missed deadlines", f"{result.missed_deadlines} of {result.deadlines}"])
    rows += [["events", f"{count} x {status} ({where})"] for (where, status), count in _events(result)]
    print_table(result.experiment, ("", ""), rows, sys.stderr)


def _events(result: Result) -> list[tuple[tuple[str, str], int]]:
    """Kinds of events, the most frequent first."""
    with Recording(result.recording) as recording:
        return Counter((event.where, event.status) for event in recording.events).most_common(8)


def _flat(name: str, value: Any) -> list[tuple[str, str]]:
    """Metrics as rows: tables in tables by their names, a list on one line."""
    if isinstance(value, dict):
        return [row for key, item in value.items() for row in _flat(f"{name} {key}".strip(), item)]
    if isinstance(value, list):
        return [(name, "  ".join(_number(item) for item in value))]
    return [(name, _number(value))]


def _number(value: Any) -> str:
    return f"{value:.3f}" if isinstance(value, float) else str(value)
