"""`fesloop export`."""

from __future__ import annotations

import sys
from argparse import Namespace

from fesloop.apps.cli.output import print_json, progress_bar
from fesloop.experiment.export import export


def execute(args: Namespace) -> int:
    """Write a recording in another format; print the path."""
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
