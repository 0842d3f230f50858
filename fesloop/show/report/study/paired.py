"""Paired comparisons: difference between two levels of an axis, everything else being the same."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations, pairwise

from fesloop.analysis.study.results.axis_levels import AxisLevel, is_numeric, level_text
from fesloop.analysis.study.results.comparison import Comparison
from fesloop.analysis.study.results.quantities import with_unit
from fesloop.errors import FesloopError
from fesloop.show.report.parts import Fold, Paragraph, Part, Section, Table
from fesloop.show.report.run.words import counted
from fesloop.show.report.study.shown import Shown, value_text

_MOST_EACH = 4
"""Most levels of text for comparison of each with each; of more, each is compared with the first (chosen)."""
_MOST_METRICS = 8
"""Most metrics that are compared (chosen: length of the page)."""
_METHOD = (
    "Runs of one replicate met the same noise in every cell, so a difference between two levels is known "
    "better than either value. Each row is the first level less the second, over pairs of runs that differ "
    "in nothing else; values are independent of each other, and pairs may be several a value. p is two-sided "
    "and not corrected for multiple comparisons: of twenty comparisons without a difference, one has p below "
    "0.05. With four values the signed rank test gives no p below 0.125, with six none below 0.031.")
_COLUMNS = ("first", "second", "difference", "95 % interval", "p", "values", "pairs", "left out")


def paired_section(shown: Shown) -> Section | None:
    """Section with paired comparisons; None if no two levels can be compared."""
    metrics = [shown.metric, *(metric for metric in shown.results.metrics if metric != shown.metric)]
    parts = [part for axis in shown.chosen for part in _of_axis(shown, axis, metrics[:_MOST_METRICS])]
    if not parts or not shown.metric:
        return None
    return Section(key="comparisons", title="Paired comparisons", parts=[Paragraph(text=_METHOD), *parts])


def _of_axis(shown: Shown, axis: str, metrics: list[str]) -> Iterator[Part]:
    """The main metric in a table, the others folded."""
    tables = []
    for metric in metrics:
        found = list(_compared(shown, axis, metric))
        if found:
            name = with_unit(*shown.metric_name(metric)) if found[0].statistic != "share" else \
                shown.metric_name(metric)[0]
            judged = f" ({found[0].interval}; p: {found[0].test})" if any(each.units > 1 for each in found) \
                else ", of one value each: how sure it is is not known"
            tables.append(_without_empty_columns(Table(
                title=f"{with_unit(*shown.axis(axis))}: difference in {name}, {found[0].statistic}{judged}",
                columns=_COLUMNS, rows=[_row(axis, each) for each in found])))
    yield from tables[:1]
    if len(tables) > 1:
        more = counted(len(tables) - 1, "more metric")
        yield Fold(title=f"{shown.axis(axis)[0]}: {more}", parts=tables[1:])


def _without_empty_columns(table: Table) -> Table:
    """The table without empty columns."""
    kept = [number for number in range(len(table.columns))
            if any(row[number] not in ("", "-") for row in table.rows)]
    return Table(title=table.title, columns=[table.columns[number] for number in kept],
                 rows=[[row[number] for number in kept] for row in table.rows])


def _compared(shown: Shown, axis: str, metric: str) -> Iterator[Comparison]:
    """Comparisons of levels that can be paired."""
    for one, other in _pairs(shown.results.axes[axis]):
        try:
            found = shown.results.compare(metric, {axis: one}, {axis: other})
        except FesloopError:
            continue  # sampled points share no levels of other axes
        if found.units:
            yield found


def _pairs(levels: tuple[AxisLevel, ...]) -> Iterator[tuple[AxisLevel, AxisLevel]]:
    """Numbers: each with the one before; few of text: each with each; many: each with the first."""
    if is_numeric(levels):
        yield from ((other, one) for one, other in pairwise(levels))
    elif len(levels) <= _MOST_EACH:
        yield from combinations(levels, 2)
    else:
        yield from ((level, levels[0]) for level in levels[1:])


def _row(axis: str, found: Comparison) -> list[str]:
    share = found.statistic == "share"
    difference = value_text(found.value, found.low, found.high, found.sd, share=share)
    value, _, interval = difference.partition(" (")
    left_out = ", ".join(f"{count} {why}" for why, count in found.dropped.items())
    return [level_text(found.first[axis]), level_text(found.second[axis]), value,
            interval.removesuffix(")") or "-", _p_text(found.p) if found.units > 1 else "-",
            str(found.units), str(found.pairs), left_out]


def _p_text(p: float) -> str:
    return "< 0.001" if p < 0.001 else f"{p:.3f}"
