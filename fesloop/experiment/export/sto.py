"""OpenSim tables of quaternions (.sto), as OpenSense reads them: a file a signal.

    DataRate=<Hz>
    DataType=Quaternion
    version=3
    OpenSimVersion=4.1
    endheader
    time <tab> <segment>_imu ...
    <s> <tab> w,x,y,z ...

Quaternions turn the segment's (or sensor's) frame into the earth's with z up, as they stand in the recording.
OpenSim's ground has y up: its tools are told `sensor_to_opensim_rotations` = -1.5707963267948966 0 0, as
their own example for Xsens sensors is. OpenSense ties a column NAME_imu to the model's body NAME.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from fesloop.errors import InputError
from fesloop.experiment.export import opensim
from fesloop.experiment.export.channels import quantity
from fesloop.experiment.export.rates import rate_of_stamps
from fesloop.experiment.export.selection import Selection
from fesloop.experiment.export.target import numbers
from fesloop.experiment.recording.signal_table import Piece, SignalTable, TableSignal

_VERSION = "4.1"
"""Of OpenSim, the first with OpenSense."""


def wanted(signal: TableSignal) -> bool:
    """Orientations."""
    return quantity(signal) == "orientation"


def write(selection: Selection, folder: Path) -> list[str]:
    """A file a signal and trial; notes. Raises InputError for a signal that is no orientation."""
    notes = []
    for table, signal, name in opensim.each_signal(selection):
        if quantity(signal) != "orientation":
            raise InputError(f"--signals: {signal.name}", f"is {signal.unit} of shape {signal.shape}",
                             "orientations: quaternions w, x, y, z")
        points = [channel.point for channel in selection.channels(signal)[::4]]
        columns = [f"{label}_imu" for label in opensim.labels([point or signal.port for point in points])]
        header = (f"DataRate={rate_of_stamps(table.times_ns()).hertz:.6f}", "DataType=Quaternion",
                  "version=3", f"OpenSimVersion={_VERSION}")
        opensim.write_file(folder / f"{name}.sto", header, columns, table, _rows(selection, table))
        notes += opensim.uneven(table, signal.name)
    return notes


def _rows(selection: Selection, table: SignalTable) -> Iterator[tuple[Piece, Iterator[list[str]]]]:
    """Pieces and their rows, a quaternion a cell."""
    for piece in selection.pieces(table):
        yield piece, ([",".join(row[first:first + 4]) for first in range(0, len(row), 4)]
                      for row in numbers(piece.values[0], opensim.NO_NUMBER))
