"""CSV (RFC 4180): a table a node, as all signals of a node share their instants, and one of events.

The header names each column and its unit in brackets. First come the stamps: instants are s from the trial's
start with nine decimals. Missing values are `nan`. A table with gyroscopes and accelerometers comes with
a layout file, with which `fesloop import` reads it back.
"""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from fesloop.experiment.export.channels import quantity
from fesloop.experiment.export.rates import rate_of_stamps
from fesloop.experiment.export.selection import Selection
from fesloop.experiment.export.target import file_name, instant, lines, numbers, seconds, side_by_side, unique
from fesloop.experiment.recording.reading import Piece, SignalTable, TableSignal
from fesloop.forms.toml import toml_text
from fesloop.streams.timebase import stamps_of_rate

MISSING = "nan"
TIME = "time [s]"
STAMPS = ("index", TIME, "left [s]", "oldest capture [s]", "newest capture [s]")
_SENSORS = {"rate": "gyr", "acceleration": "acc", "field": "mag"}


def write(selection: Selection, folder: Path) -> list[str]:
    """Write the tables of all trials."""
    for trial in selection.trials:
        tables = selection.tables(trial)
        names = unique(["events", *(file_name(selection.name_of(table)) for table in tables)])[1:]
        for table, name in zip(tables, names, strict=True):
            _write_table(selection, table, folder / f"{selection.prefix(trial)}{name}")
        _write_events(selection, trial, folder / f"{selection.prefix(trial)}events.csv")
    return []


def _write_table(selection: Selection, table: SignalTable, stem: Path) -> None:
    names = _columns(selection, table)
    every = [*STAMPS, *(name for of_signal in names.values() for name in of_signal)]
    with stem.with_name(f"{stem.name}.csv").open("w", encoding="utf-8", newline="\n") as file:
        file.write(",".join(every) + "\n")
        for piece in selection.pieces(table):
            file.write(lines(_stamps(piece), numbers(side_by_side(piece), MISSING), ","))
    if sensors := _sensors(selection, names):
        layout = {**_clock(table), **sensors}
        stem.with_name(f"{stem.name}.layout.toml").write_text(toml_text(layout), encoding="utf-8")


def _columns(selection: Selection, table: SignalTable) -> dict[TableSignal, list[str]]:
    """Names of the columns of each signal; a comma, quote or break in a name is an underscore."""
    labelled = [(signal, f"{signal.port}{'.' if channel.label else ''}{channel.label} [{channel.unit}]")
                for signal in table.signals for channel in selection.channels(signal)]
    plain = [name.translate({ord(sign): "_" for sign in ',"\r\n'}) for _, name in labelled]
    names: dict[TableSignal, list[str]] = {signal: [] for signal in table.signals}
    for (signal, _), name in zip(labelled, unique([*STAMPS, *plain])[len(STAMPS):], strict=True):
        names[signal].append(name)
    return names


def _stamps(piece: Piece) -> list[list[str]]:
    """The columns of `STAMPS`."""
    instants = (piece.times_ns, piece.left_ns, piece.oldest_ns, piece.newest_ns)
    return [list(map(str, piece.indices.tolist())), *(seconds(times, MISSING) for times in instants)]


def _clock(table: SignalTable) -> dict[str, str]:
    """The samples' rate, where it gives their instants to the ns; else the column of their times."""
    times = table.times_ns()
    rate = rate_of_stamps(times)
    if rate.even and np.array_equal(times - times[0], stamps_of_rate(len(times), rate.exact)):
        return {"rate": str(rate.exact)}
    return {"time": TIME}


def _sensors(selection: Selection, names: dict[TableSignal, list[str]]) -> dict[str, object]:
    """The sensors' columns and pairs (`fesloop.streams.formats.layout`); empty where there are none."""
    sensors: dict[str, dict[str, list[str]]] = {}
    pairs: dict[tuple[str, str], None] = {}
    units = {"time": "s"}
    for signal, columns in names.items():
        kind = _SENSORS.get(quantity(signal), "")
        if not kind or len(signal.shape) != 2:
            continue
        units[kind] = signal.unit
        pairs |= dict.fromkeys(signal.named_pairs)
        for number, channel in enumerate(selection.channels(signal)[::3]):
            sensors.setdefault(channel.point, {}).setdefault(kind, columns[3 * number:3 * number + 3])
    whole = {name: places for name, places in sensors.items() if {"gyr", "acc"} <= set(places)}
    stated = [list(pair) for pair in pairs if set(pair) <= set(whole)]
    return ({"pairs": stated} if stated else {}) | {"units": units, "sensors": whole} if whole else {}


def _write_events(selection: Selection, trial: int, path: Path) -> None:
    """Statuses of nodes and wires; texts in quotes where they hold commas."""
    with path.open("w", encoding="utf-8", newline="") as file:
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow((TIME, "where", "status", "detail"))
        for event in selection.events(trial):
            rows.writerow((instant(event.time_ns), event.where, event.status, event.detail))
