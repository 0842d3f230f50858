"""Motion-BIDS, a dataset folder (bids-specification.readthedocs.io; doi 10.1038/s41597-024-03559-8).

A tracking system is a node with its own clock. Its table begins with the channel of latencies and with what
else stamps say; instants are s from the trial's start with nine decimals, so that every ns is kept. A trial
is a run, counted from 1.
"""

from __future__ import annotations

import json
import re
from pathlib import Path

from fesloop.experiment.export import bids_sidecars as sidecars
from fesloop.experiment.export.channels import quantity
from fesloop.experiment.export.names import unique
from fesloop.experiment.export.selection import Selection
from fesloop.experiment.export.text import instant, lines, numbers, seconds, side_by_side
from fesloop.experiment.recording.signal_table import Piece, SignalTable, TableSignal

NO_VALUE = "n/a"
_SUBJECT = "sub-01"


def wanted(signal: TableSignal) -> bool:
    """Signals that are motion: of inertial sensors, orientations, joint angles, positions, velocities."""
    return quantity(signal) != "other"


def write(selection: Selection, folder: Path) -> list[str]:
    """The dataset; notes. Empty files are none in BIDS: what has no row in a trial is left out."""
    task = _alphanumeric(selection.recording.name)
    motion = folder / _SUBJECT / "motion"
    motion.mkdir(parents=True)
    _write_dataset(selection, folder)
    notes, scans = [], [["filename", "acq_time", "trial"]]
    for trial in selection.trials:
        run = "" if selection.among == 1 else f"_run-{trial + 1}"
        tables = selection.tables(trial)
        for table, system in zip(tables, _systems(selection, tables), strict=True):
            if not table.count:
                notes.append(f"{selection.told(table)}, trial {trial}: no row, so no file")
                continue
            stem = f"{_SUBJECT}_task-{task}_tracksys-{system}{run}"
            _write_system(selection, table, task, system, motion / stem)
            scans.append([f"motion/{stem}_motion.tsv", selection.onset(trial), str(trial)])
        _write_events(selection, trial, motion / f"{_SUBJECT}_task-{task}{run}")
    _write_table(folder / _SUBJECT / f"{_SUBJECT}_scans.tsv", scans)
    _write_json(folder / _SUBJECT / f"{_SUBJECT}_scans.json", sidecars.SCANS)
    return notes


def _write_dataset(selection: Selection, folder: Path) -> None:
    """What there is once a dataset."""
    _write_json(folder / "dataset_description.json", sidecars.dataset(selection))
    (folder / "README.md").write_text(sidecars.readme(selection), encoding="utf-8")
    _write_table(folder / "participants.tsv", [["participant_id"], [_SUBJECT]])
    _write_json(folder / "participants.json", sidecars.PARTICIPANTS)


def _write_system(selection: Selection, table: SignalTable, task: str, system: str, stem: Path) -> None:
    """Motion, its description, and its channels."""
    described = sidecars.channel_rows(selection, table)
    _write_table(stem.with_name(f"{stem.name}_channels.tsv"), [sidecars.CHANNEL_COLUMNS, *described])
    _write_json(stem.with_name(f"{stem.name}_channels.json"), sidecars.CHANNELS)
    _write_json(stem.with_name(f"{stem.name}_motion.json"),
                sidecars.motion(selection, table, task, system, described))
    with stem.with_name(f"{stem.name}_motion.tsv").open("w", encoding="utf-8", newline="\n") as file:
        for piece in selection.pieces(table):
            file.write(lines(_stamps(piece), numbers(side_by_side(piece), NO_VALUE), "\t"))


def _stamps(piece: Piece) -> list[list[str]]:
    """The columns of `sidecars.STAMPS`."""
    instants = (piece.left_ns, piece.oldest_ns, piece.newest_ns)
    return [seconds(piece.times_ns, NO_VALUE), list(map(str, piece.indices.tolist())),
            *(seconds(times, NO_VALUE) for times in instants)]


def _write_events(selection: Selection, trial: int, stem: Path) -> None:
    """Statuses of nodes and wires in a trial, where there were any."""
    rows = [[instant(event.time_ns), NO_VALUE, event.status, event.where, event.detail]
            for event in selection.events(trial)]
    if rows:
        _write_table(stem.with_name(f"{stem.name}_events.tsv"), [sidecars.EVENT_COLUMNS, *rows])
        _write_json(stem.with_name(f"{stem.name}_events.json"), sidecars.EVENTS)


def _systems(selection: Selection, tables: list[SignalTable]) -> list[str]:
    """A label a table: letters and digits."""
    return unique([_alphanumeric(selection.told(table)) for table in tables], "")


def _alphanumeric(name: str) -> str:
    """A BIDS label: "grasp_ilc" is graspIlc."""
    parts = [part for part in re.split("[^A-Za-z0-9]+", name) if part]
    return "".join([*parts[:1], *(part[0].upper() + part[1:] for part in parts[1:])]) or "unnamed"


def _write_table(path: Path, rows: list[list[str]]) -> None:
    """A TSV file; white space within a cell is single blanks."""
    text = "".join("\t".join(" ".join(cell.split()) or NO_VALUE for cell in row) + "\n" for row in rows)
    path.write_text(text, encoding="utf-8")


def _write_json(path: Path, table: object) -> None:
    path.write_text(json.dumps(table, indent=2, ensure_ascii=False) + "\n", encoding="utf-8")
