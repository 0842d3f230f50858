"""A study's page: every section, from its store alone."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path

from fesloop.analysis.study.results.study_results import StudyResults, load, results_of
from fesloop.analysis.study.store.reading import store_path
from fesloop.analysis.study.store.salvage import Salvage, salvaged
from fesloop.errors import FesloopError, InputError
from fesloop.forms.toml import toml_text
from fesloop.show.report.parts import Code, Fold, Notice, Page, Section
from fesloop.show.report.run.experiment import without_none
from fesloop.show.report.study.answer import answer
from fesloop.show.report.study.cells import cells_section, failures_section
from fesloop.show.report.study.figures import figure_sections
from fesloop.show.report.study.paired import paired_section
from fesloop.show.report.study.ran import ran_section
from fesloop.show.report.study.shown import Shown

Build = Callable[[Shown], Iterator[Section] | Section | None]
_SECTIONS: tuple[tuple[str, str, Build], ...] = (
    ("figures", "Figures", figure_sections),
    ("comparisons", "Paired comparisons", paired_section),
    ("cells", "Cells", cells_section),
    ("failures", "Failures", failures_section),
    ("ran", "What was run", ran_section),
)


def study_page(path: str | Path) -> Page:
    """The report of a study, finished or not; `path` is its store or the folder of that.

    Of a store that is damaged what can be read is shown, and what not is said; of one that another version
    wrote, what it says about itself. Raises InputError for what is no study's store.
    """
    store = store_path(path)
    try:
        return _page(load(store), [])
    except InputError as fault:
        found = salvaged(store)
        if not found.lost and "damaged" not in fault.found:
            raise  # as when it stays locked: nothing of it is lost
        lost = found.lost or [str(fault)]
    try:
        return _page(results_of(store, found.rows), lost)
    except InputError:
        return _unreadable(store, found)


def _page(results: StudyResults, lost: list[str]) -> Page:
    shown = Shown(results)
    sections = [section for key, title, build in _SECTIONS for section in _built(shown, key, title, build)]
    if lost:
        notes = [Notice(text=each) for each in lost]
        sections.insert(0, Section(key="lost", title="What could not be read", parts=notes))
    damaged = "Its store is damaged; this is of what can be read. " if lost else ""
    return Page(title=f"{results.name}: a study", sentence=f"{damaged}{_sentence(shown)}",
                facts=list(_facts(results)), sections=sections)


def _sentence(shown: Shown) -> str:
    try:
        return answer(shown)
    except FesloopError as fault:
        return f"What came of it cannot be told: {_line(fault)}"


def _built(shown: Shown, key: str, title: str, build: Build) -> Iterator[Section]:
    """A section or several; one that fails says so in its place, and takes no other with it."""
    try:
        found = build(shown)
        yield from [found] if isinstance(found, Section) else found or ()
    except Exception as fault:  # noqa: BLE001 - whatever a store holds: the rest of the page is worth having
        what = _line(fault) if isinstance(fault, FesloopError) else f"{type(fault).__name__}: {_line(fault)}"
        yield Section(key=key, title=title, parts=[Notice(text=f"This cannot be shown: {what}")])


def _facts(results: StudyResults) -> Iterator[tuple[str, str]]:
    about = results.study.get("study", {})
    yield "study", results.name
    yield "experiment", str(about.get("experiment", "?"))
    yield "runs", f"{results.finished} of {results.planned} over"
    if about.get("design", "grid") != "grid":
        yield "design", str(about["design"])
    yield "seeds", f"from {about.get('seed', 1)} on"
    yield "begun", str(results.about.get("created", "?")).replace("T", " ").replace("+00:00", " UTC")


def _unreadable(path: Path, found: Salvage) -> Page:
    """Of a store whose results cannot be read: what it says about itself."""
    about = found.rows.about
    sections = [Section(key="lost", title="What could not be read",
                        parts=[Notice(text=each) for each in found.lost])]
    try:
        text = toml_text(without_none(dict(json.loads(about["study"]))))
        sections.append(Section(key="ran", title="What was run", parts=[
            Fold(title="The study's file", parts=[Code(text=text)])]))
    except (KeyError, TypeError, ValueError):
        sections[0] = Section(key="lost", title="What could not be read", parts=[
            *sections[0].parts, Notice(text="Nor does it say which study it is of.")])
    return Page(title=f"{about.get('name') or path.parent.name}: a study", sections=sections,
                sentence="Results of this study cannot be read.",
                facts=[(key, about[key]) for key in ("name", "format", "created") if key in about])


def _line(fault: Exception) -> str:
    return " ".join(str(fault).split())
