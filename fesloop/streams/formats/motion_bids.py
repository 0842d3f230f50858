"""Motion-BIDS: tracking systems that are inertial sensors, and orientations that another system measured."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from fesloop.errors import InputError, did_you_mean
from fesloop.given_files import is_file, is_folder
from fesloop.streams import checks
from fesloop.streams.formats.bids_files import ENDING, TrackingSystem, entities, read_system
from fesloop.streams.formats.channels import Channel
from fesloop.streams.formats.joined import Part, joined
from fesloop.streams.formats.one_rate import Rate, onto_one_rate
from fesloop.streams.recording import MotionRecording, Reference
from fesloop.streams.timebase import stamps_of_times

__all__ = ["ENDING", "FORMAT", "read"]

FORMAT = "motion_bids"
_QUANTITIES = {"GYRO": "gyr", "ACCEL": "acc", "MAGN": "mag"}
_QUATERNION = ("quat_w", "quat_x", "quat_y", "quat_z")
_ALLOWED = f"a *{ENDING}, or a folder with one or more"
_MOST_FILES = 10_000


def read(path: Path, sensor_set: str | None, resample: Rate | None = None) -> MotionRecording:
    """The recording in a *_motion.tsv, or in a folder: those of one subject, session, task and run.

    Parameters
    ----------
    sensor_set: names of tracking systems with commas between; a slash and one more name after them is the
        system whose orientations (channels ORNT, quaternions of the same tracked points) are the reference:
        "imu/optical". None takes every system with gyroscopes, accelerometers or magnetometers, and no
        reference: a sensor's own orientations are none.
    resample: rate of common instants to bring the systems to (`fesloop.streams.formats.one_rate`), Hz.

    Raises InputError, naming file and key or line, for what is missing, damaged or of different instants.
    """
    inertial, _, optical = (sensor_set or "").partition("/")
    files = _files(path)
    if inertial:
        chosen = [_named(name.strip(), files, path) for name in inertial.split(",")]
    else:
        chosen = list(files.values())
    systems = [read_system(file) for file in dict.fromkeys(chosen)]
    parts = [Part(f"tracking system {system.name}", system.name, system.times_s, system.values, channels)
             for system in systems if (channels := _channels(system, path))]
    if not parts:
        raise InputError(str(path), "holds no channel of an inertial sensor", ", ".join(_QUANTITIES))
    sensors = list(dict.fromkeys(channel.sensor for part in parts for channel in part.channels.values()))
    parts, resampled_hz = (parts, {}) if resample is None else onto_one_rate(parts, resample, str(path))
    start_s = float(parts[0].times_s[0])
    reference = None
    if optical:
        reference = _reference(read_system(_named(optical.strip(), files, path)), sensors, start_s)
    return joined(path, FORMAT, parts, sensor_set, reference, resampled_hz=resampled_hz,
                  pairs=[pair for system in systems for pair in system.pairs])


def _files(path: Path) -> dict[str, Path]:
    """Files of a recording by the names of their tracking systems."""
    if is_file(path):
        own = entities(path)
        beside = sorted(path.parent.glob(f"*{ENDING}"))
        alike = [file for file in beside if _but_system(file) == _but_system(path)]
        return {own.get("tracksys", path.name): path} | {
            entities(file).get("tracksys", file.name): file for file in alike}
    if not is_folder(path):
        raise InputError(str(path), "there is no such file", _ALLOWED)
    files = []
    for file in _below(path):
        files.append(file)
        if len(files) > _MOST_FILES:
            raise InputError(str(path), f"holds more than {_MOST_FILES} recordings", _ALLOWED)
    if not files:
        raise InputError(str(path), "is a folder without a Motion-BIDS recording", _ALLOWED)
    recordings = {tuple(_but_system(file).items()) for file in files}
    if len(recordings) > 1:
        raise InputError(str(path), f"holds {len(recordings)} recordings, such as "
                         + ", ".join(file.name for file in sorted(files)[:4]), "one",
                         "give the path of one *_motion.tsv")
    return {entities(file).get("tracksys", file.name): file for file in sorted(files)}


def _below(folder: Path) -> Iterator[Path]:
    """Every *_motion.tsv below a folder; raises InputError where it changes while it is searched."""
    try:
        yield from folder.rglob(f"*{ENDING}")
    except OSError as fault:
        raise InputError(str(folder), f"cannot be searched: {fault.filename}: {fault.strerror}", _ALLOWED,
                         "name the folder of one recording") from None


def _but_system(file: Path) -> dict[str, str]:
    """What tells a recording: the parts of its name but for the tracking system."""
    return {key: value for key, value in entities(file).items() if key != "tracksys"}


def _named(name: str, files: dict[str, Path], path: Path) -> Path:
    if name not in files:
        raise InputError("sensor_set", f"{path} has no tracking system {name!r}", ", ".join(files),
                         did_you_mean(name, files))
    return files[name]


def _channels(system: TrackingSystem, path: Path) -> dict[int, Channel]:
    """Channels of inertial sensors, by number; a tracked point is a sensor."""
    found = {}
    for number, channel in enumerate(system.channels):
        if channel.type not in _QUANTITIES:
            continue
        channel.require_good(f"{path}: {system.name}")
        if channel.component not in ("x", "y", "z"):
            raise InputError(f"{path}: {system.name}: channel {channel.name}", f"is the component "
                             f"{channel.component!r} of {channel.type}", "x, y, z")
        found[number] = Channel(channel.tracked_point, _QUANTITIES[channel.type],
                                "xyz".index(channel.component), channel.units)
    return found


def _reference(system: TrackingSystem, sensors: list[str], start_s: float) -> Reference:
    """Orientations of the sensors' points, w x y z, from the first sample of the sensors on."""
    columns = {(channel.tracked_point, channel.component): number
               for number, channel in enumerate(system.channels) if channel.type == "ORNT"}
    place = f"tracking system {system.name}"
    each = []
    for sensor in sensors:
        missing = [part for part in _QUATERNION if (sensor, part) not in columns]
        if missing:
            raise InputError(place, f"has no channel ORNT {missing[0]} of {sensor}",
                             "quaternions of every sensor's tracked point")
        for part in _QUATERNION:
            system.channels[columns[sensor, part]].require_good(place)
        quaternions = system.values[:, [columns[sensor, part] for part in _QUATERNION]]
        each.append(checks.orientations(quaternions, f"{place}: ORNT of {sensor}"))
    from_start = system.times_s >= start_s
    if from_start.sum() < 2:
        raise InputError(place, "ends before the sensors begin", "systems that recorded together")
    stamps, _ = stamps_of_times(system.times_s[from_start], 1.0, f"{place}: LATENCY")
    stamps = stamps + round((float(system.times_s[from_start][0]) - start_s) * 1e9)
    return Reference(stamps_ns=stamps, orientation=np.stack(each, axis=1)[from_start],
                     scored=np.ones(stamps.size, dtype=bool), sensor_frames=True, north=False)
