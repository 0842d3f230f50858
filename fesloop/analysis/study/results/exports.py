"""A study's table for other tools: pandas, CSV, Parquet."""

from __future__ import annotations

import csv
import importlib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError

Table = Mapping[str, NDArray[Any]]


def to_frame(table: Table) -> Any:
    """The pandas DataFrame of a table; InputError where pandas is not installed."""
    return _extra("pandas").DataFrame(dict(table))


def write_csv(table: Table, path: Path) -> None:
    """Write a table as CSV (RFC 4180), numbers so that they read back the same, what is missing as nothing.

    Raises InputError where the file cannot be written.
    """
    with_text = [[_field(value) for value in column.tolist()] for column in table.values()]

    def write() -> None:
        with path.open("w", encoding="utf-8", newline="") as file:
            lines = csv.writer(file)
            lines.writerow(table)
            lines.writerows(zip(*with_text, strict=True))

    _written(path, write)


def write_parquet(table: Table, path: Path) -> None:
    """Write a table as Parquet; a number that is missing is null, an integer stays one.

    Raises InputError where pyarrow is not installed or the file cannot be written.
    """
    arrow, parquet = _extra("pyarrow"), _extra("pyarrow.parquet")
    columns = {name: arrow.array(column, mask=np.isnan(column)) if column.dtype.kind == "f"
               else arrow.array(column.tolist(), arrow.string()) if column.dtype.kind == "O"
               else arrow.array(column) for name, column in table.items()}
    _written(path, lambda: parquet.write_table(arrow.table(columns), path))


def _field(value: Any) -> str:
    """`repr` of a float is the shortest text that reads back as the same float."""
    if isinstance(value, float):
        return "" if value != value else repr(value)
    return str(value)


def _written(path: Path, write: Callable[[], Any]) -> None:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write()
    except OSError as fault:
        raise InputError(str(path), f"cannot be written: {fault.strerror or fault}",
                         "a place that can be written, with room") from None


def _extra(module: str) -> Any:
    try:
        return importlib.import_module(module)
    except ImportError:
        name = module.partition(".")[0]
        raise InputError(name, "is not installed", f"{name}, of fesloop's extra `study`",
                         "pip install 'fesloop[study]'") from None
