"""`fesloop report`."""

from __future__ import annotations

import sys
from argparse import Namespace
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fesloop.apps.cli.output import print_json, progress_bar
from fesloop.errors import InputError
from fesloop.given_files import is_file, is_folder

if TYPE_CHECKING:
    from fesloop.show.report.parts import Page, Section


def execute(args: Namespace) -> int:
    """Write the report of a run, of several, of a study or of stimulated muscle; print its path."""
    from fesloop.show.report.page import write_page

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
    """Kind of the report (run, comparison, study or stimulation), and its page."""
    if any(_is_study(source) for source in sources):
        if len(sources) > 1:
            raise InputError(str(sources[1]), "is given together with a study",
                             "one study, or one or more runs")
        _require_no_runs(sources[0])
        from fesloop.show.report.study.page import study_page

        return "study", study_page(sources[0])
    if len(sources) == 1:
        return _run(sources[0], progress)
    return "comparison", _comparison(sources)


def _require_no_runs(folder: Path) -> None:
    """Raise InputError for a folder of recordings: the user has to choose which of them to compare."""
    if is_folder(folder) and any(folder.glob("*.h5")) and not any(folder.glob("*.sqlite")):
        raise InputError(str(folder), "is a folder of recordings", "recordings by name, or a study's folder",
                         f"fesloop report {folder}/NAME.h5")


def _is_study(source: Path) -> bool:
    return is_folder(source) or source.suffix == ".sqlite"


def _run(source: Path, progress: Callable[[float], None]) -> tuple[str, Page]:
    """Page of a run, or of stimulated muscle; of another HDF5 file the list of its contents."""
    from fesloop.show.report.run.opening import contents_page, readable
    from fesloop.show.report.run.page import run_page

    with ExitStack() as stack:
        try:
            recording, notices = stack.enter_context(readable(source))
        except InputError as fault:
            if not is_file(source):
                raise
            from fesloop.streams.stimulation.files import is_stimulation, open_stimulation

            if is_stimulation(source):
                from fesloop.show.report.stimulated import stimulation_page

                return "stimulation", stimulation_page(open_stimulation(source), source)
            return "run", contents_page(source, fault)
        return "run", run_page(recording, notices, progress)


def _comparison(sources: Sequence[Path]) -> Page:
    """Page that compares several runs; begins with what damaged files lack."""
    from fesloop.show.report.comparison.page import comparison_page
    from fesloop.show.report.parts import Notice, Section
    from fesloop.show.report.run.opening import readable

    with ExitStack() as stack:
        opened = [(source, *stack.enter_context(readable(source))) for source in sources]
        page = comparison_page([recording for _, recording, _ in opened])
    lost = [Notice(text=f"{source.name}: {text}") for source, _, notices in opened for text in notices]
    if not lost:
        return page
    return replace(page, sections=[Section(key="damaged", title="Damaged files", parts=lost), *page.sections])


def _out(sources: Sequence[Path], given: str | None) -> Path:
    """Path of the report: beside its source, unless --out is given."""
    if given is not None:
        out = Path(given)
        if out.suffix.lower() not in (".html", ".htm"):
            raise InputError(f"--out {given}", "is not the name of an HTML file", "a name that ends in .html")
        return out
    first = sources[0]
    if _is_study(first):
        return (first if is_folder(first) else first.parent) / "report.html"
    if len(sources) == 1:
        return first.with_suffix(".html")
    others = sources[1].stem if len(sources) == 2 else f"{len(sources) - 1}_more"
    return first.with_name(f"{first.stem}_and_{others}.html")


def _notes(sections: Sequence[Section]) -> Iterator[str]:
    """Texts of all notices on the page."""
    from fesloop.show.report.parts import Fold, Notice

    def within(parts: Sequence[Any]) -> Iterator[str]:
        for part in parts:
            if isinstance(part, Notice):
                yield part.text
            elif isinstance(part, Fold):
                yield from within(part.parts)

    for section in sections:
        yield from within(section.parts)
