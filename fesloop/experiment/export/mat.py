"""MATLAB 5 export: a structure for each signal, `run` and `events`; MATLAB, Octave and SciPy read it.

A structure has `name`, `unit`, `channels` (a label each, in the shape of a row of values), `values` (rows x
the port's shape), `time` (s) and the stamps `index`, `time_ns`, `left_ns`, `oldest_ns`, `newest_ns` (int64,
ns; -1 is never).
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray
from scipy.io import savemat

from fesloop.errors import InputError
from fesloop.experiment.export.selection import Selection
from fesloop.experiment.export.target import file_name, unique
from fesloop.experiment.recording.reading import SignalTable
from fesloop.loop.clock import NS_PER_S

MOST_BYTES = 2**31 - 1
"""Largest variable of a MATLAB 5 file (MathWorks, "MAT-File Versions")."""
_LONGEST_NAME = 63
_STAMPS = ("index", "time_ns", "left_ns", "oldest_ns", "newest_ns")
_KEYWORDS = frozenset((
    "break", "case", "catch", "classdef", "continue", "else", "elseif", "end", "for", "function", "global",
    "if", "otherwise", "parfor", "persistent", "return", "spmd", "switch", "try", "while"))
_OWN = ("run", "events")


def write(selection: Selection, folder: Path) -> list[str]:
    """Write a file for each trial.

    Raises InputError before anything is written if a signal is too large for MATLAB 5.
    """
    tables = {(trial, signal): selection.recording.tables((signal,), trial)[0]
              for trial in selection.trials for signal in selection.signals}
    for (_, signal), table in tables.items():
        _require_room(signal, table)
    names = dict(zip(selection.signals, variable_names(list(selection.signals)), strict=True))
    for trial in selection.trials:
        path = folder / f"{selection.prefix(trial)}{file_name(selection.recording.path.stem)}.mat"
        with path.open("wb") as file:
            _save(file, "run", _run(selection, trial))
            _save(file, "events", _events(selection, trial))
            for signal, name in names.items():
                _save(file, name, _signal(selection, tables[trial, signal]))
            _describe(file, f"fesloop run {selection.recording.name}, trial {trial}")
    return []


def variable_names(signals: list[str]) -> list[str]:
    """Valid, different names: "finger.angles" is finger_angles."""
    made = []
    for name in signals:
        plain = re.sub("[^A-Za-z0-9_]", "_", name)
        if not plain[:1].isalpha() or plain in _KEYWORDS:
            plain = f"s_{plain}"
        made.append(plain[:_LONGEST_NAME - 6])
    return unique([*_OWN, *made])[len(_OWN):]


def _require_room(name: str, table: SignalTable) -> None:
    """Raise InputError if a signal, with its time and stamps, is too large for a variable."""
    total = 8 * table.count * (math.prod(table.signals[0].shape) + 1 + len(_STAMPS))
    if total > MOST_BYTES:
        raise InputError(f"--format mat: {name}", f"takes {total / 1e9:.1f} GB",
                         f"{MOST_BYTES / 1e9:.1f} GB a variable",
                         "name other signals with --signals, or take xdf or csv")


def _save(file: BinaryIO, name: str, structure: Mapping[str, Any]) -> None:
    """Append a variable; SciPy writes the header of the file before the first one."""
    stream: Any = file  # SciPy takes open files, its stubs say paths alone
    savemat(stream, {name: structure}, long_field_names=True)


def _describe(file: BinaryIO, text: str) -> None:
    """Replace SciPy's description of the file, which has the date, by one that does not change."""
    file.seek(0)
    file.write(f"MATLAB 5.0 MAT-file, {text}"[:116].ljust(116).encode("ascii", "replace"))


def _signal(selection: Selection, table: SignalTable) -> dict[str, Any]:
    """Structure of the only signal of a table."""
    signal = table.signals[0]
    shape = (1, *signal.shape) if len(signal.shape) == 1 else signal.shape or (1, 1)
    values = np.empty((table.count, *(signal.shape or (1,))))
    stamps = {name: np.empty((table.count, 1), np.int64) for name in _STAMPS}
    first = 0
    for piece in selection.pieces(table):
        rows = slice(first, first + len(piece.times_ns))
        values[rows] = piece.values[0].reshape(-1, *values.shape[1:])
        for name, column in zip(_STAMPS, (piece.indices, piece.times_ns, piece.left_ns, piece.oldest_ns,
                                          piece.newest_ns), strict=True):
            stamps[name][rows, 0] = column
        first = rows.stop
    return {"name": _text(signal.name), "unit": _text(signal.unit),
            "channels": _cell([channel.label for channel in selection.channels(signal)], shape),
            "values": values, "time": stamps["time_ns"] / NS_PER_S, **stamps}


def _run(selection: Selection, trial: int) -> dict[str, Any]:
    recording = selection.recording
    return {"name": _text(recording.name), "trial": float(trial), "seed": str(recording.seed),
            "status": recording.status, "fingerprint": recording.fingerprint,
            "fesloop": recording.versions.get("fesloop", ""),
            "experiment": _text(json.dumps(recording.experiment))}


def _events(selection: Selection, trial: int) -> dict[str, Any]:
    """Events of a trial: time, s, and time_ns; where, status, detail."""
    found = selection.events(trial)
    times = np.array([event.time_ns for event in found], np.int64).reshape(-1, 1)
    return {"time": times / NS_PER_S, "time_ns": times} | {
        key: _cell([getattr(event, key) for event in found], (len(found), 1))
        for key in ("where", "status", "detail")}


def _cell(texts: Sequence[str], shape: tuple[int, ...]) -> NDArray[np.object_]:
    made = np.empty(len(texts), object)
    made[:] = [_text(text) for text in texts]
    return made.reshape(shape)


def _text(text: str) -> str:
    """Replace what UTF-16 encodes in two units by U+FFFD: MATLAB counts units, SciPy characters."""
    return re.sub("[\U00010000-\U0010ffff]", "\ufffd", text)
