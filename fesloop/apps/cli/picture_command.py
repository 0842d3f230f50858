"""`fesloop picture`."""

from __future__ import annotations

import sys
from argparse import Namespace
from pathlib import Path

from fesloop.apps.cli.output import print_json, progress_bar
from fesloop.errors import InputError
from fesloop.experiment.recording.reading import Recording
from fesloop.streams.stimulation.files import is_stimulation, open_stimulation


def execute(args: Namespace) -> int:
    """Draw a recording; print what could not be drawn, and the files."""
    if is_stimulation(Path(args.recording)):
        return _draw_stimulation(args)
    from fesloop.show.picture.draw import draw

    with progress_bar(f"picture {args.recording}") as bar, Recording(args.recording) as recording:
        drawn = draw(recording, Path(args.out), args.at, args.trial, bar)
    for note in drawn.notes:
        print(f"fesloop: {note}", file=sys.stderr)
    if args.json:
        print_json({"recording": args.recording, "trial": drawn.trial, "instants_s": drawn.instants_s,
                    "chosen": drawn.chosen, "pictures": [str(path) for path in drawn.pictures],
                    "notes": drawn.notes})
    else:
        instants = ", ".join(f"{second:g}" for second in drawn.instants_s)
        print(f"trial {drawn.trial}, counted from 0", file=sys.stderr)
        if instants:
            print(f"instants, s: {instants} ({drawn.chosen})", file=sys.stderr)
        print(*drawn.pictures, sep="\n")
    return 0


def _draw_stimulation(args: Namespace) -> int:
    """Draw a recording of stimulated muscle; print the files."""
    from fesloop.show.picture.stimulation import draw_stimulation

    if args.at or args.trial is not None:
        raise InputError("--at" if args.at else "--trial", "is of recordings of runs",
                         "no such option for a recording of stimulated muscle")
    pictures = draw_stimulation(open_stimulation(args.recording), Path(args.out))
    if args.json:
        print_json({"recording": args.recording, "pictures": [str(path) for path in pictures]})
    else:
        print(*pictures, sep="\n")
    return 0
