"""Motion-BIDS: tracking systems that are inertial sensors, and orientations that another system measured.

A recording is a table of motion without header, its channels and its description: Brain Imaging Data
Structure 1.9 or later, modality-specific files, motion (Jeung et al. 2024, doi 10.1038/s41597-024-03559-8).
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fesloop.errors import InputError, did_you_mean
from fesloop.given_files import is_file, is_folder
from fesloop.streams import checks
from fesloop.streams.checks import Array
from fesloop.streams.formats.channels import Channel, Part, joined
from fesloop.streams.formats.rates import Rate, onto_one_rate
from fesloop.streams.labels import factor
from fesloop.streams.recording import MotionRecording, Reference
from fesloop.streams.text_table import TextForm, read_table, read_text
from fesloop.streams.timebase import exact_rate, require_stated_rate, stamps_of_times

ENDING = "_motion.tsv"
PAIRS = "SensorPairs"
"""Key of *_motion.json, fesloop's own: (parent, child) tracked points on neighbouring segments."""
_MISSING = ("n/a",)
_TABLE = TextForm(separator="\t", header=0, missing=_MISSING)
_REQUIRED = ("name", "component", "type", "tracked_point", "units")
_LEVELS = 4
"""Levels of folders with BIDS metadata that several files share: motion, session, subject, dataset."""


@dataclass(frozen=True, slots=True)
class BidsChannel:
    """A row of *_channels.tsv; see BIDS for what the columns mean.

    `sampling_frequency`, Hz: 0 for none. `bad`: whether its status is "bad", for `why` (status_description).
    """

    name: str
    component: str
    type: str
    tracked_point: str
    units: str
    sampling_frequency: float = 0.0
    bad: bool = False
    why: str = ""

    def require_good(self, where: str) -> None:
        """Raise InputError for a channel whose status in the recording is "bad"."""
        if self.bad:
            because = f" ({self.why})" if self.why not in ("", *_MISSING) else ""
            raise InputError(f"{where}: channel {self.name}", f"has the status bad{because}", "good, or n/a",
                             "choose systems without it with sensor_set, or describe the table with a layout "
                             "that leaves its sensor out")


@dataclass(frozen=True, slots=True, eq=False)
class TrackingSystem:
    """Samples of one tracking system.

    Attributes
    ----------
    name: of the tracking system, as the file's name has it.
    channels: one a column.
    times_s: (n,), from the start of the recording.
    values: (n, channels), NaN where missing.
    pairs: (parent, child) tracked points on neighbouring segments, where the description states them.
    """

    name: str
    channels: tuple[BidsChannel, ...]
    times_s: Array
    values: Array
    pairs: tuple[tuple[str, str], ...] = ()


def entities(path: Path) -> dict[str, str]:
    """The parts of a BIDS file name: {"sub": "01", "task": "grasp", "tracksys": "imu"}."""
    parts = (part.partition("-") for part in path.name.removesuffix(ENDING).split("_"))
    return {key: value for key, dash, value in parts if dash}


def read_system(path: Path) -> TrackingSystem:
    """A tracking system's recording, from its *_motion.tsv and the files that describe it.

    Raises InputError, naming file and key or line, for what is missing or does not fit.
    """
    described = _beside(path, "channels.tsv")
    channels = _read_channels(described)
    values = read_table(path, _TABLE).values
    if values.shape[1] != len(channels):
        raise InputError(str(path), f"has {values.shape[1]} columns, its channels are {len(channels)}",
                         "a row of *_channels.tsv for each column")
    times = _instants(path, channels, values)
    require_stated_rate(max(channel.sampling_frequency for channel in channels), times,
                        f"{described}: sampling_frequency")
    return TrackingSystem(entities(path).get("tracksys", path.name), channels, times, values, _pairs(path))


def _pairs(path: Path) -> tuple[tuple[str, str], ...]:
    """Pairs of tracked points in the description, under `PAIRS`."""
    description = _find_beside(path, "motion.json")
    stated = _read_description(description).get(PAIRS, []) if description is not None else []
    if not (isinstance(stated, list) and all(
            isinstance(pair, list) and len(pair) == 2 and all(isinstance(name, str) for name in pair)
            for pair in stated)):
        raise InputError(f"{description}: {PAIRS}", "holds no pairs of names", '[["forearm", "hand"]]')
    return tuple((parent, child) for parent, child in stated)


def _beside(path: Path, suffix: str) -> Path:
    """The file that describes another; raises InputError where there is none."""
    found = _find_beside(path, suffix)
    if found is None:
        missing = path.with_name(path.name.removesuffix(ENDING) + f"_{suffix}")
        raise InputError(str(missing), f"is missing, {path.name} needs it",
                         "a complete Motion-BIDS recording")
    return found


