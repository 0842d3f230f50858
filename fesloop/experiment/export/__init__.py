"""Runs as files of the field: Motion-BIDS, XDF, MATLAB, OpenSim, CSV."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from fesloop.errors import InputError, did_you_mean
from fesloop.experiment.export import csv_tables, mat, mot, motion_bids, sto, xdf
from fesloop.experiment.export.selection import Selection, select
from fesloop.experiment.export.target import file_name, published
from fesloop.experiment.recording.reading import Recording
from fesloop.experiment.recording.signal_table import TableSignal

__all__ = ["FORMATS", "Exported", "export"]


class Writer(Protocol):
    """A module that writes one format."""

    def wanted(self, signal: TableSignal) -> bool:
        """Whether a signal is written where none is named."""

    def write(self, selection: Selection, folder: Path) -> list[str]:
        """Write into an empty folder; what a user should know of it. Raises InputError for any fault."""


FORMATS: dict[str, Writer] = {
    "motion-bids": motion_bids, "xdf": xdf, "mat": mat, "mot": mot, "sto": sto, "csv": csv_tables}
"""A writer a format."""
_TAKES = {"mot": "joint angles (a port `angles`, rad)", "sto": "orientations (quaternions)",
          "motion-bids": "motion"}
_A_SIGNAL_A_FILE = ("mot", "sto")
_FOLDERS = {"csv": "tables and events", "motion-bids": "tables and what describes them"}
"""Formats that are several files however little is written, and which."""


@dataclass(frozen=True, slots=True)
class Exported:
    """What was written: the folder or file, the files in it, and what a user should know of it."""

    path: Path
    files: tuple[Path, ...]
    notes: tuple[str, ...]


def export(run: str | Path, format: str, out: str | Path | None = None, trial: int | None = None,
           signals: Sequence[str] | None = None,
           progress: Callable[[float], object] = lambda fraction: None) -> Exported:
    """Write a recording's signals in another format.

    Parameters
    ----------
    run: the recording.
    format: of `FORMATS`.
    out: the folder to be made, or, where its name ends as the format's files do (".xdf"), the one file; None
        is exports/RUN-FORMAT.
    trial: counted from 0; None for all, a file each (a run each in Motion-BIDS).
    signals: names such as "tracker.angles"; None for all that the format is for.
    progress: is told the fraction that is written.

    Raises InputError for a recording, trial, signal or target that cannot be used, and RunError where the
    disk is full; then nothing is left of the export.
    """
    if format not in FORMATS:
        raise InputError("--format", f"{format!r}", ", ".join(FORMATS), did_you_mean(format, FORMATS))
    writer = FORMATS[format]
    with Recording(run) as recording:
        selection = select(recording, trial, signals, writer.wanted, _TAKES.get(format, "signal"), progress)
        target = Path(out) if out else Path("exports") / f"{file_name(recording.path.stem)}-{format}"
        single = target.suffix.lower() == f".{format}"
        if single:
            _require_one_file(target, format, selection)
        elif target.suffix.lower()[1:] in FORMATS:
            raise InputError(f"--out {target}", f"ends as files of another format do than {format}",
                             f"a folder, or a name that ends in .{format}")
        with published(target, single) as folder:
            notes = writer.write(selection, folder)
    files = (target,) if single else tuple(sorted(path for path in target.rglob("*") if path.is_file()))
    return Exported(target, files, tuple(notes))


def _require_one_file(target: Path, format: str, selection: Selection) -> None:
    """Raise InputError where more than one file is to be written."""
    trials, signals = len(selection.trials), len(selection.signals)
    count = trials * (signals if format in _A_SIGNAL_A_FILE else 1)
    if format in _FOLDERS:
        raise InputError(f"--out {target}", f"is one file, and {_FOLDERS[format]} are to be written",
                         "a folder")
    if count > 1:
        raise InputError(f"--out {target}", f"is one file, and {count} are to be written", "a folder",
                         "name one of the trials with --trial, one of the signals with --signals")
