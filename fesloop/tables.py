"""Tables of what an object holds: as plain text, and as HTML for notebooks."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from html import escape
from typing import NamedTuple

_CELL = "padding: .15em .8em .15em 0; border: 0; border-bottom: 1px solid rgba(128, 128, 128, .35); " \
        "vertical-align: top; white-space: pre-wrap;"
"""Colours are those of the page, which may be dark or light."""
_NUMBER = re.compile(r"-?|-?[\d.]+(e[-+]?\d+)?")


class Table(NamedTuple):
    """A table under its title; `folded` in HTML until the reader opens it."""

    title: str
    columns: Sequence[str] = ()
    rows: Sequence[Sequence[str]] = ()
    folded: bool = False


def as_text(tables: Iterable[Table]) -> str:
    """Tables below each other; columns of numbers are aligned to the right."""
    return "\n\n".join(map(_text, tables))


def _text(table: Table) -> str:
    rows = [list(map(str, row)) for row in table.rows]
    if not rows:
        return table.title
    grid = [list(table.columns), *rows] if any(table.columns) else rows
    columns = []
    for number, cells in enumerate(zip(*grid, strict=True)):
        width = max(map(len, cells))
        right = all(_NUMBER.fullmatch(row[number]) for row in rows)
        columns.append([cell.rjust(width) if right else cell.ljust(width) for cell in cells])
    return "\n".join([table.title, *("  ".join(row).rstrip() for row in zip(*columns, strict=True))])


def as_html(tables: Iterable[Table]) -> str:
    """Tables below each other, in the colours of the page, every text escaped."""
    return f'<div style="overflow-x: auto">{"".join(map(_html, tables))}</div>'


def _html(table: Table) -> str:
    title = escape(table.title)
    if not table.rows:
        return f'<p style="margin: .4em 0"><b>{title}</b></p>'
    numeric = [all(_NUMBER.fullmatch(str(row[number])) for row in table.rows)
               for number in range(len(table.columns))]
    head = _row("th", table.columns, numeric) if any(table.columns) else ""
    body = "".join(_row("td", row, numeric) for row in table.rows)
    grid = f'<table style="color: inherit; border-collapse: collapse; margin: .3em 0">{head}{body}</table>'
    if table.folded:
        return f'<details style="margin: .4em 0"><summary><b>{title}</b></summary>{grid}</details>'
    return f'<p style="margin: .4em 0"><b>{title}</b></p>{grid}'


def _row(tag: str, cells: Sequence[object], numeric: Sequence[bool]) -> str:
    shown = (f'<{tag} style="{_CELL} text-align: {"right" if right else "left"}">{escape(str(cell))}</{tag}>'
             for cell, right in zip(cells, numeric, strict=True))
    return f'<tr style="background: none">{"".join(shown)}</tr>'
