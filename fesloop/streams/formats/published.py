"""Published sets of recordings, each known by the keys of its files."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fesloop.errors import InputError
from fesloop.loop.clock import NS_PER_S
from fesloop.streams import checks
from fesloop.streams.recording import Array, MotionRecording, Reference
from fesloop.streams.timebase import rate_of, stamps_of_rate, stamps_of_times

BROAD, CHAIN5, WRIST, BODY16 = "broad", "chain5", "wrist", "body16"


@dataclass(frozen=True, slots=True)
class PublishedSet:
    """A published set of recordings.

    Attributes
    ----------
    name: as `MotionRecording.source_format` has it.
    fits: whether a file's keys are those of the set.
    read: the recording of a path, its content and a sensor set; raises InputError for any fault of the file.
    """

    name: str
    fits: Callable[[Mapping[str, Any]], bool]
    read: Callable[[Path, Mapping[str, Any], str | None], MotionRecording]


_T_PER_UT = 1e-6


def _is_broad(content: Mapping[str, Any]) -> bool:
    """Return whether a file's keys are those of BROAD."""
    return sum(key in content for key in ("imu_gyr", "imu_acc", "imu_mag", "opt_quat", "movement")) >= 2


def _read_broad(path: Path, content: Mapping[str, Any], sensor_set: str | None) -> MotionRecording:
    """BROAD: one 9-axis sensor under an optical reference (Laidig et al. 2021, doi 10.3390/data6070072).

    imu_gyr rad/s, imu_acc m/s^2, imu_mag uT; `movement` marks the samples to score.
    """
    where = str(path)
    if sensor_set is not None:
        raise InputError("sensor_set", f"{sensor_set!r}, but {where} holds one sensor", "none")
    gyr, acc, mag = (checks.numbers(content, key, (None, 3), where)
                     for key in ("imu_gyr", "imu_acc", "imu_mag"))
    quat = checks.numbers(content, "opt_quat", (None, 4), where)
    movement = checks.numbers(content, "movement", (None,), where)
    checks.equal_lengths({"imu_gyr": len(gyr), "imu_acc": len(acc), "imu_mag": len(mag),
                          "opt_quat": len(quat), "movement": len(movement)}, where)
    checks.plausible_gyr(gyr, f"{where}: imu_gyr")
    checks.plausible_acc(acc, f"{where}: imu_acc")
    mag *= _T_PER_UT
    checks.plausible_mag(mag, f"{where}: imu_mag")
    if not np.isin(movement, (0.0, 1.0)).all() or not movement.any():
        raise InputError(f"{where}: movement", "does not mark samples", "0 and 1, with a 1 somewhere")
    rate = rate_of(content, "sampling_rate", where)
    stamps = stamps_of_rate(len(gyr), rate)
    reference = Reference(
        stamps_ns=stamps, orientation=checks.orientations(quat, f"{where}: opt_quat")[:, np.newaxis],
        scored=movement > 0.0, sensor_frames=True, north=True)
    return MotionRecording(
        path=path, source_format=BROAD, sensor_set=None, sensors=("imu",), rate=rate, stamps_ns=stamps,
        gyr=gyr[:, np.newaxis], acc=acc[:, np.newaxis], mag=mag[:, np.newaxis], reference=reference, pairs=())


_CHAIN_SETS = ("rigid", "nonrigid")
_CHAIN = ("seg1", "seg2", "seg3", "seg4", "seg5")
_CHAIN_PAIRS = ((0, 1), (1, 2), (2, 3), (3, 4), (1, 3), (2, 4))
"""Spherical joint; hinges about x, y, z; and, a segment left out, the two saddles (x then y, y then z)."""
_WARM_UP_S = 5
"""Not scored: the trackers of the published figures settle in this time."""
_T_PER_GAUSS = 1e-4


def _is_chain5(content: Mapping[str, Any]) -> bool:
    """Return whether a file's keys are those of chain5."""
    return "omc" in content or any(f"imu_{name}" in content for name in _CHAIN_SETS)


