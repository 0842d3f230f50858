"""`fesloop export`."""

from __future__ import annotations

import sys
from argparse import Namespace

from fesloop.apps.cli.output import print_json, progress_bar
from fesloop.errors import InputError

_OF_BLOCKS = ("c", "fmu")
"""Formats of a block of an experiment; all others are of recordings."""


def execute(args: Namespace) -> int:
    """Write a recording in another format, or a block of an experiment as code; print the path."""
    if args.block is not None or args.format in _OF_BLOCKS:
        return _export_block(args)
    from fesloop.experiment.export import export

    if args.settings:
        raise InputError("--set", "is given with a recording", "none",
                         "a block of an experiment takes it, with --block and --format c or fmu")
    signals = None
    if args.signals is not None:
        signals = [name.strip() for name in args.signals.split(",") if name.strip()]
    with progress_bar(f"export {args.recording}") as bar:
        exported = export(args.recording, args.format, args.out, args.trial, signals, bar)
    for note in exported.notes:
        print(f"fesloop: {note}", file=sys.stderr)
    if args.json:
        print_json({"recording": args.recording, "format": args.format, "out": str(exported.path),
                    "files": [str(path) for path in exported.files], "notes": list(exported.notes)})
    else:
        print(exported.path)
    return 0


def _export_block(args: Namespace) -> int:
    from fesloop.experiment.block_code import export_code
    from fesloop.experiment.files.parse import load

    for name in ("trial", "signals"):
        if getattr(args, name) is not None:
            raise InputError(f"--{name}", "is given for a block", "none", "it is for recordings: remove it")
    if args.format not in _OF_BLOCKS:
        raise InputError(f"--format {args.format}", "is a format of recordings", ", ".join(_OF_BLOCKS),
                         "remove --block, or choose one of these")
    if args.block is None:
        raise InputError(
            f"--format {args.format}",
            "is given without --block",
            "the name of a block, as fesloop check prints them",
            "add --block NAME",
        )
    with progress_bar(f"export {args.recording}"):
        experiment = load(args.recording, args.settings)
        path, files = export_code(experiment, args.block, args.format, args.out)
    if args.json:
        print_json(
            {
                "experiment": experiment.name,
                "block": args.block,
                "format": args.format,
                "out": str(path),
                "files": [str(each) for each in files],
            }
        )
    else:
        print(path)
    return 0
