"""Tables of numbers in text files, read exactly: every decimal number becomes the nearest double."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fesloop.errors import InputError
from fesloop.given_files import read_whole
from fesloop.streams.checks import Array
from fesloop.streams.room import Room

_MOST_COLUMNS = 10_000
"""Chosen: 17 sensors with 9 channels and quaternions are 221."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TextForm:
    """How numbers stand in a text file.

    Attributes
    ----------
    separator: between columns: one character; " " is any run of blanks.
    decimal: "." or ",".
    header: lines before the first row; the last of them holds the columns' names. 0: none.
    missing: what stands where there is no number; it becomes NaN.
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


@dataclass(frozen=True, slots=True, eq=False)
class TextTable:
    """A table. `names` are its columns' names, empty without a header; `values` are (rows, columns)."""

    names: tuple[str, ...]
    values: Array


def read_text(path: Path, allowed: str) -> str:
    """All of a text file; InputError, with what is `allowed`, where it cannot be read or is no text."""
    where = str(path)
    try:
        return read_whole(path, allowed).decode("utf-8-sig")
    except UnicodeDecodeError as fault:
        raise InputError(where, f"is not UTF-8 text (byte {fault.start})", allowed) from None


def read_table(path: Path, form: TextForm) -> TextTable:
    """The table in a text file.

    Raises InputError, naming file, line and column, for what is no number and for rows of unequal length.
    """
    where = str(path)
    lines = read_text(path, "a table of numbers").splitlines()
    rows = [line for line in lines[form.header:] if line.strip()]
    if not rows:
        raise InputError(where, f"holds no row after {form.header} lines of header", "one or more rows")
    names = tuple(form.cells(lines[form.header - 1])) if form.header else ()
    columns = len(form.cells(rows[0]))
    if columns > _MOST_COLUMNS:
        raise InputError(where, f"has {columns} columns", f"at most {_MOST_COLUMNS}")
    if names and len(names) != columns:
        raise InputError(f"{where}: line {form.header}", f"names {len(names)} columns, the first row has "
                         f"{columns}", "a name a column", "state in the layout how many lines are header")
    Room(path).take(8 * columns * len(rows), where)
    try:
        values = np.loadtxt(_readable(rows, form), dtype=np.float64, comments=None, quotechar='"', ndmin=2,
                            delimiter=None if form.separator == " " else form.separator)
    except ValueError as fault:
        raise _fault(where, lines, form, columns, names) or InputError(
            where, f"cannot be read: {fault}", "a table of numbers") from None
    if values.shape != (len(rows), columns):
        raise InputError(where, f"gives a table of shape {values.shape}", f"({len(rows)}, {columns})")
    return TextTable(names, values)


def _readable(rows: Sequence[str], form: TextForm) -> Iterator[str]:
    """Rows as NumPy reads them: NaN where a number is missing, a point in every number."""
    marks = tuple(mark for mark in form.missing if mark)
    blank, gap = "" in form.missing and form.separator != " ", form.separator * 2
    for row in rows:
        holes = blank and (gap in row or row[0] == form.separator or row[-1] == form.separator
                           or f"{form.separator} " in row)
        if holes or any(mark in row for mark in marks):
            yield form.separator.join("nan" if cell in form.missing else cell.replace(form.decimal, ".")
                                      for cell in form.cells(row))
        else:
            yield row.replace(form.decimal, ".")


def _fault(where: str, lines: Sequence[str], form: TextForm, columns: int,
           names: Sequence[str]) -> InputError | None:
    """The first thing in the rows that is no number, or the first row of another length."""
    for number, line in enumerate(lines[form.header:], start=form.header + 1):
        cells = form.cells(line) if line.strip() else []
        if cells and len(cells) != columns:
            return InputError(f"{where}: line {number}", f"has {len(cells)} columns, the first row has "
                              f"{columns}", "rows of equal length")
        for column, cell in enumerate(cells):
            try:
                float("nan" if cell in form.missing else cell.replace(form.decimal, "."))
            except ValueError:
                name = repr(names[column]) if names else str(column + 1)
                return InputError(f"{where}: line {number}: column {name}", f"{cell[:40]!r} is no number",
                                  "numbers, or one of the marks for missing ones: "
                                  + ", ".join(repr(mark) for mark in form.missing))
    return None
