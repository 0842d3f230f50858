"""Numbers and instants as text that reads back as the same numbers."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np
from numpy.typing import NDArray

from fesloop.experiment.recording.signal_table import Piece
from fesloop.loop.clock import NS_PER_S
from fesloop.loop.signals import NEVER


def seconds(times_ns: NDArray[np.int64], never: str) -> list[str]:
    """Instants as s with nine decimals, exact; `never` in place of what was not captured at all."""
    return [never if time == NEVER else f"-{instant(-time)}" if time < 0 else instant(time)
            for time in times_ns.tolist()]


def instant(time_ns: int) -> str:
    """One instant, not below 0, as s with nine decimals."""
    whole, rest = divmod(time_ns, NS_PER_S)
    return f"{whole}.{rest:09d}"


def numbers(values: NDArray[np.float64], missing: str) -> Iterator[list[str]]:
    """Rows of values (n, ...) as text: `repr` is the shortest that reads back as the same float."""
    rows = values.reshape(len(values), -1)
    if np.isnan(rows).any():
        return ([missing if number != number else repr(number) for number in row] for row in rows.tolist())
    return (list(map(repr, row)) for row in rows.tolist())


def lines(columns: Iterable[Iterable[str]], rows: Iterator[list[str]], separator: str) -> str:
    """Lines of leading columns and of rows of numbers."""
    leading = zip(*columns, strict=True)
    return "".join(f"{separator.join((*first, *row))}\n" for first, row in zip(leading, rows, strict=True))


def side_by_side(piece: Piece) -> NDArray[np.float64]:
    """Values of all signals of a piece, (n, channels)."""
    return np.concatenate([values.reshape(len(values), -1) for values in piece.values], axis=1)
