"""Named courses of angles from a file: a recording of fesloop, or columns of a CSV, OpenSim or NumPy file.

Columns of a CSV, or arrays (n,) of an NPZ or MATLAB file, are `time_s` or `time_ms` and, for each row,
`ROW_deg` or `ROW_rad`; other names are ignored. Files of OpenSim (.mot, .sto) have a header that says whether
angles are in degrees, and a column `time`, s; every other column is taken for an angle.
"""

from __future__ import annotations

import csv
import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError, did_you_mean
from fesloop.experiment.recording.reading import Recording
from fesloop.given_files import exists, is_file, is_folder, read_whole
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.skeleton import hand_tree
from fesloop.loop.clock import NS_PER_S
from fesloop.streams.checks import finite, numbers
from fesloop.streams.reading import read_container

Array = NDArray[np.float64]
_HDF5, _CONTAINERS = b"\x89HDF\r\n\x1a\n", (b"PK\x03\x04", b"MATLAB")
_TIMES = {"time_s": 1.0, "time_ms": 1e-3}
_FACTORS = {"_rad": 1.0, "_deg": np.pi / 180.0}
_END_OF_HEADER, _MOST_HEADER = b"endheader", 65_536
"""Line that ends a header of OpenSim, and bytes in which it is looked for (chosen)."""
_FILES = "a recording of fesloop (.h5), a CSV, OpenSim .mot or .sto, NPZ or MATLAB 5 file"


class NamedCourses(NamedTuple):
    """Courses of angles of a file.

    Attributes
    ----------
    names: names of the k columns; empty where the file has none.
    times_s: (n,), finite, strictly increasing, two or more.
    values: (n, k), rad.
    """

    names: tuple[str, ...]
    times_s: Array
    values: Array

    def fingerprint(self) -> str:
        """SHA-256 of names, times and values, as hexadecimal text."""
        total = hashlib.sha256(json.dumps(self.names).encode())
        total.update(np.ascontiguousarray(self.times_s).tobytes())
        total.update(np.ascontiguousarray(self.values).tobytes())
        return total.hexdigest()


def read_courses(file: str, signal: str, trial: int) -> NamedCourses:
    """Read the courses of a file.

    Parameters
    ----------
    file: its path; the first bytes show its format.
    signal, trial: of a recording, an output signal of angles (m,), rad, and its trial; "" and 0 for others.

    Raises InputError, naming file and column, for anything that cannot be a reference.
    """
    if exists(Path(file)) and not is_file(Path(file)) and not is_folder(Path(file)):
        raise InputError(file, "is a pipe or a device", _FILES, "copy its content to a file")
    try:
        with Path(file).open("rb") as opened:
            head = opened.read(_MOST_HEADER)
    except (OSError, ValueError) as fault:
        reason = fault.strerror if isinstance(fault, OSError) else str(fault)
        raise InputError(file, f"cannot be read: {reason}", _FILES) from None
    if head.startswith(_HDF5):
        return _of_recording(file, signal, trial)
    if signal or trial:
        raise InputError("signal" if signal else "trial", f"given for {file}, which is not a recording",
                         "none", "leave it out")
    if head.startswith(_CONTAINERS):
        return _of_columns(file, read_container(Path(file)))
    if any(line.strip().lower() == _END_OF_HEADER for line in head.splitlines()):
        return _of_opensim(file)
    return _of_columns(file, _csv(file))


def _of_opensim(file: str) -> NamedCourses:
    """Courses of a file of OpenSim: `key=value` lines, `endheader`, labels, and rows between white space."""
    try:
        lines = read_whole(file, _FILES).decode("utf-8-sig").splitlines()
    except UnicodeDecodeError:
        raise InputError(file, "is not known", _FILES) from None
    end = next(number for number, line in enumerate(lines) if line.strip().lower() == "endheader")
    stated = {key.strip().lower(): value.strip().lower() for key, equals, value in
              (line.partition("=") for line in lines[:end]) if equals}
    degrees = stated.get("indegrees")
    if degrees not in ("yes", "no"):
        raise InputError(f"{file}: inDegrees", f"{degrees!r}" if degrees else "is missing", "yes or no",
                         "state in the header whether angles are in degrees")
    labels = lines[end + 1].split() if len(lines) > end + 1 else []
    if labels[:1] != ["time"] or len(set(labels)) < max(len(labels), 2):
        raise InputError(f"{file}: line {end + 2}", f"{' '.join(labels)[:60]!r}",
                         "time and the names of the angles, each once")
    rows = []
    for number, line in enumerate(lines[end + 2:], end + 3):
        cells = line.split()
        if not cells:
            continue
        try:
            rows.append([float(cell) for cell in cells])
        except ValueError:
            raise InputError(f"{file}: line {number}", f"{line.strip()[:40]!r}", "numbers") from None
        if len(cells) != len(labels):
            raise InputError(f"{file}: line {number}", f"{len(cells)} numbers", f"{len(labels)}, as labels")
    if not rows:
        raise InputError(file, "holds no row after its labels", "two or more")
    table = np.array(rows)
    factor = _FACTORS["_deg"] if degrees == "yes" else 1.0
    return _checked(file, NamedCourses(tuple(labels[1:]), table[:, 0].copy(), factor * table[:, 1:]))


