"""Recordings of inertial sensors: one way to open any of them, told apart by what is in them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, Protocol

from fesloop.errors import InputError
from fesloop.given_files import is_folder
from fesloop.streams import motion_file
from fesloop.streams.containers.hdf5 import form_of
from fesloop.streams.containers.reading import head_of, is_container, is_hdf5, read_container
from fesloop.streams.formats import body16, broad, chain5, motion_bids, wrist, xdf
from fesloop.streams.formats.one_rate import Rate
from fesloop.streams.mixed_rates import require_one_rate
from fesloop.streams.motion_file import write_motion_file
from fesloop.streams.recording import MotionRecording, Reference

__all__ = ["FORMATS", "MotionRecording", "Reference", "open_recording"]

ALLOWED = ("a motion file of fesloop, an XDF file, a *_motion.tsv of Motion-BIDS or its folder, a MATLAB "
           ".mat or NumPy .npz of a known set, or any table with its layout")
_RUN = "fesloop recording"
_GZIP = b"\x1f\x8b"


class Reader(Protocol):
    """A module that reads one form of a container's content."""

    FORMAT: str

    def holds(self, content: Mapping[str, Any]) -> bool:
        """Whether a file's keys are those of this format."""

    def read(self, path: Path, content: Mapping[str, Any], sensor_set: str | None) -> MotionRecording:
        """The recording; raises InputError for any fault of the file."""


FORMATS: tuple[Reader, ...] = (broad, chain5, wrist, body16)
"""A reader a published set."""


def open_recording(path: str | Path, sensor_set: str | None = None,
                   layout: str | Path | None = None, resample: Rate | None = None) -> MotionRecording:
    """The recording in a file, or in a folder of Motion-BIDS.

    Parameters
    ----------
    path: of a motion file of ours, an XDF file, a *_motion.tsv or a folder that holds it, a .mat (MATLAB 5
        or 7.3) or .npz file; but for the .tsv its name does not matter.
    sensor_set: which sensors, where the file holds several sets: "rigid" or "nonrigid" of chain5, the
        streams of an XDF file by their names with commas between, the tracking system of Motion-BIDS. None
        takes the first of chain5, and what there is in the others where that is one set.
    layout: of a file that says too little of itself (see `fesloop.streams.formats.layout`).
    resample: rate, Hz, to bring streams of different instants to, where the file holds several (see
        `fesloop.streams.formats.one_rate`); a layout has a key for it.

    Raises InputError, naming file and key, for anything that is not a sound recording of a known format, and
    for one whose kinds of samples have several rates.
    """
    recording = _opened(Path(path), sensor_set, layout, resample)
    require_one_rate(recording)
    return recording


def _opened(file: Path, sensor_set: str | None, layout: str | Path | None,
            resample: Rate | None) -> MotionRecording:
    """The recording as it is in the file."""
    if layout is not None:
        from fesloop.streams.formats.described import read_described

        if sensor_set is not None:
            raise InputError("sensor_set", f"{sensor_set!r} beside a layout", "one of the two")
        if resample is not None:
            raise InputError("resample", f"{resample} beside a layout", "one of the two",
                             f"write `resample = {resample}` into the layout")
        return read_described(file, Path(layout))
    if is_folder(file) or file.name.endswith(motion_bids.ENDING):
        return motion_bids.read(file, sensor_set, resample)
    head = head_of(file, ALLOWED)
    if head.startswith(_GZIP):
        raise InputError(str(file), "is compressed with gzip", ALLOWED, "unpack it with gunzip")
    if head.startswith(xdf.SIGNATURE):
        return xdf.read(file, sensor_set, resample)
    if resample is not None:
        raise InputError("resample", f"{file} has one time base", "an XDF file, or Motion-BIDS",
                         "leave it out")
    if is_hdf5(head):
        form = form_of(file, ALLOWED)
        if form == motion_file.FORMAT:
            return motion_file.read_motion_file(file, sensor_set)
        if form.startswith(_RUN):
            raise InputError(str(file), "is the recording of a run", ALLOWED,
                             "a block of kind playback plays its signals")
    if not is_container(head):
        raise InputError(str(file), "is empty" if not head else "is no recording of a known format", ALLOWED,
                         "describe it with a layout")
    return _of_a_known_set(file, sensor_set)


def _of_a_known_set(file: Path, sensor_set: str | None) -> MotionRecording:
    content = read_container(file)
    for reader in FORMATS:
        if reader.holds(content):
            return reader.read(file, content, sensor_set)
    keys = ", ".join(list(content)[:8]) or "nothing"
    raise InputError(str(file), f"is no recording of a known format, it holds {keys}",
                     ", ".join(reader.FORMAT for reader in FORMATS), "describe it with a layout")


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
