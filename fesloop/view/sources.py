"""Which source a path stands for."""

from __future__ import annotations

import time
from pathlib import Path

from fesloop.experiment.recording.reading import Recording
from fesloop.view.followed import RUNNING, FollowedRecording
from fesloop.view.played import PlayedRecording
from fesloop.view.shown import Source

_ALIVE_S = 10.0
"""A run that has written nothing for so long was killed (chosen: it writes every .4 to .8 s)."""


def open_recording(path: Path) -> Source:
    """A recording: followed while it is being written, else played.

    Raises InputError for a file that is none, or holds no hand.
    """
    with Recording(path) as recording:
        running = recording.status == RUNNING
    if running and time.time() - path.stat().st_mtime < _ALIVE_S:
        return FollowedRecording(path)
    return PlayedRecording(path)
