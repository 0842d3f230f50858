"""A study's page: every section, from its store alone."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

from fesloop.analysis.study.results.study_results import StudyResults, load
from fesloop.analysis.study.store.reading import store_path
from fesloop.errors import FesloopError, InputError
from fesloop.show.report.parts import Notice, Page, Section
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

    Where rows of a store are not those that fesloop wrote, the page shows them and says so. Raises InputError
    for a file that is no study's store, or that SQLite cannot read.
    """
    store = store_path(path)
    try:
        return _page(load(store), "")
    except InputError as fault:
        try:
            results = load(store, check=False)
        except InputError:
            raise fault from None
        return _page(results, str(fault))


def _page(results: StudyResults, damage: str) -> Page:
    shown = Shown(results)
    sections = [section for key, title, build in _SECTIONS for section in _built(shown, key, title, build)]
    if damage:
        sections.insert(0, Section(key="damage", title="Damage", parts=[Notice(text=damage)]))
    warning = "Its store is damaged: the results are not reliable. " if damage else ""
    return Page(title=f"{results.name}: a study", sentence=f"{warning}{_sentence(shown)}",
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


def _line(fault: Exception) -> str:
    return " ".join(str(fault).split())
