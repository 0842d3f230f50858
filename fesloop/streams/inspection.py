"""Streams, rates, gaps and units of a recording in any format, and a layout to start from."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from fesloop.errors import InputError
from fesloop.forms.toml import toml_text
from fesloop.given_files import is_folder
from fesloop.loop.clock import NS_PER_S
from fesloop.streams.checks import Array
from fesloop.streams.files import open_recording
from fesloop.streams.formats import motion_bids
from fesloop.streams.formats.channels import Part, suggested_hz, time_base
from fesloop.streams.formats.xdf import SIGNATURE, XdfStream, inspect_streams, instants_s
from fesloop.streams.labels import SI, factor, quantity_in
from fesloop.streams.layout_guess import (
    Labelled,
    Triple,
    layout_of,
    place_of,
    time_of,
    triples_of,
    unit_apart,
    units_of,
)
from fesloop.streams.pace import Gap, gaps_of, pace_of
from fesloop.streams.reading import head_of, is_container, read_container
from fesloop.streams.recording import MotionRecording
from fesloop.streams.text_table import TextForm, read_table, read_text

ALLOWED = "a recording: XDF, Motion-BIDS, MATLAB, HDF5, .npz or a table in a text file"
_LINES = 400
"""Lines of a text file by which its form is known (chosen)."""
_UNKNOWN_HZ = 100
"""Rate that is written where a file gives none, to be replaced (chosen)."""
_RATE_NAMES = ("rate", "sampling_rate", "samplingrate", "sample_rate", "fs", "freq", "frequency", "hz",
               "srate")


class Stream(NamedTuple):
    """Samples of one time base.

    Attributes
    ----------
    name, type: as the file has them.
    samples: number of samples; columns: of each.
    rate_hz: between gaps, by the stamps; None where there are none. stated_hz: as the file says, or None.
    lasts_s: from the first sample to the last; None without stamps.
    gaps: stretches without samples.
    """

    name: str
    type: str
    samples: int
    columns: int
    rate_hz: float | None = None
    stated_hz: float | None = None
    lasts_s: float | None = None
    gaps: tuple[Gap, ...] = ()


class Kind(NamedTuple):
    """One kind of samples of a sensor: columns, the unit that it is taken for, and incomplete samples."""

    stream: str
    sensor: str
    kind: str
    columns: tuple[str, ...]
    unit: str
    lost: int


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Inspection:
    """Content of a file: streams, sensors, and a layout to import it by.

    Attributes
    ----------
    path: the file. source_format: its form, in words.
    streams, kinds: what was found; `unread`: labels of columns that were not understood.
    readable: whether it is read without a layout.
    layout: tables of a layout to start from; empty where none is needed, or none was found.
    notes: what was guessed, and what is doubtful.
    """

    path: Path
    source_format: str
    streams: tuple[Stream, ...] = ()
    kinds: tuple[Kind, ...] = ()
    unread: tuple[str, ...] = ()
    readable: bool = False
    layout: Mapping[str, Any] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    def layout_text(self) -> str:
        """The layout as a TOML file, with notes on top."""
        about = [f"Layout of {self.path.name}, a start: check it against what is known of the recording.",
                 *(f"Guessed: {note}." for note in self.notes)]
        return "".join(f"# {' '.join(line.split())}\n" for line in about) + "\n" + toml_text(self.layout)


def inspect(path: str | Path) -> Inspection:
    """Inspect a recording in a file, or a folder of Motion-BIDS.

    Raises InputError for a file that is damaged, or of no known format.
    """
    file = Path(path)
    if not is_folder(file) and not file.name.endswith(motion_bids.ENDING):
        head = head_of(file, ALLOWED)
        if head.startswith(SIGNATURE):
            return _xdf(file)
        if not is_container(head):
            return _table(file)
    try:
        return _recording(open_recording(file))
    except InputError as fault:
        if is_folder(file) or file.name.endswith(motion_bids.ENDING):
            raise
        return _variables(file, str(fault))


def _stream(name: str, kind: str, samples: int, columns: int, times_s: Array | None,
            stated_hz: float | None = None) -> Stream:
    if times_s is None or times_s.size < 2 or not np.isfinite(times_s).all():
        return Stream(name, kind, samples, columns, None, stated_hz)
    pace = pace_of(times_s, stated_hz or 0.0)
    return Stream(name, kind, samples, columns, pace.rate_hz if pace.period_s > 0.0 else None, stated_hz,
                  float(times_s[-1] - times_s[0]), tuple(gaps_of(times_s, pace)))


def _kinds(triples: Sequence[Triple], units: Mapping[str, str]) -> tuple[Kind, ...]:
    return tuple(Kind(triple.columns[0].stream, triple.sensor, triple.kind,
                      tuple(column.label or str(column.number) for column in triple.columns),
                      units.get(triple.kind, ""), int(np.isnan(triple.samples).any(axis=1).sum()))
                 for triple in triples)


def _unread(columns: Sequence[Labelled], triples: Sequence[Triple],
            timed: Labelled | None) -> tuple[str, ...]:
    used = {(each.stream, each.number) for triple in triples for each in triple.columns}
    used |= {(timed.stream, timed.number)} if timed else set()
    return tuple(" ".join(filter(None, (column.stream, column.label or f"column {column.number}")))
                 for column in columns if (column.stream, column.number) not in used)


def _recording(recording: MotionRecording) -> Inspection:
    """A recording that describes itself."""
    samples = {"gyr": recording.gyr, "acc": recording.acc} | (
        {"mag": recording.mag} if recording.mag is not None else {})
    kinds = [Kind("", sensor, kind, (), recording.source_units.get(kind, SI[kind]),
                  int(np.isnan(values[:, number]).any(axis=1).sum()))
             for number, sensor in enumerate(recording.sensors) for kind, values in samples.items()]
    stream = _stream(recording.sensor_set or recording.path.name, "", recording.samples,
                     3 * len(kinds), recording.stamps_ns / NS_PER_S,
                     None if recording.rate is None else float(recording.rate))
    return Inspection(path=recording.path, source_format=recording.source_format, streams=(stream,),
                      kinds=tuple(kinds), unread=recording.left_out, readable=True)


def _xdf(path: Path) -> Inspection:
    notes: list[str] = []
    streams, texts = inspect_streams(path)
    found, columns, times = [], list[Labelled](), dict[str, Array]()
    for stream in streams:
        times[stream.key] = _instants(stream, path, notes)
        found.append(_stream(stream.key, stream.type, len(stream.values), len(stream.labels),
                             times[stream.key], stream.rate_hz or None))
        columns += _channels(stream)
    found += [Stream(name, kind, samples, 1) for name, kind, samples in texts]
    triples = triples_of(columns, notes)
    used = [name for name in times if any(triple.columns[0].stream == name for triple in triples)]
    units = units_of(triples, times[used[0]] if used else None, notes)
    layout: dict[str, Any] = {}
    if used:
        base: dict[str, Any] = {"time": used[0]}
        parts = [Part(name, name, times[name], np.zeros((times[name].size, 1)), {}) for name in used]
        try:
            time_base(parts, str(path))
        except InputError:
            base["resample"] = suggested_hz(parts)
            notes.append(f"its streams have different instants: resample = {base['resample']} brings them to "
                         "common ones; take out the line and the other streams to play one as it is")
        layout = layout_of(triples, units, base, (), notes)
    return Inspection(path=path, source_format="xdf", streams=tuple(found), kinds=_kinds(triples, units),
                      unread=_unread(columns, triples, None), layout=layout, notes=tuple(notes),
                      readable=_is_read(path))


def _channels(stream: XdfStream) -> Iterator[Labelled]:
    values = np.asarray(stream.values, dtype=np.float64)
    for number, (label, unit, kind) in enumerate(zip(stream.labels, stream.units, stream.types, strict=True)):
        name = label if stream.labels.count(label) == 1 else ""
        yield Labelled(*unit_apart(label, unit), kind, values[:, number], stream.key, number + 1, name=name)


def _instants(stream: XdfStream, path: Path, notes: list[str]) -> Array:
    try:
        return instants_s(stream, f"{path}: stream {stream.key}", trust_header=False)
    except InputError as fault:
        notes.append(str(fault))
        return stream.times_s


def _is_read(path: Path) -> bool:
    try:
        open_recording(path)
    except InputError:
        return False
    return True


def _table(path: Path) -> Inspection:
    notes: list[str] = []
    form = _form_of(read_text(path, ALLOWED).splitlines(), str(path))
    table = read_table(path, form)
    names = table.names or ("",) * table.values.shape[1]
    columns = [Labelled(*unit_apart(name), "", table.values[:, number], "", number + 1, name=name)
               for number, name in enumerate(names)]
    layout, found = _single(columns, {}, notes, "table")
    changed = {key: list(value) if isinstance(value, tuple) else value for key, value in asdict(form).items()
               if value != getattr(TextForm(), key)}
    if layout and changed:
        layout = {**layout, "text": changed}
    words = {" ": "blanks", "\t": "tabs"}.get(form.separator, f"{form.separator!r}")
    return Inspection(path=path, source_format=f"table, separated by {words}, decimal {form.decimal!r}, "
                      f"header of {form.header} line{'s' * (form.header != 1)}",
                      layout=layout, notes=tuple(notes), **found)


def _single(columns: list[Labelled], base: dict[str, Any], notes: list[str],
            name: str) -> tuple[dict[str, Any], dict[str, Any]]:
    """Layout, and fields of an inspection, of columns that have one time base."""
    names = [column.name for column in columns]
    rows = columns[0].values.size if columns else 0
    timed = time_of(columns, notes)
    times_s, stated = None, base.get("rate")
    if timed is not None:
        column, unit = timed
        times_s = column.values * factor("time", unit, name)
        place = place_of([column], names)
        base = {"time": column.stream or place[0], "units": {"time": unit}}
    elif stated is None:
        base = {"rate": _UNKNOWN_HZ}
        notes.append(f"there are no instants and no rate: {_UNKNOWN_HZ} Hz is written, replace it")
    even = times_s if times_s is not None else np.arange(rows) / float(base["rate"])
    triples = triples_of([column for column in columns if timed is None or column is not timed[0]], notes)
    units = units_of(triples, even, notes)
    layout = layout_of(triples, units, base, names, notes)
    return layout, {
        "streams": (_stream(name, "", rows, len(columns), times_s, stated and float(stated)),),
        "kinds": _kinds(triples, units), "unread": _unread(columns, triples, timed and timed[0])}


def _form_of(lines: Sequence[str], where: str) -> TextForm:
    """Separator, decimal mark and lines of header with which most columns of numbers are read."""
    head = lines[:_LINES]
    best: tuple[int, TextForm] | None = None
    for separator in (",", ";", "\t", " "):
        for decimal in (".", ","):
            if decimal == separator:
                continue
            form = TextForm(separator=separator, decimal=decimal)
            sizes = [_numbers(form, line) for line in head]
            rows = [size for size, line in zip(sizes, head, strict=True) if line.strip()]
            if not rows or not rows[-1]:
                continue
            count = rows[-1]
            header = next((number for number in range(len(sizes) - 1, -1, -1)
                           if head[number].strip() and sizes[number] != count), -1) + 1
            if best is None or count > best[0]:
                best = count, TextForm(separator=separator, decimal=decimal, header=header)
    if best is None or best[0] < 2:
        raise InputError(where, "is no recording of a known format, and no table of numbers", ALLOWED)
    return best[1]


def _numbers(form: TextForm, line: str) -> int:
    """Number of cells of a line of numbers, of which some may be missing; 0 for any other line."""
    cells = form.cells(line)
    if len(cells) > 1 and not cells[-1]:
        cells = cells[:-1]  # a separator behind the last cell
    known = 0
    for cell in cells:
        try:
            known += not np.isnan(form.number(cell))
        except ValueError:
            return 0
    return len(cells) if known else 0


def _variables(path: Path, why: str) -> Inspection:
    """A container of arrays that is of no known set; `why` it is none."""
    notes: list[str] = []
    arrays, scalars = dict[str, Array](), dict[str, float]()
    for name, value in _leaves(read_container(path)):
        values = np.asarray(value)
        if values.dtype.kind in "fiub" and values.size == 1:
            scalars[name] = float(values.ravel()[0])
        elif values.dtype.kind in "fiub" and values.ndim <= 3 and values.size > 2:
            arrays[name] = _rows_first(np.squeeze(values).astype(np.float64))
    sizes = Counter[int]()
    for values in arrays.values():
        sizes[len(values)] += values.size // len(values)
    if not sizes:
        raise InputError(str(path), why.partition(": ")[2] or "holds no array of numbers", ALLOWED)
    rows = max(sizes, key=lambda size: (sizes[size], size))
    columns = [column for name, values in arrays.items() for column in _of_array(name, values, rows)]
    others = [f"{name} {' x '.join(map(str, values.shape))}" for name, values in arrays.items()
              if len(values) != rows]
    stated = next(((name, value) for name, value in scalars.items()
                   if name.split(".")[-1].lower() in _RATE_NAMES), None)
    base: dict[str, Any] = {}
    if stated is not None:
        base = {"rate": int(stated[1]) if stated[1] == int(stated[1]) else stated[1]}
        notes.append(f"the rate is the number {stated[0]}")
    layout, found = _single(columns, base, notes, path.name)
    found["unread"] = (*found["unread"], *others)
    return Inspection(path=path, source_format="arrays", layout=layout, notes=tuple(notes), **found)


def _leaves(content: Any, path: str = "") -> Iterator[tuple[str, Any]]:
    if isinstance(content, Mapping):
        for key, value in content.items():
            yield from _leaves(value, f"{path}.{key}" if path else str(key))
    elif not isinstance(content, (str, list)):
        yield path, content


def _rows_first(values: Array) -> Array:
    """An array with samples along its first axis: one of (3, n) is turned, as a layout reads it."""
    return values.T if values.ndim == 2 and values.shape[0] == len("xyz") < values.shape[1] else values


def _of_array(name: str, values: Array, rows: int) -> Iterator[Labelled]:
    """Columns of an array of so many rows: none of another one."""
    if len(values) != rows:
        return
    matrix = values.reshape(rows, -1)
    text, last = name.replace(".", "_"), name.split(".")[-1]
    triple = matrix.shape[1] == len("xyz") and quantity_in(text) is not None
    for number in range(matrix.shape[1]):
        label = f"{text}_{'xyz'[number]}" if triple else (last if matrix.shape[1] == 1 else "")
        if matrix.shape[1] == 1 and quantity_in(text) is not None:
            label = text
        yield Labelled(label, "", "", matrix[:, number], name, number + 1, matrix.shape[1] == len("xyz"))
