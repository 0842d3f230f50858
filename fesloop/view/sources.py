"""Which source a path stands for."""

from __future__ import annotations

import time
from pathlib import Path

from fesloop.errors import InputError
from fesloop.experiment.recording.reading import Recording
from fesloop.view.followed import RUNNING, FollowedRecording
from fesloop.view.played import PlayedRecording
from fesloop.view.shown import Source

_ALIVE_S = 10.0
"""A run that has written nothing for so long was killed (chosen: it writes every .4 to .8 s)."""
_PATIENCE_S, _PAUSE_S = 3.0, 0.05
"""For so long a file that is being written is opened again and again: between two of its writer's steps HDF5
can find it shorter than it says."""
_SIGNATURE = b"\x89HDF\r\n\x1a\n"
"""With which HDF5 begins (HDF5 File Format Specification 3.0, II.A)."""


def open_recording(path: Path) -> Source:
    """A recording: followed while it is being written, else played.

    Raises InputError for a file that is none, or holds no hand.
    """
    recording = _opened(path)
    try:
        if recording.status != RUNNING or not _fresh(path):
            return PlayedRecording(recording)
        return FollowedRecording(recording)
    except BaseException:
        recording.close()
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
    """Whether something was written to a file lately."""
    return time.time() - path.stat().st_mtime < _ALIVE_S
