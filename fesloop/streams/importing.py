"""From a file of the field to a motion file of fesloop."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from fesloop.streams.files import open_recording
from fesloop.streams.formats.one_rate import Rate
from fesloop.streams.motion_file import write_motion_file
from fesloop.streams.recording import MotionRecording


def import_recording(source: str | Path, target: str | Path, layout: str | Path | None = None,
                     sensor_set: str | None = None, resample: Rate | None = None) -> MotionRecording:
    """Read a recording, write it as a motion file (`fesloop.streams.motion_file`), and give it.

    Parameters
    ----------
    source, sensor_set, layout, resample: see `fesloop.streams.files.open_recording`.
    target: the file to write; none is written over.

    Raises InputError for anything that is not a sound recording of a known format, and where `target` exists
    or cannot be written.
    """
    found = open_recording(source, sensor_set, layout, resample)
    recording = replace(found, source=found.source or found.path.name)
    write_motion_file(recording, Path(target))
    return recording
