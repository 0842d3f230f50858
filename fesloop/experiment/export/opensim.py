"""OpenSim export: joint angles as motions (.mot) and orientations as tables of quaternions (.sto).

Both have `key=value` lines, `endheader`, labels without white space, and rows between tabs.

A motion has joint angles in degrees:

    <signal>
    version=1
    nRows=<rows>
    nColumns=<columns, time among them>
    inDegrees=yes

    endheader
    time <tab> <joint angle> ...

Its columns have the names of the freedoms of the segment tree, such as `F2_mcp_flexion`: flexion about z,
abduction about x, pronation about y of each segment's frame. OpenSim takes a column for the coordinate of the
same name; for a model with other names rename the columns, or the model's coordinates.

A table of quaternions is one that OpenSense reads:

    DataRate=<Hz>
    DataType=Quaternion
    version=3
    OpenSimVersion=4.1
    endheader
    time <tab> <segment>_imu ...
    <s> <tab> w,x,y,z ...

Its quaternions rotate the segment's (or sensor's) frame into the earth's with z up, as in the recording.
OpenSim's ground has y up: its tools take `sensor_to_opensim_rotations` = -1.5707963267948966 0 0, as their
own example for Xsens sensors has. OpenSense ties a column NAME_imu to the model's body NAME.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.experiment.export.channels import quantity
from fesloop.experiment.export.rates import rate_of_stamps
from fesloop.experiment.export.selection import Selection
from fesloop.experiment.export.target import file_name, lines, numbers, seconds, unique
from fesloop.experiment.recording.reading import Piece, SignalTable, TableSignal

_NO_NUMBER = "nan"
_VERSION = "4.1"
"""Version of OpenSim: the first with OpenSense."""


def are_joint_angles(signal: TableSignal) -> bool:
    """Return whether a signal is the joint angles of a plant, tracker or reference."""
    return quantity(signal) == "joint_angle" and signal.port == "angles"


def write_mot(selection: Selection, folder: Path) -> list[str]:
    """Write joint angles, a file for each signal and trial; return notes.

    Raises InputError for a signal that is no vector of angles.
    """
    notes = []
    for table, signal, name in _each_signal(selection):
        if quantity(signal) != "joint_angle":
            raise InputError(f"--signals: {signal.name}", f"is {signal.unit} of shape {signal.shape}",
                             "joint angles: rad, one axis")
        columns = _labels([channel.point for channel in selection.channels(signal)])
        header = (signal.name, "version=1", f"nRows={table.count}", f"nColumns={len(columns) + 1}",
                  "inDegrees=yes", "")
        rows = ((piece, numbers(_degrees(piece.values[0]), _NO_NUMBER))
                for piece in selection.pieces(table))
        _write_file(folder / f"{name}.mot", header, columns, table, rows)
        notes += _uneven(table, signal.name)
    return notes


def _degrees(angles: NDArray[np.float64]) -> NDArray[np.float64]:
    """Convert to degrees; angles beyond 3e306 rad become infinite."""
    with np.errstate(over="ignore"):
        return np.rad2deg(angles)


def are_orientations(signal: TableSignal) -> bool:
    """Return whether a signal is orientations."""
    return quantity(signal) == "orientation"


def write_sto(selection: Selection, folder: Path) -> list[str]:
    """Write orientations, a file for each signal and trial; return notes.

    Raises InputError for a signal that is no orientation.
    """
    notes = []
    for table, signal, name in _each_signal(selection):
        if quantity(signal) != "orientation":
            raise InputError(f"--signals: {signal.name}", f"is {signal.unit} of shape {signal.shape}",
                             "orientations: quaternions w, x, y, z")
        points = [channel.point for channel in selection.channels(signal)[::4]]
        columns = [f"{label}_imu" for label in _labels([point or signal.port for point in points])]
        header = (f"DataRate={rate_of_stamps(table.times_ns()).hertz:.6f}", "DataType=Quaternion",
                  "version=3", f"OpenSimVersion={_VERSION}")
        _write_file(folder / f"{name}.sto", header, columns, table, _quaternion_rows(selection, table))
        notes += _uneven(table, signal.name)
    return notes


def _quaternion_rows(selection: Selection, table: SignalTable) -> Iterator[tuple[Piece, Iterator[list[str]]]]:
    """Pieces with their rows, one quaternion in a cell."""
    for piece in selection.pieces(table):
        yield piece, ([",".join(row[first:first + 4]) for first in range(0, len(row), 4)]
                      for row in numbers(piece.values[0], _NO_NUMBER))


def _labels(points: Sequence[str]) -> list[str]:
    """Unique names of columns, without white space, "=" and ","."""
    return unique([re.sub(r"[\s=,]+", "_", point) or "value" for point in points])


def _each_signal(selection: Selection) -> Iterator[tuple[SignalTable, TableSignal, str]]:
    """Every selected signal of every trial, alone in a table, with the name of its file."""
    files = unique([file_name(name) for name in selection.signals])
    for trial in selection.trials:
        for name, file in zip(selection.signals, files, strict=True):
            (table,) = selection.recording.tables([name], trial)
            yield table, table.signals[0], f"{selection.prefix(trial)}{file}"


def _write_file(path: Path, header: Sequence[str], columns: Sequence[str], table: SignalTable,
               rows: Iterator[tuple[Piece, Iterator[list[str]]]]) -> None:
    """Write header, labels and rows; the time in s leads each row."""
    with path.open("w", encoding="utf-8", newline="\n") as file:
        file.write("".join(f"{line}\n" for line in (*header, "endheader", "\t".join(("time", *columns)))))
        for piece, content in rows:
            file.write(lines([seconds(piece.times_ns, _NO_NUMBER)], content, "\t"))


def _uneven(table: SignalTable, name: str) -> list[str]:
    """Note that the instants of a signal are not evenly spaced, if so."""
    if table.count < 2 or rate_of_stamps(table.times_ns()).even:
        return []
    return [f"{name}, trial {table.trial}: instants are not evenly spaced, as some tools of OpenSim require"]
