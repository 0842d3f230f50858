"""`fesloop report`."""

from __future__ import annotations

import sys
from argparse import Namespace
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fesloop.apps.cli.output import print_json, progress_bar
from fesloop.apps.report_pages import page_of, report_path

if TYPE_CHECKING:
    from fesloop.show.report.parts import Section


def execute(args: Namespace) -> int:
    """Write the report of a run, of several, of a study or of stimulated muscle; print its path."""
    from fesloop.show.report.page import write_page

    sources = [Path(each) for each in args.sources]
    out = report_path(sources, args.out)
    with progress_bar(f"report {sources[0]}") as bar:
        kind, page = page_of(sources, bar)
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
