"""What the loop's recorder holds, as the tables of a recording."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.loop.realtime import WallRow
from fesloop.loop.record import BlockRow, EventRow, InputRow, PlantRow

Rows = NDArray[np.void] | NDArray[np.int64]
_STAMP = [("trial", "<i4")]
BLOCK_STAMPS = [*_STAMP, ("index", "<i8"), ("time_ns", "<i8"), ("left_ns", "<i8"), ("oldest_ns", "<i8"),
                ("newest_ns", "<i8")]
PLANT_STAMPS = [*_STAMP, ("time_ns", "<i8"), ("captured_ns", "<i8")]
INPUT_STAMPS = [*_STAMP, ("time_ns", "<i8"), ("oldest_ns", "<i8"), ("newest_ns", "<i8")]
EVENT = np.dtype([*_STAMP, ("time_ns", "<i8"), ("where", "S64"), ("status", "S32"), ("detail", "S224")])
INSTANTS = np.dtype([*_STAMP, ("time_ns", "<i8"), ("late_ns", "<i8"), ("took_ns", "<i8"), ("action", "S8")])
ORIGINS = np.dtype([*_STAMP, ("monotonic_ns", "<i8"), ("utc_ns", "<i8")])
MESSAGES = np.dtype([*_STAMP, ("wire", "<i4"), ("sent", "<i8"), ("lost", "<i8"), ("late", "<i8")])


def _filled(column: Sequence[Any], shape: tuple[int, ...]) -> Any:
    """A column of floats or arrays as one array; concatenating is three times as quick as stacking."""
    return np.concatenate(column).reshape(-1, *shape) if shape else column


def block_rows(dtype: np.dtype[np.void], rows: Sequence[BlockRow], trial: int, kept: Sequence[int]) -> Rows:
    """Rows of a block's steps as one structured array, of its outputs those that are `kept`."""
    table = np.empty(len(rows), dtype)
    if rows:
        table["trial"] = trial
        index, time, left, oldest, newest, outputs = zip(*rows, strict=True)
        stamps = (index, time, left, oldest, newest)
        names, columns = dtype.names or (), tuple(zip(*outputs, strict=True))
        for name, column in zip(names[1:], (*stamps, *(columns[port] for port in kept)), strict=True):
            table[name] = _filled(column, dtype[name].shape)
    return table


def plant_rows(
    dtype: np.dtype[np.void], stacks: Sequence[PlantRow], trial: int, kept: Sequence[int]
) -> Rows:
    """Stacks of a plant's outputs as one structured array, of its outputs those that are `kept`."""
    if not stacks:
        return np.empty(0, dtype)
    times, captured, values = zip(*stacks, strict=True)
    stamps = [np.array(list(chain.from_iterable(column)), np.int64) for column in (times, captured)]
    table = np.empty(stamps[0].size, dtype)
    table["trial"] = trial
    ports = tuple(zip(*values, strict=True))
    columns = [*stamps, *(np.concatenate(ports[port]) for port in kept)]
    for name, column in zip((dtype.names or ())[1:], columns, strict=True):
        table[name] = column
    return table


def input_rows(dtype: np.dtype[np.void], rows: Sequence[InputRow], trial: int) -> Rows:
    """Changes of one plant input as one structured array."""
    table = np.empty(len(rows), dtype)
    table["trial"] = trial
    time, _, oldest, newest, values = zip(*rows, strict=True)
    for name, column in zip((dtype.names or ())[1:-1], (time, oldest, newest), strict=True):
        table[name] = column
    table["value"] = _filled(values, dtype["value"].shape)
    return table


def event_rows(events: Sequence[EventRow], trial: int) -> Rows:
    """Events as one structured array; text too long for its field ends in three dots, no letter cut."""
    def cut(text: str, field: str) -> bytes:
        encoded, size = text.encode(errors="replace"), EVENT[field].itemsize
        if len(encoded) <= size:
            return encoded
        return encoded[:size - 3].decode(errors="ignore").encode() + b"..."

    rows = [(trial, time, cut(where, "where"), cut(status, "status"), cut(detail, "detail"))
            for time, where, status, detail in events]
    return np.array(rows, EVENT)


def instant_rows(rows: Sequence[WallRow], trial: int) -> Rows:
    """How instants went by the wall clock, as one structured array."""
    return np.array([(trial, *stamps, action.encode()) for *stamps, action in rows], INSTANTS)