def _read_chain5(path: Path, content: Mapping[str, Any], sensor_set: str | None) -> MotionRecording:
    """chain5: a jointed chain of five segments, each with a rigid and a foam-mounted 9-axis sensor.

    The sensor set is "rigid" where none is given. The optical reference has a rate of its own and is NaN
    where markers were occluded. The recording does not state the unit of its magnetometers, whose samples
    have a length near 0.6: they are read as gauss.
    """
    where = str(path)
    chosen = sensor_set or _CHAIN_SETS[0]
    if chosen not in _CHAIN_SETS:
        raise InputError("sensor_set", f"{where} has no sensor set {chosen!r}", ", ".join(_CHAIN_SETS))
    key = f"imu_{chosen}"
    names = [f"{segment}_{kind}_{axis}"
             for segment in _CHAIN for kind in ("acc", "gyr", "mag") for axis in "xyz"]
    table = checks.numbers(content, key, (None, None), where)
    samples = _picked(content, key, table, names, where).reshape(-1, len(_CHAIN), 3, 3)
    acc, gyr, mag = (np.ascontiguousarray(samples[:, :, i]) for i in range(3))
    mag *= _T_PER_GAUSS
    for i, segment in enumerate(_CHAIN):
        checks.plausible_gyr(gyr[:, i], f"{where}: {key}: {segment}_gyr")
        checks.plausible_acc(acc[:, i], f"{where}: {key}: {segment}_acc")
        checks.plausible_mag(mag[:, i], f"{where}: {key}: {segment}_mag")
    rate = rate_of(content, f"{key}_hz", where)
    return MotionRecording(
        path=path, source_format=CHAIN5, sensor_set=chosen, sensors=_CHAIN, rate=rate,
        stamps_ns=stamps_of_rate(len(table), rate), gyr=gyr, acc=acc, mag=mag,
        reference=_chain5_reference(content, where), pairs=_CHAIN_PAIRS)


def _chain5_reference(content: Mapping[str, Any], where: str) -> Reference:
    table = checks.numbers(content, "omc", (None, None), where)
    names = [f"{segment}_quat_{part}" for segment in _CHAIN for part in "wxyz"]
    quaternions = _picked(content, "omc", table, names, where).reshape(-1, len(_CHAIN), 4)
    each = [checks.orientations(quaternions[:, i], f"{where}: omc: {segment}_quat")
            for i, segment in enumerate(_CHAIN)]
    stamps = stamps_of_rate(len(table), rate_of(content, "omc_hz", where))
    return Reference(stamps_ns=stamps, orientation=np.stack(each, axis=1),
                     scored=stamps >= _WARM_UP_S * NS_PER_S, sensor_frames=True, north=False)


def _picked(content: Mapping[str, Any], key: str, table: Array, names: list[str], where: str) -> Array:
    """The named columns of a table, whose column names are listed under `key`_cols."""
    chosen = checks.columns(content, f"{key}_cols", names, where)
    listed = np.size(content[f"{key}_cols"])
    if listed != table.shape[1]:
        raise InputError(f"{where}: {key}", f"has {table.shape[1]} columns, {key}_cols names {listed}",
                         "a name a column")
    return table[:, chosen]


_WRIST = ("radius", "carpus")
_US = 1e-6


def _is_wrist(content: Mapping[str, Any]) -> bool:
    """Return whether a file's keys are those of wrist."""
    return any(f"{kind}_{segment}" in content for kind in ("imu", "gt") for segment in _WRIST)


def _read_wrist(path: Path, content: Mapping[str, Any], sensor_set: str | None) -> MotionRecording:
    """wrist: two 6-axis sensors on a robot's radius and carpus, driven through a wrist motion.

    gyr rad/s, acc m/s^2. The reference gives segment frames that are not the sensors', so only the angle
    between the two segments can be scored. Its times are in us on a clock of its own; its first row and the
    first sample coincide.
    """
    where = str(path)
    if sensor_set is not None:
        raise InputError("sensor_set", f"{sensor_set!r}, but {where} holds one set", "none")
    chosen = checks.columns(content, "imu_cols", [f"{k}_{a}" for k in ("gyr", "acc") for a in "xyz"], where)
    tables = []
    for segment in _WRIST:
        table = checks.numbers(content, f"imu_{segment}", (None, 6), where)[:, chosen]
        checks.plausible_gyr(table[:, :3], f"{where}: imu_{segment}: gyr")
        checks.plausible_acc(table[:, 3:], f"{where}: imu_{segment}: acc")
        tables.append(table)
    checks.equal_lengths({f"imu_{s}": len(t) for s, t in zip(_WRIST, tables, strict=True)}, where)
    samples = np.stack(tables, axis=1)
    rate = rate_of(content, "hz", where)
    return MotionRecording(
        path=path, source_format=WRIST, sensor_set=None, sensors=_WRIST, rate=rate,
        stamps_ns=stamps_of_rate(len(samples), rate), gyr=np.ascontiguousarray(samples[:, :, :3]),
        acc=np.ascontiguousarray(samples[:, :, 3:]), mag=None, reference=_wrist_reference(content, where),
        pairs=((0, 1),))


