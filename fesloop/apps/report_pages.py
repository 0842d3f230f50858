"""Pages of reports by what is given: a run, several runs, a study, or stimulated muscle."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from fesloop.errors import InputError
from fesloop.given_files import is_file, is_folder

if TYPE_CHECKING:
    from fesloop.show.report.parts import Page


def page_of(sources: Sequence[Path], progress: Callable[[float], None]) -> tuple[str, Page]:
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


def report_path(sources: Sequence[Path], given: str | Path | None) -> Path:
    """Path of the report: beside its source, unless one is given (`--out`)."""
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
