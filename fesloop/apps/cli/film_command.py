"""`fesloop film`."""

from __future__ import annotations

import re
import sys
from argparse import Namespace
from pathlib import Path

from fesloop.apps.cli.output import print_json, progress_bar
from fesloop.errors import InputError
from fesloop.experiment.recording.reading import Recording
from fesloop.show.film.opengl import require_opengl


def execute(args: Namespace) -> int:
    """Film a recording; print what is not shown, and the file."""
    width, height = size_of(args.size)
    require_opengl()
    from fesloop.show.film.film import Cut, film

    cut = Cut(trial=args.trial, from_s=args.begin, until_s=args.until, fps=args.fps, width=width,
              height=height, speed=args.speed)
    out = Path(args.out) if args.out else Path(args.recording).with_suffix(".mp4")
    with progress_bar(f"film {args.recording}") as bar, Recording(args.recording) as recording:
        filmed = film(recording, out, cut, bar)
    for note in filmed.notes:
        print(f"fesloop: {note}", file=sys.stderr)
    if args.json:
        print_json({"recording": args.recording, "film": str(filmed.path), "trial": filmed.trial,
                    "from_s": filmed.from_s, "until_s": filmed.until_s, "fps": filmed.fps,
                    "pictures": filmed.pictures, "notes": list(filmed.notes)})
    else:
        print(f"trial {filmed.trial}, counted from 0, {filmed.from_s:g} to {filmed.until_s:g} s: "
              f"{filmed.pictures} pictures, {filmed.fps:g} per second", file=sys.stderr)
        print(filmed.path)
    return 0


def size_of(text: str) -> tuple[int, int]:
    """Width and height, pixels, of a text such as 1280x720. Raises InputError for another text."""
    found = re.fullmatch(r"([0-9]{1,5})[x×]([0-9]{1,5})", text)
    if found is None:
        raise InputError(f"--size {text}", "is no size of a picture", "WIDTHxHEIGHT, such as 1280x720")
    return int(found[1]), int(found[2])
