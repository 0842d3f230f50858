"""What files of OpenSim have in common: `key=value` lines, `endheader`, labels, rows between tabs.

A label with white space would be two.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from pathlib import Path

from fesloop.experiment.export.rates import rate_of_stamps
from fesloop.experiment.export.selection import Selection
from fesloop.experiment.export.target import file_name, lines, seconds, unique
from fesloop.experiment.recording.signal_table import Piece, SignalTable, TableSignal

NO_NUMBER = "nan"


def labels(points: Sequence[str]) -> list[str]:
    """Names of columns, each once, without white space or what tells keys from values."""
    return unique([re.sub(r"[\s=,]+", "_", point) or "value" for point in points])


def each_signal(selection: Selection) -> Iterator[tuple[SignalTable, TableSignal, str]]:
    """Every chosen signal of every trial, alone in a table, and what its file is called."""
    files = unique([file_name(name) for name in selection.signals])
    for trial in selection.trials:
        for name, file in zip(selection.signals, files, strict=True):
            (table,) = selection.recording.tables([name], trial)
            yield table, table.signals[0], f"{selection.prefix(trial)}{file}"


def write_file(path: Path, header: Sequence[str], columns: Sequence[str], table: SignalTable,
               rows: Iterator[tuple[Piece, Iterator[list[str]]]]) -> None:
    """Header, labels and rows, time in s before each."""
    with path.open("w", encoding="utf-8", newline="\n") as file:
        file.write("".join(f"{line}\n" for line in (*header, "endheader", "\t".join(("time", *columns)))))
        for piece, content in rows:
            file.write(lines([seconds(piece.times_ns, NO_NUMBER)], content, "\t"))


def uneven(table: SignalTable, name: str) -> list[str]:
    """A note where a signal's instants are not evenly spaced."""
    if table.count < 2 or rate_of_stamps(table.times_ns()).even:
        return []
    return [f"{name}, trial {table.trial}: instants are not evenly spaced, which some tools of OpenSim want"]
