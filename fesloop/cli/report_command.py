"""`fesloop report`."""

from __future__ import annotations

import importlib
import sys
from argparse import Namespace
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fesloop.cli.output import print_json, progress_bar
from fesloop.errors import InputError

if TYPE_CHECKING:
    from fesloop.report.parts import Page, Section

_STORE = "study.sqlite"


def execute(args: Namespace) -> int:
    """Make the report of a run, of several, or of a study; print the file's path."""
    from fesloop.report.page import write_page

    sources = [Path(each) for each in args.sources]
    out = _out(sources, args.out)
    with progress_bar(f"report {sources[0]}") as bar:
        kind, page = _page(sources, bar)
        write_page(page, out)
    notes = list(dict.fromkeys(_notes(page.sections)))
    for note in notes:
        print(f"fesloop: {note}", file=sys.stderr)
    print(page.sentence, file=sys.stderr)
    if args.json:
        print_json({"report": str(out), "kind": kind, "sources": [str(each) for each in sources],
                    "sentence": page.sentence, "sections": [section.key for section in page.sections],
                    "notes": notes, "bytes": out.stat().st_size})
    else:
        print(out)
    return 0


def _page(sources: Sequence[Path], progress: Callable[[float], None]) -> tuple[str, Page]:
    """What kind of report it is, and the page."""
    study = _study(sources[0])
    if study is not None:
        if len(sources) > 1:
            raise InputError(str(sources[1]), "stands beside a study", "one study, or one or more runs")
        return "study", _made("study", "study_page")(study)
    if len(sources) == 1:
        return "run", _run(sources[0], progress)
    from fesloop.experiment.recording.reading import Recording

    with ExitStack() as stack:
        recordings = [stack.enter_context(Recording(each)) for each in sources]
        return "comparison", _made("comparison", "comparison_page")(recordings)


def _run(source: Path, progress: Callable[[float], None]) -> Page:
    """A run's page; of another HDF5 file what is in it."""
    from fesloop.report.run.contents import contents_page
    from fesloop.report.run.opening import readable
    from fesloop.report.run.page import run_page

    with ExitStack() as stack:
        try:
            recording, notices = stack.enter_context(readable(source))
        except InputError as fault:
            if not source.is_file():
                raise
            return contents_page(source, fault)
        return run_page(recording, notices, progress)


def _made(room: str, name: str) -> Callable[[Any], Page]:
    """The function that makes a kind of page."""
    try:
        module = importlib.import_module(f"fesloop.report.{room}.page")
    except ModuleNotFoundError:
        raise InputError(f"report of a {room}", "is not there yet", "one run") from None
    made: Callable[[Any], Page] = getattr(module, name)
    return made


def _study(source: Path) -> Path | None:
    """The store of a study, where that, its folder or a file beside it was given."""
    if source.is_dir():
        if not (source / _STORE).is_file():
            raise InputError(str(source), f"is a folder without a {_STORE}",
                             "a recording, or the folder of a study")
        return source / _STORE
    return source if source.suffix == ".sqlite" else None


def _out(sources: Sequence[Path], given: str | None) -> Path:
    """Where the report goes: beside what it is of, unless told otherwise. Never over a recording."""
    if given is not None:
        out = Path(given)
        if out.suffix.lower() not in (".html", ".htm"):
            raise InputError(f"--out {given}", "is no name of a page", "a name that ends in .html")
        return out
    first = sources[0]
    if first.is_dir() or first.suffix == ".sqlite":
        return (first if first.is_dir() else first.parent) / "report.html"
    if len(sources) == 1:
        return first.with_suffix(".html")
    return first.with_name(f"{first.stem}_and_{len(sources) - 1}_more.html")


def _notes(sections: Sequence[Section]) -> Iterator[str]:
    """What the page says it lacks."""
    from fesloop.report.parts import Fold, Notice

    def within(parts: Sequence[Any]) -> Iterator[str]:
        for part in parts:
            if isinstance(part, Notice):
                yield part.text
            elif isinstance(part, Fold):
                yield from within(part.parts)

    for section in sections:
        yield from within(section.parts)
