"""Runs as files of the field: Motion-BIDS, XDF, MATLAB, OpenSim, CSV."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

from fesloop.errors import InputError, did_you_mean
from fesloop.experiment.reading import Recording
from fesloop.streams.export import csv_tables, mat, mot, motion_bids, sto, xdf
from fesloop.streams.export.names import file_name
from fesloop.streams.export.selection import select
from fesloop.streams.export.target import published

__all__ = ["FORMATS", "Exported", "export"]

FORMATS: dict[str, ModuleType] = {
    "motion-bids": motion_bids, "xdf": xdf, "mat": mat, "mot": mot, "sto": sto,
    "csv": csv_tables}
"""A writer a format: `wanted(signal)`, the signals that it takes where none is named, and `write(selection,
folder)`, which returns notes."""
_TAKES = {"mot": "joint angles (a port `angles`, rad)", "sto": "orientations (quaternions)",
          "motion-bids": "motion"}
_FOLDERS = ("motion-bids", "csv")
"""Formats that are more than one file in any case."""


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
        single = format not in _FOLDERS and target.suffix.lower() == f".{format}"
        count = len(selection.trials) * (len(selection.signals) if format in ("mot", "sto") else 1)
        if single and count > 1:
            raise InputError(f"--out {target}", f"is one file, and {count} are to be written", "a folder",
                             "name one of the trials with --trial, one of the signals with --signals")
        with published(target, single) as folder:
            notes = writer.write(selection, folder)
    files = (target,) if single else tuple(sorted(path for path in target.rglob("*") if path.is_file()))
    return Exported(target, files, tuple(notes))
