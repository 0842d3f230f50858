"""Report page of a study, made from its store, and its summary."""


from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from fesloop.analysis.study.results.estimates import Estimate
from fesloop.analysis.study.results.study_results import StudyResults, load
from fesloop.analysis.study.store.reading import store_path
from fesloop.errors import FesloopError, InputError
from fesloop.show.report.parts import Notice, Page, Section
from fesloop.show.report.run.words import counted, listed
from fesloop.show.report.study.cells import cells_section, failures_section
from fesloop.show.report.study.figures import figure_sections
from fesloop.show.report.study.paired import paired_section
from fesloop.show.report.study.ran import ran_section
from fesloop.show.report.study.shown import Shown


def answer(shown: Shown) -> str:
    """Summary: axes of the study, and cells with the best and the worst value of the main metric."""
    return " ".join(filter(None, (_question(shown), _state(shown), _found(shown))))


def _question(shown: Shown) -> str:
    results = shown.results
    base = results.study.get("study", {}).get("experiment", "an experiment")
    axes = [f"{shown.axis(axis)[0]} ({counted(len(levels), 'level')})"
            for axis, levels in results.axes.items() if len(levels) > 1]
    if not axes:
        return f"`{base}` was repeated."
    sampled = results.study.get("study", {}).get("design", "grid") != "grid"
    names = [shown.axis(axis)[0] for axis, levels in results.axes.items() if len(levels) > 1]
    varied = f"over {counted(results.runs['cell'].nunique(), 'point')} of {listed(names)}" if sampled \
        else f"over {listed(axes)}"
    return f"`{base}` was run {varied}."


def _state(shown: Shown) -> str:
    """Sentence on unfinished runs."""
    results = shown.results
    if not results.planned:
        return "No run is planned."
    left = results.planned - results.finished
    if left == results.planned:
        return f"None of its {counted(results.planned, 'run')} is over yet."
    return f"{left} of its {results.planned} runs are not over yet; this is of the others." if left else ""


def _found(shown: Shown) -> str:
    """The best and the worst cell; the lowest and the highest where the good end is not known."""
    if not shown.metric:
        return ""
    cells = [cell for cell in shown.results.cells(shown.metric) if np.isfinite(cell.value)]
    name, unit = shown.metric_name(shown.metric)
    if not cells:
        return f"No run gave {name}." if shown.results.finished else ""
    low, high = (end(cells, key=lambda cell: cell.value) for end in (min, max))
    whole = f", 95 % intervals by {low.interval}" if np.isfinite(low.high - low.low) else ""
    if len(cells) == 1 or low.value == high.value:
        return f"{_upper(name)} is {_quantity(shown, low, unit)}{' everywhere' if len(cells) > 1 else ''}."
    if shown.better is None:
        first, second, words = low, high, ("lowest", "highest")
    else:
        first, second = (low, high) if shown.better == "low" else (high, low)
        words = ("best", "worst")
    return (f"{_upper(name)} is {words[0]} at {shown.place(first.levels)}: {_quantity(shown, first, unit)}; "
            f"{words[1]} at {shown.place(second.levels)}: {_quantity(shown, second, unit)}{whole}.")


def _quantity(shown: Shown, cell: Estimate, unit: str) -> str:
    """A value with its unit before the interval."""
    value, _, interval = shown.value(cell).partition(" (")
    with_unit = value if cell.statistic == "share" or not unit else f"{value} {unit}"
    return with_unit + (f" ({interval}" if interval else "")


def _upper(name: str) -> str:
    return name[:1].upper() + name[1:]


Build = Callable[[Shown], Iterator[Section] | Section | None]
_SECTIONS: tuple[tuple[str, str, Build], ...] = (
    ("figures", "Figures", figure_sections),
    ("comparisons", "Paired comparisons", paired_section),
    ("cells", "Cells", cells_section),
    ("failures", "Failures", failures_section),
    ("ran", "Experiment", ran_section),
)


def study_page(path: str | Path) -> Page:
    """The report of a study, finished or not; `path` is its store or the folder of that.

    Rows of a store that fesloop did not write are shown with a notice. Raises InputError
    for a file that is not a study's store, or that SQLite cannot read.
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
        return f"The result is not known: {_line(fault)}"


def _built(shown: Shown, key: str, title: str, build: Build) -> Iterator[Section]:
    """One section or several; one that fails is replaced by a notice, and the others are shown."""
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
