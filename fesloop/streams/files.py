"""Recordings of inertial sensors: one way to open any of them, known by their content."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from fesloop.errors import InputError
from fesloop.given_files import is_folder
from fesloop.streams import motion_file
from fesloop.streams.formats import motion_bids, xdf
from fesloop.streams.formats.published import PUBLISHED
from fesloop.streams.formats.rates import Rate, require_one_rate
from fesloop.streams.motion_file import write_motion_file
from fesloop.streams.reading import head_of, is_container, is_hdf5, read_container, read_file
from fesloop.streams.recording import MotionRecording, Reference

__all__ = ["MotionRecording", "Reference", "import_recording", "open_recording"]

ALLOWED = ("a motion file of fesloop, an XDF file, a *_motion.tsv of Motion-BIDS or its folder, a MATLAB "
           ".mat or NumPy .npz of a known set, or any table with its layout")
_RUN, _STIMULATION = "fesloop recording", "fesloop stimulation"
_GZIP = b"\x1f\x8b"


def open_recording(path: str | Path, sensor_set: str | None = None,
                   layout: str | Path | None = None, resample: Rate | None = None) -> MotionRecording:
    """The recording in a file, or in a folder of Motion-BIDS.

    Parameters
    ----------
    path: of a motion file of fesloop, an XDF file, a *_motion.tsv or a folder that holds it, a .mat (MATLAB 5
        or 7.3) or .npz file; only the name of the .tsv matters.
    sensor_set: sensors to read, where the file holds several sets: "rigid" or "nonrigid" of chain5, the
        streams of an XDF file by their names with commas between, the tracking system of Motion-BIDS. None
        takes the first of chain5, and the only one of the others.
    layout: path of a layout, for a file that says too little of itself (`fesloop.streams.formats.layout`).
    resample: rate, Hz, of common instants for streams of different instants (see
        `fesloop.streams.formats.rates`); a layout has a key for it.

    Raises InputError, naming file and key, for anything that is not a sound recording of a known format, and
    for one whose kinds of samples have several rates.
    """
    recording = _opened(Path(path), sensor_set, layout, resample)
    require_one_rate(recording)
    return recording


def _opened(file: Path, sensor_set: str | None, layout: str | Path | None,
            resample: Rate | None) -> MotionRecording:
    """The recording as the file holds it, of whatever rates."""
    if layout is not None:
        from fesloop.streams.formats.described import read_described

        if sensor_set is not None:
            raise InputError("sensor_set", f"{sensor_set!r} and a layout are given", "one of the two")
        if resample is not None:
            raise InputError("resample", f"{resample} and a layout are given", "one of the two",
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
    if not is_container(head):
        raise InputError(str(file), "is empty" if not head else "is no recording of a known format", ALLOWED,
                         "describe it with a layout")
    content: dict[str, Any] = read_file("hdf5", file) if is_hdf5(head) else {
        "format": "", "content": read_container(file)}
    if content["format"] == motion_file.FORMAT:
        return motion_file.recording_in(content, file, sensor_set)
    if content["format"].startswith(_RUN):
        raise InputError(str(file), "is the recording of a run", ALLOWED,
                         "a block of kind playback plays its signals")
    if content["format"].startswith(_STIMULATION):
        raise InputError(str(file), "is a recording of stimulated muscle", ALLOWED,
                         "fesloop report and fesloop picture show it")
    found = content.get("content", {})
    for published in PUBLISHED:
        if published.fits(found):
            return published.read(file, found, sensor_set)
    keys = ", ".join(list(found)[:8]) or "nothing"
    raise InputError(str(file), f"is no recording of a known format, it holds {keys}",
                     ", ".join(published.name for published in PUBLISHED), "describe it with a layout")


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
