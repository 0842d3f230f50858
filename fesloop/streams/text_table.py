"""Tables of numbers in text files, read exactly: every decimal number becomes the nearest double."""

from __future__ import annotations

import csv
from collections.abc import Collection, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fesloop.errors import InputError
from fesloop.given_files import read_whole
from fesloop.streams.checks import Array
from fesloop.streams.reading import read_file

_MOST_COLUMNS = 10_000
"""Chosen: 17 sensors with 9 channels and quaternions are 221."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TextForm:
    """Form of numbers in a text file.

    Attributes
    ----------
    separator: one character between columns; " " is any run of blanks.
    decimal: "." or ",".
    header: lines before the first row; the last of them holds the columns' names. 0: none.
    missing: marks for a missing number, which becomes NaN.
    """

    separator: str = ","
    decimal: str = "."
    header: int = 1
    missing: tuple[str, ...] = ("", "n/a", "NaN", "nan")

    def __post_init__(self) -> None:
        if len(self.separator) != 1 or self.separator in "\"\n\r." or self.separator.isalnum():
            raise InputError("separator", f"{self.separator!r}",
                             'one character, such as "," ";" "\\t" or " "')
        if self.decimal not in (".", ",") or self.decimal == self.separator:
            raise InputError("decimal", f"{self.decimal!r}", '"." or ",", another than the separator')
        if self.header < 0:
            raise InputError("header", f"{self.header}", "0 or more lines")
        if any(self.separator in mark for mark in self.missing if mark):
            raise InputError("missing", "holds the separator", "marks without it")

    def cells(self, line: str) -> list[str]:
        """Cells of a line, without blanks and quotes around them."""
        parts = line.split() if self.separator == " " else line.split(self.separator)
        return [part.strip().strip('"') for part in parts]

    def number(self, cell: str) -> float:
        """Number in a cell, NaN for a missing one; raises ValueError for anything else."""
        if cell in self.missing:
            return float("nan")
        if "_" in cell:
            raise ValueError  # Python's numbers may hold one
        return float(cell.replace(self.decimal, "."))


@dataclass(frozen=True, slots=True, eq=False)
class TextTable:
    """A table. `names` are its columns' names, empty without a header; `values` are (rows, columns)."""

    names: tuple[str, ...]
    values: Array


def read_text(path: Path, allowed: str, where: str = "") -> str:
    """All of a text file; InputError, with what is `allowed`, where it cannot be read or is no text."""
    try:
        return read_whole(path, allowed).decode("utf-8-sig")
    except UnicodeDecodeError as fault:
        raise InputError(where or str(path), f"is not UTF-8 text (byte {fault.start})", allowed) from None


def read_table(path: Path, form: TextForm) -> TextTable:
    """The table in a text file.

    Raises InputError, naming file, line and column, for what is no number and for rows of unequal length.
    """
    found = read_file("table", path, **asdict(form))
    return TextTable(tuple(found["names"]), found["values"])


def read_columns(path: Path, form: TextForm, texts: Collection[str]) -> dict[str, Any]:
    """Columns of a table in a text file by name; `texts` names those that hold text.

    `line` holds the line of each row, `columns` the columns: (rows,) numbers, or a list of texts. Quotes are
    those of RFC 4180. Raises InputError as `read_table` does, and for a name that is given twice.
    """
    found: dict[str, Any] = read_file("columns", path, texts=sorted(texts), **asdict(form))
    return found


