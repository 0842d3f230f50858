"""`fesloop fmu build`."""

from __future__ import annotations

import sys
from argparse import Namespace
from importlib.metadata import entry_points
from pathlib import Path

from fesloop.apps.cli.output import print_json, progress_bar
from fesloop.errors import InputError, did_you_mean
from fesloop.experiment.registry import reinstall

GROUP = "fesloop.exporters"
"""Group of entry points: functions that write a plant as the FMU of a given path."""


def execute(args: Namespace) -> int:
    """Write a plant as an FMU."""
    exporters = {entry.name: entry for entry in entry_points(group=GROUP)}
    if args.plant not in exporters:
        raise InputError(f"fmu build {args.plant}", "this plant has no FMU", ", ".join(sorted(exporters)),
                         reinstall(GROUP, args.plant) or did_you_mean(args.plant, exporters))
    folder = Path(args.out)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as fault:
        raise InputError(f"--out {folder}", f"cannot be made: {fault.strerror}", "a folder") from None
    with progress_bar(f"fmu build {args.plant}"):
        built = exporters[args.plant].load()(folder / f"{args.plant}.fmu")
    if built.note:
        print(f"fesloop: {built.note}", file=sys.stderr)
    if args.json:
        print_json({"fmu": str(built.path), "size": built.size, "guid": built.guid, "binary": built.binary})
    else:
        print(built.path)
    return 0