def _of_recording(file: str, signal: str, trial: int) -> NamedCourses:
    with Recording(file) as recording:
        if not signal:
            raise InputError("signal", f"is not given, and {file} holds several",
                             ", ".join(recording.signals))
        found = recording.signal(signal, trial)
        if found.unit != "rad" or found.values.ndim != 2:
            raise InputError(f"{file}: {signal}", f"has unit {found.unit!r} and shape "
                             f"{found.values.shape[1:]}", "angles: unit 'rad' and shape (m,)")
        if not found.times_ns.size:
            raise InputError("trial", f"{trial} of {signal} holds nothing in {file}",
                             f"0 to {recording.trials - 1}" if recording.trials else "no trial has begun")
        node = recording.experiment["blocks"].get(signal.partition(".")[0], {})
    names = _names_of(node, found.values.shape[1])
    return _checked(file, NamedCourses(names, found.times_ns / NS_PER_S, found.values))


def _names_of(node: Mapping[str, Any], width: int) -> tuple[str, ...]:
    """Names of a recorded signal's columns, from the parameters of its node."""
    rows = tuple(node.get("rows", ()))
    if len(rows) == width:
        return rows
    freedoms = hand_tree(HandSize()).freedoms
    return freedoms if width == len(freedoms) and not node.get("segments") else ()


def _of_columns(file: str, content: Mapping[str, Any]) -> NamedCourses:
    """Courses from columns by name."""
    clocks = [key for key in _TIMES if key in content]
    if len(clocks) != 1:
        raise InputError(f"{file}: {' and '.join(clocks) or 'time_s'}",
                         "both there" if clocks else "is missing", "one column time_s or time_ms",
                         "" if clocks else did_you_mean("time_s", map(str, content)))
    columns = [key for key in content if key[-4:] in _FACTORS and len(key) > 4]
    names = tuple(key[:-4] for key in columns)
    if not names:
        raise InputError(file, f"holds no angles, but {', '.join(map(str, content))}",
                         "columns named after rows and unit, such as finger_flexion_deg")
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"{file}: {name}", "is given in deg and in rad", "one of the two")
    times = numbers(content, clocks[0], (None,), file) * _TIMES[clocks[0]]
    values = [numbers(content, key, (times.size,), file) * _FACTORS[key[-4:]] for key in columns]
    return _checked(file, NamedCourses(names, times, np.stack(values, axis=-1)))


def _csv(file: str) -> dict[str, list[float]]:
    """Columns of a CSV file by the names in its first line; empty cells are NaN."""
    try:
        text = Path(file).read_text(encoding="utf-8-sig")
    except UnicodeDecodeError:
        raise InputError(file, "is not known", _FILES) from None
    header = text.partition("\n")[0]
    mark = max(",;\t", key=header.count)
    try:
        lines = list(csv.reader(text.splitlines(), delimiter=mark, strict=True))
    except csv.Error as fault:
        raise InputError(file, f"is no CSV: {fault}", _FILES) from None
    names = [name.strip() for name in lines[0]] if lines else []
    if not any(names) or len(set(names)) < len(names):
        raise InputError(f"{file}: line 1", f"{header[:60]!r}", "names of the columns, each once")
    columns: dict[str, list[float]] = {name: [] for name in names}
    for number, cells in enumerate(lines[1:], 2):
        if not cells:
            continue
        where = f"{file}: line {number}"
        if len(cells) != len(names):
            raise InputError(where, f"{len(cells)} cells", f"{len(names)}, as the first line has names")
        for name, cell in zip(names, cells, strict=True):
            try:
                columns[name].append(float(cell) if cell.strip() else np.nan)
            except ValueError:
                raise InputError(where, f"{name} is {cell.strip()[:40]!r}", "a number") from None
    return columns


def _checked(file: str, courses: NamedCourses) -> NamedCourses:
    """The courses; raises InputError for impossible times."""
    times = courses.times_s
    finite(times, f"{file}: times")
    if times.size < 2:
        raise InputError(f"{file}: times", f"{times.size} instants", "two or more")
    back = np.diff(times) <= 0.0
    if back.any():
        at = int(np.argmax(back)) + 1
        raise InputError(f"{file}: times", f"sample {at} at {times[at]:g} s is not after "
                         f"{times[at - 1]:g} s", "increasing times", "sort the file by time")
    return courses
