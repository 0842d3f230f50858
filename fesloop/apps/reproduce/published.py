"""Published figures, each with its spread and sample, read from published/PAPER.csv.

Every figure is fitted or predicted: an error model is fitted to the fitted half alone, before the other half
is simulated. Fitted are, of Salchow-Hoemmen et al. 2019, movements P1 and P3 of Table 7 and A (abduction) of
Table 6; of Kortier et al. 2014, flexion in Table 2 and the flat hand in Table 3. All other movements and
postures are predicted, so the two halves have no trial in common.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Collection
from dataclasses import dataclass
from importlib.resources import files
from io import StringIO
from typing import Literal, get_args

import numpy as np

from fesloop.errors import InputError

Half = Literal["fitted", "predicted"]
HALVES: tuple[Half, ...] = get_args(Half)
_COLUMNS = ("table", "row", "value", "unit", "n", "of", "spread", "each", "half")
_OF = ("subjects", "trials", "contacts")
_FOLDER = "published"


@dataclass(frozen=True, slots=True, kw_only=True)
class Published:
    """A published figure.

    Attributes
    ----------
    table, row: where it is, and its name.
    value, unit: of it.
    n, of: number of subjects, trials or contacts whose mean it is.
    spread: standard deviation over these, as printed or of `each`; NaN where none is published.
    each: value of each subject, (n,), where printed.
    half: whether error models are fitted to it.
    """

    table: str
    row: str
    value: float
    unit: str
    n: int
    of: str
    spread: float
    each: tuple[float, ...]
    half: Half

    @property
    def key(self) -> str:
        """Unique name in the paper."""
        return f"{self.table}: {self.row}"

    @property
    def subjects(self) -> int:
        """Number of subjects whose mean it is."""
        return self.n if self.of == "subjects" else 1


def published(paper: str, expected: Collection[str]) -> dict[str, Published]:
    """Read the figures of a paper by key, which must be those expected.

    Raises InputError for rows that are missing, unknown, doubled or malformed.
    """
    name = f"{paper}.csv"
    return read(files(__package__).joinpath(_FOLDER, name).read_text(), name, expected)


def read(text: str, name: str, expected: Collection[str]) -> dict[str, Published]:
    """Read a table of figures by key; see `published`. `name` is that of the file, for messages."""
    lines = csv.reader(StringIO(text), strict=True)
    try:
        cells = [(f"{name}, line {lines.line_num}", each) for each in lines if each]
    except csv.Error as fault:
        raise InputError(f"{name}, line {lines.line_num}", str(fault), "comma-separated values") from None
    first = tuple(cells[0][1]) if cells else ()
    if first != _COLUMNS:
        raise InputError(f"{name}, line 1", f"columns {', '.join(first)}" if first else "no columns",
                         ", ".join(_COLUMNS))
    figures: dict[str, Published] = {}
    for where, each in cells[1:]:
        if len(each) != len(_COLUMNS):
            raise InputError(where, f"{len(each)} cells", f"{len(_COLUMNS)}, as the first line")
        figure = _figure(dict(zip(_COLUMNS, each, strict=True)), where)
        if figure.key in figures:
            raise InputError(where, f"{figure.key!r} is listed twice", "one line a figure")
        if figure.key not in expected:
            raise InputError(where, f"{figure.key!r} is no figure that is reproduced", ", ".join(expected))
        figures[figure.key] = figure
    missing = [key for key in expected if key not in figures]
    if missing:
        raise InputError(name, f"{len(missing)} missing: {', '.join(missing)}", "a line for each figure")
    return figures


def _figure(line: dict[str, str], where: str) -> Published:
    value = _number(line, "value", where)
    n = _number(line, "n", where)
    if n != int(n) or n < 1:
        raise InputError(f"{where}, n", f"{n:g}", "a whole number from 1")
    each = tuple(_positive(text, f"{where}, each") for text in line["each"].split())
    if line["of"] not in _OF:
        raise InputError(f"{where}, of", repr(line["of"]), ", ".join(_OF))
    if line["half"] not in HALVES:
        raise InputError(f"{where}, half", repr(line["half"]), ", ".join(HALVES))
    if each and (len(each) != n or line["spread"]):
        raise InputError(where, f"{len(each)} values in each, n {n:g}, spread {line['spread']!r}",
                         "n values in each, and no spread beside them")
    spread = _number(line, "spread", where) if line["spread"] else math.nan
    if len(each) > 1:
        spread = float(np.std(each, ddof=1))
    return Published(table=line["table"], row=line["row"], value=value, unit=line["unit"], n=int(n),
                     of=line["of"], spread=spread, each=each, half=line["half"])


def _number(line: dict[str, str], column: str, where: str) -> float:
    return _positive(line[column], f"{where}, {column}")


def _positive(text: str, where: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0.0 < value < math.inf:
        raise InputError(where, repr(text), "a number above 0")
    return value