def _find_beside(path: Path, suffix: str) -> Path | None:
    """The file that describes another: beside it, or above it under a name with fewer parts."""
    own = set(path.name.removesuffix(ENDING).split("_"))
    for folder in [path.parent, *path.absolute().parents[1:_LEVELS]]:
        for candidate in sorted(folder.glob(f"*_{suffix}")):
            if set(candidate.name.removesuffix(f"_{suffix}").split("_")) <= own:
                return candidate
    return None


def _read_channels(path: Path) -> tuple[BidsChannel, ...]:
    rows = [line.split("\t") for line in read_text(path, "a table of channels").splitlines() if line.strip()]
    names = [name.strip() for name in rows[0]] if rows else []
    for key in _REQUIRED:
        if names.count(key) != 1:
            raise InputError(f"{path}: {key}", "is a column twice" if key in names else "is no column",
                             ", ".join(_REQUIRED))
    channels = []
    for line, row in enumerate(rows[1:], start=2):
        if len(row) != len(names):
            raise InputError(f"{path}: line {line}", f"has {len(row)} columns, the first has {len(names)}",
                             "rows of equal length")
        cells = dict(zip(names, (cell.strip() for cell in row), strict=True))
        channels.append(BidsChannel(
            name=cells["name"], component=cells["component"], type=cells["type"],
            tracked_point=cells["tracked_point"], units=cells["units"],
            sampling_frequency=_hertz(cells, f"{path}: line {line}"),
            bad=_is_bad(cells, f"{path}: line {line}"),
            why=cells.get("status_description", _MISSING[0])))
    if not channels:
        raise InputError(str(path), "names no channel", "one or more")
    return tuple(channels)


def _is_bad(cells: Mapping[str, str], where: str) -> bool:
    """Return whether a row's optional column `status` marks its channel."""
    status = cells.get("status", _MISSING[0])
    if status not in ("good", "bad", *_MISSING):
        raise InputError(f"{where}: status", f"{status[:40]!r} is no status", "good, bad or n/a")
    return status == "bad"


def _hertz(cells: Mapping[str, str], where: str) -> float:
    """A channel's rate, Hz, from a column that BIDS leaves open; 0 for none."""
    text = cells.get("sampling_frequency", _MISSING[0])
    try:
        hertz = 0.0 if text in _MISSING else float(text)
    except ValueError:
        hertz = math.nan
    if not (math.isfinite(hertz) and hertz >= 0.0):
        raise InputError(f"{where}: sampling_frequency", f"{text[:40]!r} is no rate", "Hz, or n/a")
    return hertz


def _instants(path: Path, channels: tuple[BidsChannel, ...], values: Array) -> Array:
    """Instants of the samples: of the channel LATENCY, else of the sampling frequency that is stated."""
    latencies = [number for number, channel in enumerate(channels) if channel.type == "LATENCY"]
    if len(latencies) > 1:
        raise InputError(str(path), f"has {len(latencies)} channels LATENCY", "one or none")
    if latencies:
        channels[latencies[0]].require_good(str(path))
        unit = channels[latencies[0]].units
        times = values[:, latencies[0]] * factor("time", unit, f"{path}: units of LATENCY")
        description = _find_beside(path, "motion.json")
        if description is not None:
            key, stated = _sampling_frequency(description)
            require_stated_rate(stated or 0.0, times, f"{description}: {key}")
        return times
    description = _beside(path, "motion.json")
    key, stated = _sampling_frequency(description)
    if stated is None:
        raise InputError(f"{description}: {key}", "is missing, or no number", "Hz")
    return np.arange(len(values)) / float(exact_rate(stated, f"{description}: {key}"))


def _sampling_frequency(description: Path) -> tuple[str, float | None]:
    """Key under which a description states a rate, and the rate, Hz; None where it states none."""
    stated = _read_description(description)
    key = "SamplingFrequencyEffective" if _is_number(stated.get("SamplingFrequencyEffective")) else (
        "SamplingFrequency")
    return key, float(stated[key]) if _is_number(stated.get(key)) else None


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


def _read_description(path: Path) -> dict[str, Any]:
    try:
        content = json.loads(read_text(path, "a JSON file"))
    except InputError:
        raise
    except (ValueError, RecursionError) as fault:
        raise InputError(str(path), f"is no JSON: {fault}", "a JSON object") from None
    if not isinstance(content, dict):
        raise InputError(str(path), "is no JSON object", "a JSON object")
    return content


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
    resample: rate of common instants to bring the systems to (`fesloop.streams.formats.rates`), Hz.

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
        raise InputError(str(path), "is a folder without a Motion-BIDS recording", _ALLOWED,
                         "of a recording in several tables, import one, with a layout that names the others "
                         'as {file = "NAME", columns = [...]}')
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
    """Parts of a recording's name except the tracking system."""
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
