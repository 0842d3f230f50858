"""Choice of the source for a path."""

from __future__ import annotations

import time
from contextlib import ExitStack
from pathlib import Path

from fesloop.analysis.study.store.file import FILE
from fesloop.errors import InputError
from fesloop.experiment.recording.reading import Recording
from fesloop.given_files import is_file, is_folder
from fesloop.show.report.run.opening import readable
from fesloop.show.view.followed import RUNNING, FollowedRecording
from fesloop.show.view.played import PlayedRecording
from fesloop.show.view.shown import Source

_ALIVE_S = 10.0
"""Time without a write after which a run counts as killed (chosen: it writes every .4 to .8 s)."""
_PATIENCE_S, _PAUSE_S = 3.0, 0.05
"""Time for which opening a file is retried, and pause between attempts: between two steps of its writer, HDF5
can find it shorter than it says."""
_MOST_NAMED = 5
"""Most recordings of a folder that are named (chosen)."""
_SIGNATURE = b"\x89HDF\r\n\x1a\n"
"""First bytes of an HDF5 file (HDF5 File Format Specification 3.0, II.A)."""


def open_recording(path: Path) -> Source:
    """A recording: followed while it is being written, else played; of a damaged one what is left of it.

    Raises InputError for a folder, and for a file that is none, or holds no hand.
    """
    if is_folder(path):
        raise _no_file(path)
    growing = _growing(path)
    if growing is None:
        return _played(path)
    try:
        return FollowedRecording(growing)
    except BaseException:
        growing.close()
        raise


def _no_file(folder: Path) -> InputError:
    """Error for a folder, which suggests a recording."""
    if (folder / FILE).is_file():
        return InputError(str(folder), "is a study's folder, which holds the results of its runs",
                          "one recording", f"fesloop report {folder} shows the study")
    names = sorted(each.name for each in folder.glob("*.h5"))
    if not names:
        return InputError(str(folder), "is a folder, without recordings", "one recording")
    more = f" and {len(names) - _MOST_NAMED} more" if len(names) > _MOST_NAMED else ""
    return InputError(str(folder), "is a folder", f"one recording: {', '.join(names[:_MOST_NAMED])}{more}",
                      f"fesloop view {folder / names[0]}")


def _growing(path: Path) -> Recording | None:
    """A recording that is being written; None for any other file."""
    if not is_file(path) or not _may_be_growing(path):
        return None
    try:
        recording = _opened(path)
    except InputError:
        return None
    try:
        if recording.status == RUNNING:
            return recording
    except InputError:
        pass  # what is left of a damaged file is played
    recording.close()
    return None


def _played(path: Path) -> PlayedRecording:
    """A recording that is complete, or what is left of it."""
    kept = ExitStack()
    try:
        recording, notices = kept.enter_context(readable(path))
        try:
            return PlayedRecording(recording, notices, kept.close)
        except InputError as fault:
            if recording.path == path or fault.where != str(recording.path):
                raise
            raise InputError(str(path), f"is damaged, and what is left of it {fault.found}",
                             fault.allowed) from None
    except BaseException:
        kept.close()
        raise


def _opened(path: Path) -> Recording:
    until = time.monotonic() + _PATIENCE_S
    while True:
        try:
            return Recording(path)
        except InputError as fault:
            if "damaged" not in fault.found or time.monotonic() > until or not _may_be_growing(path):
                raise
        time.sleep(_PAUSE_S)


def _may_be_growing(path: Path) -> bool:
    with path.open("rb") as file:
        return file.read(len(_SIGNATURE)) == _SIGNATURE and _fresh(path)


def _fresh(path: Path) -> bool:
    """Return whether a file was modified recently."""
    return time.time() - path.stat().st_mtime < _ALIVE_S