def _wrist_reference(content: Mapping[str, Any], where: str) -> Reference:
    names = ["TIME"] + [f"QUATERNION_{i}" for i in range(4)]
    chosen = checks.columns(content, "gt_cols", names, where)
    tables = [checks.numbers(content, f"gt_{segment}", (None, 5), where)[:, chosen] for segment in _WRIST]
    checks.equal_lengths({f"gt_{s}": len(t) for s, t in zip(_WRIST, tables, strict=True)}, where)
    if not np.array_equal(tables[0][:, 0], tables[1][:, 0], equal_nan=True):
        raise InputError(f"{where}: gt_{_WRIST[1]}", f"has other times than gt_{_WRIST[0]}",
                         "equal times")
    stamps, _ = stamps_of_times(tables[0][:, 0], _US, f"{where}: gt_{_WRIST[0]}: TIME")
    each = [checks.orientations(np.ascontiguousarray(table[:, 1:]), f"{where}: gt_{segment}")
            for segment, table in zip(_WRIST, tables, strict=True)]
    return Reference(stamps_ns=stamps, orientation=np.stack(each, axis=1),
                     scored=np.ones(stamps.size, dtype=bool), sensor_frames=False, north=False)


_NEIGHBOURS = (
    ("hip", "lower_back"), ("lower_back", "upper_back"), ("upper_back", "head"),
    ("upper_back", "upper_arm_left"), ("upper_arm_left", "forearm_left"), ("forearm_left", "hand_left"),
    ("upper_back", "upper_arm_right"), ("upper_arm_right", "forearm_right"), ("forearm_right", "hand_right"),
    ("hip", "upper_leg_left"), ("upper_leg_left", "lower_leg_left"), ("lower_leg_left", "foot_left"),
    ("hip", "upper_leg_right"), ("upper_leg_right", "lower_leg_right"), ("lower_leg_right", "foot_right"),
)


def _is_body16(content: Mapping[str, Any]) -> bool:
    """Return whether a file's keys are those of body16: a structure a sensor, with gyr and acc."""
    structures = [value for value in content.values() if isinstance(value, Mapping)]
    return any("gyr" in structure or "acc" in structure for structure in structures)


def _read_body16(path: Path, content: Mapping[str, Any], sensor_set: str | None) -> MotionRecording:
    """body16: 6-axis sensors all over the body, the example recording of the qmt toolbox.

    `t` s, gyr rad/s, acc m/s^2; its `quat` fields are no reference and are not read.
    """
    where = str(path)
    if sensor_set is not None:
        raise InputError("sensor_set", f"{sensor_set!r}, but {where} holds one set", "none")
    stamps, rate = stamps_of_times(checks.numbers(content, "t", (None,), where), 1.0, f"{where}: t")
    sensors = tuple(key for key in content if key != "t")
    gyr, acc, lengths = [], [], {"t": stamps.size}
    for name in sensors:
        if not isinstance(content[name], Mapping):
            raise InputError(f"{where}: {name}", "is not a sensor", "a structure with gyr and acc")
        place = f"{where}: {name}"
        gyr.append(checks.numbers(content[name], "gyr", (None, 3), place))
        acc.append(checks.numbers(content[name], "acc", (None, 3), place))
        lengths |= {f"{name}.gyr": len(gyr[-1]), f"{name}.acc": len(acc[-1])}
        checks.plausible_gyr(gyr[-1], f"{place}: gyr")
        checks.plausible_acc(acc[-1], f"{place}: acc")
    checks.equal_lengths(lengths, where)
    pairs = tuple((sensors.index(parent), sensors.index(child)) for parent, child in _NEIGHBOURS
                  if parent in sensors and child in sensors)
    return MotionRecording(
        path=path, source_format=BODY16, sensor_set=None, sensors=sensors, rate=rate, stamps_ns=stamps,
        gyr=np.stack(gyr, axis=1), acc=np.stack(acc, axis=1), mag=None, reference=None, pairs=pairs)


PUBLISHED = (PublishedSet(BROAD, _is_broad, _read_broad), PublishedSet(CHAIN5, _is_chain5, _read_chain5),
             PublishedSet(WRIST, _is_wrist, _read_wrist), PublishedSet(BODY16, _is_body16, _read_body16))
