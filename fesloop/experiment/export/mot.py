"""OpenSim motions (.mot): joint angles in degrees, a file a signal.

    <signal>
    version=1
    nRows=<rows>
    nColumns=<columns, time among them>
    inDegrees=yes

    endheader
    time <tab> <joint angle> ...

Columns are called as the freedoms of the segment tree: `F2_mcp_flexion` and so on, flexion about z,
abduction about x, pronation about y of each segment's frame. OpenSim takes a column for a coordinate of the
same name; for a model with other names rename them, or the model's.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.experiment.export import opensim
from fesloop.experiment.export.channels import quantity
from fesloop.experiment.export.selection import Selection
from fesloop.experiment.export.target import numbers
from fesloop.experiment.recording.signal_table import TableSignal


def wanted(signal: TableSignal) -> bool:
    """Joint angles as plants, trackers and references put them out."""
    return quantity(signal) == "joint_angle" and signal.port == "angles"


def write(selection: Selection, folder: Path) -> list[str]:
    """A file a signal and trial; notes. Raises InputError for a signal that is no vector of angles."""
    notes = []
    for table, signal, name in opensim.each_signal(selection):
        if quantity(signal) != "joint_angle":
            raise InputError(f"--signals: {signal.name}", f"is {signal.unit} of shape {signal.shape}",
                             "joint angles: rad, one axis")
        columns = opensim.labels([channel.point for channel in selection.channels(signal)])
        header = (signal.name, "version=1", f"nRows={table.count}", f"nColumns={len(columns) + 1}",
                  "inDegrees=yes", "")
        rows = ((piece, numbers(_degrees(piece.values[0]), opensim.NO_NUMBER))
                for piece in selection.pieces(table))
        opensim.write_file(folder / f"{name}.mot", header, columns, table, rows)
        notes += opensim.uneven(table, signal.name)
    return notes


def _degrees(angles: NDArray[np.float64]) -> NDArray[np.float64]:
    """Degrees; of angles beyond 3e306 rad, infinite ones."""
    with np.errstate(over="ignore"):
        return np.rad2deg(angles)
