"""Recordings of inertial sensors: one way to open any of them, told apart by what is in them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Protocol

from fesloop.errors import InputError
from fesloop.streams.containers import read_container
from fesloop.streams.formats import body16, broad, chain5, wrist
from fesloop.streams.recording import MotionRecording, Reference

__all__ = ["FORMATS", "MotionRecording", "Reference", "open_recording"]


class Reader(Protocol):
    """A module that reads one format."""

    FORMAT: str

    def holds(self, content: Mapping[str, Any]) -> bool:
        """Whether a file's keys are those of this format."""

    def read(self, path: Path, content: Mapping[str, Any], sensor_set: str | None) -> MotionRecording:
        """The recording; raises InputError for any fault of the file."""


FORMATS: tuple[Reader, ...] = (broad, chain5, wrist, body16)
"""A reader a format."""


def open_recording(path: str | Path, sensor_set: str | None = None) -> MotionRecording:
    """The recording in a file.

    Parameters
    ----------
    path: a .mat or .npz file; its name does not matter.
    sensor_set: which sensors, where the file holds several sets on the same segments ("rigid" or
        "nonrigid" of chain5); None takes the first.

    Raises InputError, naming file and key, for anything that is not a sound recording of a known format.
    """
    file = Path(path)
    content = read_container(file)
    for reader in FORMATS:
        if reader.holds(content):
            return reader.read(file, content, sensor_set)
    keys = ", ".join(list(content)[:8]) or "nothing"
    raise InputError(str(file), f"is no recording of a known format, it holds {keys}",
                     ", ".join(reader.FORMAT for reader in FORMATS))
