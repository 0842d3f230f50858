"""Signals and events of a recording as tables of pandas and arrays of xarray.

Signals and events are those of `fesloop.experiment.recording.reading`, whose methods call these functions.
"""

from __future__ import annotations

import importlib
from collections.abc import Iterator, Sequence
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.loop.clock import NS_PER_S

_VECTORS = ("m", "m/s", "m/s^2", "rad/s", "T", "N")
"""Units of ports whose last axis of three is a vector; angles of three joints are none."""


def _components(unit: str, size: int) -> tuple[str, ...]:
    """Names of the components of a vector, a quaternion or a pulse; numbers for anything else."""
    if unit in _VECTORS and size == 3:
        return "x", "y", "z"
    if unit == "1" and size == 4:
        return "w", "x", "y", "z"
    return ("current_a", "width_s") if (unit, size) == ("A,s", 2) else _numbers(size)


def _numbers(size: int) -> tuple[str, ...]:
    return tuple(str(number) for number in range(size))


def _library(name: str) -> Any:
    """Import pandas or xarray. Raises InputError where it is not installed."""
    try:
        return importlib.import_module(name)
    except ImportError:
        raise InputError(name, "is not installed", f"{name}, of fesloop's extra `frames`",
                         "pip install 'fesloop[frames]'") from None


def _axes(signal: Any) -> list[tuple[str, ...]]:
    """Names along each axis of a value: of its rows, then of their components."""
    shape = signal.values.shape[1:]
    names = [_numbers(size) for size in shape]
    if len(shape) == 2:
        names[1] = _components(signal.unit, shape[1])
    if shape and len(signal.rows) == shape[0]:
        names[0] = signal.rows
    elif len(shape) == 1 and signal.unit in ("m", "m/s"):
        names[0] = _components(signal.unit, shape[0])
    return names


def _in_unit(signal: Any, degrees: bool) -> tuple[NDArray[np.float64], str]:
    """Values and their unit; rad and rad/s as degrees where asked."""
    if degrees and signal.unit.startswith("rad"):
        return np.degrees(signal.values), signal.unit.replace("rad", "deg", 1)
    return signal.values, signal.unit


def _stamps(signal: Any) -> Iterator[tuple[str, NDArray[np.float64]]]:
    """Names and values of the stamps, s."""
    for name, stamps in (("captured_oldest_s", signal.oldest_ns), ("captured_newest_s", signal.newest_ns),
                         ("left_s", signal.left_ns)):
        yield name, stamps / NS_PER_S


def signal_frame(signal: Any, *, degrees: bool = False, stamps: bool = False) -> Any:
    """The DataFrame of `Signal.to_dataframe`."""
    pandas = _library("pandas")
    values, unit = _in_unit(signal, degrees)
    port = signal.name.partition(".")[2]
    names = [".".join(each) for each in product(*_axes(signal))]
    columns = names if len(names) > 1 else [signal.rows[0] if signal.rows else port]
    index = pandas.Index(signal.times_ns / NS_PER_S, name="time_s")
    frame = pandas.DataFrame(values.reshape(len(values), -1), index=index, columns=columns)
    frame.attrs.update(signal=signal.name, unit=unit)
    for name, column in _stamps(signal) if stamps else ():
        frame[name] = column
    return frame


def signal_array(signal: Any, *, degrees: bool = False) -> Any:
    """The DataArray of `Signal.to_xarray`."""
    xarray = _library("xarray")
    values, unit = _in_unit(signal, degrees)
    dims = ["time_s", *("row", "component")[:values.ndim - 1]]
    coordinates: dict[str, Any] = {"time_s": signal.times_ns / NS_PER_S}
    coordinates.update(zip(dims[1:], (list(names) for names in _axes(signal)), strict=True))
    coordinates.update((name, ("time_s", column)) for name, column in _stamps(signal))
    return xarray.DataArray(values, dims=dims, coords=coordinates, name=signal.name, attrs={"units": unit})


def event_frame(events: Sequence[Any]) -> Any:
    """DataFrame of events: trial, time_s, where, status, detail."""
    rows = [(each.trial, each.time_ns / NS_PER_S, each.where, each.status, each.detail) for each in events]
    return _library("pandas").DataFrame(rows, columns=["trial", "time_s", "where", "status", "detail"])
