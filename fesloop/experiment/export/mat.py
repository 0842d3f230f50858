"""MATLAB 5: a structure a signal, `run` and `events`; MATLAB, Octave and scipy read it.

A structure has `name`, `unit`, `channels` (a label each, in the shape of a row of values), `values` (rows x
the port's shape), `time` (s) and the stamps `index`, `time_ns`, `left_ns`, `oldest_ns`, `newest_ns` (int64,
ns; -1 is never).
"""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import BinaryIO

import numpy as np

from fesloop.errors import InputError
from fesloop.experiment.export import mat_elements as mat
from fesloop.experiment.export.selection import Selection
from fesloop.experiment.export.target import file_name, unique
from fesloop.experiment.recording.signal_table import SignalTable, TableSignal
from fesloop.loop.clock import NS_PER_S

MOST_BYTES = 2**31 - 1
"""Of a variable in a MATLAB 5 file (MathWorks, "MAT-File Versions")."""
_STAMPS = ("index", "time_ns", "left_ns", "oldest_ns", "newest_ns")
_KEYWORDS = frozenset((
    "break", "case", "catch", "classdef", "continue", "else", "elseif", "end", "for", "function", "global",
    "if", "otherwise", "parfor", "persistent", "return", "spmd", "switch", "try", "while"))
_OWN = ("run", "events")


def wanted(signal: TableSignal) -> bool:
    """Every signal."""
    return True


def write(selection: Selection, folder: Path) -> list[str]:
    """A file a trial; raises InputError before anything is written where a signal is beyond MATLAB 5."""
    planned = [(trial, _plan(selection, trial)) for trial in selection.trials]
    for trial, tables in planned:
        path = folder / f"{selection.prefix(trial)}{file_name(selection.recording.path.stem)}.mat"
        with path.open("wb") as file:
            file.write(mat.header(f"fesloop run {selection.recording.name}, trial {trial}"))
            mat.write(file, _run(selection, trial), "run")
            _write_events(file, selection, trial)
            for table, structures in tables:
                _write_table(file, selection, table, structures)
    return []


def variable_names(signals: list[str]) -> list[str]:
    """Valid, different names: "finger.angles" is finger_angles."""
    made = []
    for name in signals:
        plain = re.sub("[^A-Za-z0-9_]", "_", name)
        if not plain[:1].isalpha() or plain in _KEYWORDS:
            plain = f"s_{plain}"
        made.append(plain[:mat.LONGEST_NAME - 6])
    return unique([*_OWN, *made])[len(_OWN):]


_Structures = dict[str, mat.Struct]


def _plan(selection: Selection, trial: int) -> list[tuple[SignalTable, _Structures]]:
    """The structures of a trial, table by table, by the names of their variables."""
    names = dict(zip(selection.signals, variable_names(list(selection.signals)), strict=True))
    tables = selection.tables(trial)
    planned = [(table, {names[signal.name]: _structure(selection, table, signal) for signal in table.signals})
               for table in tables]
    for table, structures in planned:
        for signal, structure in zip(table.signals, structures.values(), strict=True):
            if (total := mat.size(structure)) > MOST_BYTES:
                raise InputError(f"--format mat: {signal.name}", f"takes {total / 1e9:.1f} GB",
                                 f"{MOST_BYTES / 1e9:.1f} GB a variable",
                                 "name other signals with --signals, or take xdf or csv")
    return planned


def _structure(selection: Selection, table: SignalTable, signal: TableSignal) -> mat.Struct:
    labels = tuple(channel.label for channel in selection.channels(signal))
    count = table.count
    shape = (1, *signal.shape) if len(signal.shape) == 1 else signal.shape or (1, 1)
    fields: dict[str, mat.Element] = {
        "name": signal.name, "unit": signal.unit, "channels": mat.Cell(labels, shape),
        "values": mat.OpenArray((count, *signal.shape)), "time": mat.OpenArray((count,)),
        **{stamp: mat.OpenArray((count,), integers=True) for stamp in _STAMPS}}
    return mat.Struct(fields)


def _write_table(file: BinaryIO, selection: Selection, table: SignalTable,
                 structures: _Structures) -> None:
    """The variables of a table: their frames, then their values, piece by piece."""
    places: dict[int, int] = {}
    for name, structure in structures.items():
        places |= mat.write(file, structure, name)
    end, first = file.tell(), 0
    for piece in selection.pieces(table):
        stamps = (piece.indices, piece.times_ns, piece.left_ns, piece.oldest_ns, piece.newest_ns)
        for structure, values in zip(structures.values(), piece.values, strict=True):
            columns = {"values": values, "time": piece.times_ns / NS_PER_S,
                       **dict(zip(_STAMPS, stamps, strict=True))}
            for field, column in columns.items():
                mat.fill(file, places[id(structure.fields[field])], table.count, first, column)
        first += len(piece.times_ns)
    file.seek(end)


def _run(selection: Selection, trial: int) -> mat.Struct:
    recording = selection.recording
    return mat.Struct({
        "name": recording.name, "trial": float(trial), "seed": str(recording.seed),
        "status": recording.status, "fingerprint": recording.fingerprint,
        "fesloop": recording.versions.get("fesloop", ""), "experiment": json.dumps(recording.experiment)})


def _write_events(file: BinaryIO, selection: Selection, trial: int) -> None:
    """What happened: time, s, and time_ns; where, status, detail."""
    found = selection.events(trial)
    texts = {"where": [event.where for event in found], "status": [event.status for event in found],
             "detail": [event.detail for event in found]}
    times = np.array([event.time_ns for event in found], np.int64)
    structure = mat.Struct({
        "time": mat.OpenArray((len(found),)), "time_ns": mat.OpenArray((len(found),), integers=True),
        **{name: mat.Cell(tuple(column), (len(column), 1)) for name, column in texts.items()}})
    places = mat.write(file, structure, "events")
    end = file.tell()
    for name, column in (("time", times / NS_PER_S), ("time_ns", times)):
        mat.fill(file, places[id(structure.fields[name])], len(found), 0, column)
    file.seek(end)
