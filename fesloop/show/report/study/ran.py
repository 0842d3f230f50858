"""Section of a study's report on its file, its cost and the versions that made its results."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from fesloop.analysis.study.results.quantities import duration_text
from fesloop.analysis.study.results.runs import DONE, FAILED
from fesloop.analysis.study.results.study_results import StudyResults
from fesloop.analysis.study.store.reading import Provenance, provenance_of
from fesloop.errors import FesloopError
from fesloop.forms.toml import toml_text
from fesloop.show.report.parts import Code, Fold, Notice, Paragraph, Part, Section, Table
from fesloop.show.report.run.experiment import without_none
from fesloop.show.report.study.shown import Shown


def ran_section(shown: Shown) -> Section:
    """Section made from the store alone."""
    results = shown.results
    about = results.study.get("study", {})
    parts: list[Part] = [Paragraph(text=about["description"])] if about.get("description") else []
    parts.append(Table(columns=["", ""], rows=[*_counts(results), *_cost(results)]))
    try:
        parts += _who(provenance_of(results.path))
    except FesloopError as fault:
        parts.append(Notice(text=f"{fault}"))
    parts.append(Fold(title="The study's file", parts=[Code(text=toml_text(without_none(results.study)))]))
    parts.append(Fold(title="Its results in Python", parts=[Code(text=(
        "from fesloop.analysis.study import load\n\n"
        f"results = load({str(results.path)!r})\n"
        "results.table()          # a numpy array a column\n"
        f'results.to_csv("{results.name}.csv")\n'))]))
    return Section(key="ran", title="Experiment", parts=parts)


def _counts(results: StudyResults) -> Iterator[list[str]]:
    status = results.runs["status"]
    yield ["experiment", str(results.study.get("study", {}).get("experiment", "?"))]
    for axis, levels in results.axes.items():
        table = results.study.get("axes", {}).get(axis, {})
        kind = "members of a cohort" if table.get("cohort") else "levels"
        yield [f"axis {axis}", f"{len(levels)} {kind}"]
    yield ["replicates", str(len(results.runs["replicate"].unique()))]
    yield ["runs planned", str(results.planned)]
    distinct = results.runs["id"].nunique()
    if distinct < results.planned:
        yield ["distinct among them", f"{distinct}: several cells come to the same experiment"]
    yield ["done, failed, not over yet", f"{np.sum(status == DONE)}, {np.sum(status == FAILED)}, "
                                        f"{results.planned - results.finished}"]


def _cost(results: StudyResults) -> Iterator[list[str]]:
    """Cost of the distinct runs."""
    wall_s = results.runs.drop_duplicates("id")["wall_s"].to_numpy()
    known = wall_s[np.isfinite(wall_s) & (wall_s > 0.0)]
    if len(known):
        yield ["one run", f"{np.median(known):.2f} s (median; {known.min():.2f} to {known.max():.2f})"]
        yield ["all runs, one after the other", duration_text(float(known.sum()))]


def _who(found: Provenance) -> Iterator[Part]:
    """Versions, when and by how many."""
    rows = [["results noted", f"{found.first} to {found.last}" if found.first else "none"],
            ["worker processes, of all sessions", str(found.workers)]]
    yield Table(columns=["", ""], rows=rows)
    used = [(version, count) for version, count in found.versions if count]
    if len(used) > 1:
        yield Notice(text=f"Results are of {len(used)} versions; what differs stands in the table.")
    names = dict.fromkeys(name for version, _ in found.versions for name in version)
    if names:
        yield Fold(title="Versions", parts=[Table(
            columns=["", *(f"{count} results" for _, count in found.versions)],
            rows=[[name, *(version.get(name, "-") for version, _ in found.versions)] for name in names])])
