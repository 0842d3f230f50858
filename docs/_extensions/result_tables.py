"""Tables of committed results, docs/results/NAME.json as `docs/keep_result.py` writes them."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from markdown_text import cell, code, table

from fesloop.apps.reproduce.result import summary_lines

RESULTS = Path(__file__).resolve().parents[1] / "results"
_LONG = 12
"""Rows of a table that is folded away (chosen: more than a small screen has)."""


def result(name: str, folder: Path = RESULTS) -> Iterator[str]:
    """Lines of MyST Markdown on a result: how it was made, its tables; or that there is none."""
    path = folder / f"{name}.json"
    if not path.exists():
        yield from (":::{note}", "No result is kept here: the command above makes it.", ":::", "")
        return
    kept = json.loads(path.read_text())
    found = kept["found"]
    yield from (f"{_count(found)} Made by {code(kept['command'])}, fesloop {kept['version']} "
                f"({code(kept['commit'])}), {kept['day']}.", "")
    yield from _comparison(found) if "paper" in found else _bench(found)


def benches(folder: Path = RESULTS) -> Iterator[str]:
    """Every kept result of a bench, to stand under a heading of the second level; or that there is none."""
    names = [path.stem for path in sorted(folder.glob("*.json"))
             if "bench" in json.loads(path.read_text())["found"]]
    if not names:
        yield from (":::{note}", "No result of a bench is kept here: figures are those of your machine.",
                    ":::", "")
    for name in names:
        yield from (f"### {name}", "", *result(name, folder))


def _count(found: Mapping[str, Any]) -> str:
    if "paper" not in found:
        return ""
    holding, every = sum(row["holds"] for row in found["rows"]), len(found["rows"])
    return f"**{holding} of {every} rows hold.**"


def _comparison(found: Mapping[str, Any]) -> Iterator[str]:
    """Theirs beside ours, a table for each of theirs, fitted and predicted apart, then what is swept."""
    if "summary" in found:
        yield from (f"- {line}" for line in summary_lines(found))
        yield ""
    for part in dict.fromkeys(map(_part, found["rows"])):
        rows = [row for row in found["rows"] if _part(row) == part]
        for name in dict.fromkeys(row["table"] for row in rows):
            group = [row for row in rows if row["table"] == name]
            holding = sum(row["holds"] for row in group)
            yield from _folded(f"{part}{cell(name)}: {holding} of {len(group)} hold",
                               table(("", "theirs", "ours", *_SCORES[part], "holds"), [*map(_line, group)]),
                               len(group))
    for sweep in found["sweeps"].values():
        columns = [key for key in sweep["rows"][0] if key != "row"]
        values = [(cell(row["row"]), *(_figure(row[column]) for column in columns)) for row in sweep["rows"]]
        unit = f", {cell(sweep['unit'])}" if sweep["unit"] else ""
        title = f"{cell(sweep['title'])}{unit}"
        yield from _folded(title, table(("", *map(cell, columns)), values), _LONG + 1)


_OF_FIGURES = ("unit", "PIT", "log score", "baseline's", "band/sd")
_SCORES = {"": ("unit",), "Fitted, ": _OF_FIGURES, "Predicted, ": _OF_FIGURES, "Pattern, ": ("baseline",)}
"""Columns between ours and whether it holds, by part of the comparison."""


def _part(row: Mapping[str, Any]) -> str:
    """Beginning of the title of the table that a row is in: whether the model was fitted to it."""
    scores = row.get("scores")
    return "" if scores is None else f"{scores['half'].capitalize()}, " if "half" in scores else "Pattern, "


def _line(row: Mapping[str, Any]) -> tuple[str, ...]:
    """Cells of a row, with its scores."""
    scores = row.get("scores", {})
    if "share" in scores:
        columns = (f"in {100.0 * scores['baseline_share']:.0f} %",)
    else:
        columns = (cell(row["unit"]), *(_score(scores[key]) for key in
                                        ("pit", "log_score", "baseline_log_score", "band_over_sd") if scores))
    return (cell(row["row"]), _theirs(row["theirs"]), _ours(row["ours"]), *columns,
            "yes" if row["holds"] else "**no**")


def _score(value: float | None) -> str:
    return "" if value is None else f"{value:.2f}"


def _folded(title: str, lines: Iterable[str], length: int) -> Iterator[str]:
    """A table under its title; one that is long is folded away."""
    if length <= _LONG:
        yield from (f"**{title}**", "", *lines)
    else:
        yield from (f":::{{dropdown}} {title}", "", *lines, ":::", "")


def _theirs(value: float | str) -> str:
    return cell(value) if isinstance(value, str) else f"{value:.4g}"


def _ours(value: Mapping[str, float | None] | str) -> str:
    """Median and 5-95 % band, or words."""
    if isinstance(value, str):
        return cell(value)
    return f"{_figure(value['median'])} ({_figure(value['low'])} to {_figure(value['high'])})"


def _figure(value: float | None) -> str:
    """Two decimals; what no number could be is said so."""
    return "none" if value is None else f"{value:.2f}"


def _bench(found: Mapping[str, Any]) -> Iterator[str]:
    """One line a case, every key a column."""
    columns = list(dict.fromkeys(key for row in found["rows"] for key in row))
    rows = [[_entry(row.get(column)) for column in columns] for row in found["rows"]]
    yield from table([cell(column) for column in columns], rows)


def _entry(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else "" if value is None else cell(value)
