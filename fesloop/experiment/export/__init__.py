"""Export of runs to Motion-BIDS, XDF, MATLAB, OpenSim and CSV."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from fesloop.errors import InputError, did_you_mean
from fesloop.experiment.export import csv_tables, mat, motion_bids, opensim, xdf
from fesloop.experiment.export.selection import Selection, select
from fesloop.experiment.export.target import file_name, published
from fesloop.experiment.recording.reading import Recording, TableSignal

__all__ = ["FORMATS", "Exported", "export"]


@dataclass(slots=True)
class Format:
    """A format of exports.

    Attributes
    ----------
    write: writes a selection into an empty folder and returns notes for the user; raises InputError for any
        fault.
    takes: whether a signal is exported if none is named.
    what: noun for the signals that it takes, in messages.
    file_a_signal: whether each signal has a file of its own.
    files: noun for the files of one trial, if they are always several.
    """

    write: Callable[[Selection, Path], list[str]]
    takes: Callable[[TableSignal], bool] = lambda _: True
    what: str = "signal"
    file_a_signal: bool = False
    files: str = ""


FORMATS = {
    "motion-bids": Format(motion_bids.write, motion_bids.is_motion, "motion",
                          files="tables and their descriptions"),
    "xdf": Format(xdf.write),
    "mat": Format(mat.write),
    "mot": Format(opensim.write_mot, opensim.are_joint_angles, "joint angles (a port `angles`, rad)",
                  file_a_signal=True),
    "sto": Format(opensim.write_sto, opensim.are_orientations, "orientations (quaternions)",
                  file_a_signal=True),
    "csv": Format(csv_tables.write, files="tables and events"),
}
"""Formats by name."""


@dataclass(frozen=True, slots=True)
class Exported:
    """A finished export: its folder or file, the files in it, and notes for the user."""

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
    out: the folder to be made, or, if its name ends as the format's files do (".xdf"), the one file; None
        is exports/RUN-FORMAT.
    trial: counted from 0; None for all, a file each (a run each in Motion-BIDS).
    signals: names such as "tracker.angles"; None for all that the format takes.
    progress: receives the fraction that is written.

    Raises InputError for an invalid recording, trial, signal or target, and RunError if the disk is full;
    then nothing is left of the export.
    """
    if format not in FORMATS:
        raise InputError("--format", f"{format!r}", ", ".join(FORMATS), did_you_mean(format, FORMATS))
    chosen = FORMATS[format]
    with Recording(run) as recording:
        selection = select(recording, trial, signals, chosen.takes, chosen.what, progress)
        target = Path(out) if out else Path("exports") / f"{file_name(recording.path.stem)}-{format}"
        single = target.suffix.lower() == f".{format}"
        if single:
            _require_one_file(target, format, selection)
        elif target.suffix.lower()[1:] in FORMATS:
            raise InputError(f"--out {target}", f"has the ending of another format than {format}",
                             f"a folder, or a name that ends in .{format}")
        with published(target, single) as folder:
            notes = chosen.write(selection, folder)
    files = (target,) if single else tuple(sorted(path for path in target.rglob("*") if path.is_file()))
    return Exported(target, files, tuple(notes))


def _require_one_file(target: Path, format: str, selection: Selection) -> None:
    """Raise InputError if more than one file is to be written."""
    trials, signals = len(selection.trials), len(selection.signals)
    count = trials * (signals if FORMATS[format].file_a_signal else 1)
    if FORMATS[format].files:
        raise InputError(f"--out {target}", f"is one file, and {FORMATS[format].files} are to be written",
                         "a folder")
    if count > 1:
        raise InputError(f"--out {target}", f"is one file, and {count} are to be written", "a folder",
                         "name one of the trials with --trial, one of the signals with --signals")