def parse_columns(path: Path, where: str, texts: Sequence[str], **form: Any) -> dict[str, Any]:
    """Columns of a table, by `read_columns`' rules; runs in the reader process."""
    text_form = TextForm(**{**form, "missing": tuple(form["missing"])})
    content = read_text(path, "a table with a line of names", where)
    before = max(text_form.header - 1, 0)
    reader = csv.reader((line.strip(" ") for line in content.splitlines()[before:]), strict=True,
                        delimiter=text_form.separator, skipinitialspace=True)
    rows, lines = [], []
    try:
        for cells in reader:
            if any(cell.strip() for cell in cells):
                rows.append([cell.strip() for cell in cells])
                lines.append(before + reader.line_num)
    except csv.Error as fault:
        raise InputError(f"{where}: line {before + reader.line_num}", f"is no row: {fault}",
                         "rows of cells") from None
    if len(rows) > 1 and not any(cells[-1] for cells in rows):
        rows = [cells[:-1] for cells in rows]  # a separator behind the last cell of every line
    if len(rows) < 2:
        raise InputError(where, "holds no row after its names" if rows else "is empty", "one or more rows")
    names = rows[0]
    for name in names:
        if names.count(name) > 1 or not name:
            raise InputError(f"{where}: line {lines[0]}", f"column {name!r} is given twice" if name
                             else "has a column without a name", "a name a column, each once")
    for cells, line in zip(rows[1:], lines[1:], strict=True):
        if len(cells) != len(names):
            raise InputError(f"{where}: line {line}", f"has {len(cells)} columns, {len(names)} are named",
                             "rows of equal length")
    columns: dict[str, Any] = {}
    for name, column in zip(names, zip(*rows[1:], strict=True), strict=True):
        columns[name] = list(column) if name in texts else np.array([
            _number(cell, text_form, f"{where}: line {line}: column {name!r}")
            for cell, line in zip(column, lines[1:], strict=True)])
    return {"line": np.array(lines[1:]), "columns": columns}


def _number(cell: str, form: TextForm, place: str) -> float:
    """Number in a cell; InputError for anything else."""
    try:
        return form.number(cell)
    except ValueError:
        marks = ", ".join(repr(mark) for mark in form.missing)
        raise InputError(place, f"{cell[:40]!r} is no number",
                         f"numbers, or one of the marks for missing ones: {marks}") from None


def parse_table(path: Path, where: str, **form: Any) -> dict[str, Any]:
    """Names and values of a table, by `read_table`'s rules; runs in the reader process.

    NumPy reads a table that is plain. It knows no marks for missing numbers and no decimal comma, and names
    neither line nor column of a fault, so that any other table is read cell by cell.
    """
    text_form = TextForm(**{**form, "missing": tuple(form["missing"])})
    text = read_text(path, "a table of numbers", where)
    lines = text.splitlines()
    numbered = [(number, line) for number, line in enumerate(lines, start=1)
                if number > text_form.header and line.strip()]
    if not numbered:
        raise InputError(where, f"holds no row after {text_form.header} lines of header", "one or more rows")
    names = tuple(text_form.cells(lines[text_form.header - 1])) if text_form.header else ()
    rows = [line for _, line in numbered]
    if not names or not names[-1] or len(names) < len(text_form.cells(rows[0])):
        rows = _without_last_separator(rows, text_form.separator)
    columns = len(text_form.cells(rows[0]))
    if names and not names[-1] and len(names) == columns + 1:
        names = names[:-1]
    if columns > _MOST_COLUMNS:
        raise InputError(where, f"has {columns} columns", f"at most {_MOST_COLUMNS}")
    if names and len(names) != columns:
        raise InputError(f"{where}: line {text_form.header}", f"names {len(names)} columns, the first row "
                         f"has {columns}", "a name a column", "state in the layout how many lines are header")
    marks = [mark for mark in text_form.missing if mark and mark.lower() != "nan"]
    if text_form.decimal == "." and not any(mark in text for mark in marks):
        try:
            values = np.loadtxt(rows, comments=None, quotechar='"', ndmin=2,
                                delimiter=None if text_form.separator == " " else text_form.separator)
            return {"names": names, "values": values}
        except ValueError:
            pass  # it holds missing numbers or faults
    places = [number for number, _ in numbered]
    return {"names": names, "values": _cell_by_cell(rows, places, text_form, columns, names, where)}


def _without_last_separator(rows: list[str], separator: str) -> list[str]:
    """Rows without the separator behind their last cell, where every one has it: it ends no column."""
    ended = [row.rstrip(" ") for row in rows]
    return [row[:-1] for row in ended] if all(row.endswith(separator) for row in ended) else rows


def _cell_by_cell(rows: Sequence[str], places: Sequence[int], form: TextForm, columns: int,
                  names: Sequence[str], where: str) -> Array:
    """Values of the rows, at lines `places`; InputError for what is no number or no row."""
    values = []
    for number, line in zip(places, rows, strict=True):
        cells = form.cells(line)
        if len(cells) != columns:
            raise InputError(f"{where}: line {number}", f"has {len(cells)} columns, the first row has "
                             f"{columns}", "rows of equal length")
        values.append([_number(cell, form, f"{where}: line {number}: column "
                               f"{repr(names[column]) if names else column + 1}")
                       for column, cell in enumerate(cells)])
    return np.array(values)
