"""wrist: two 6-axis sensors on a robot's radius and carpus, driven through a wrist motion.

The reference gives segment frames that are not the sensors', so only the angle between the two segments
can be scored. Its times are in us on a clock of its own; its first row and the first sample coincide.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from fesloop.errors import InputError
from fesloop.streams import checks
from fesloop.streams.recording import MotionRecording, Reference
from fesloop.streams.timebase import rate_of, stamps_of_rate, stamps_of_times

FORMAT = "wrist"
SEGMENTS = ("radius", "carpus")
_US = 1e-6


def holds(content: Mapping[str, Any]) -> bool:
    """Whether a file's keys are those of this set."""
    return any(f"{kind}_{segment}" in content for kind in ("imu", "gt") for segment in SEGMENTS)


def read(path: Path, content: Mapping[str, Any], sensor_set: str | None) -> MotionRecording:
    """The recording: gyr rad/s, acc m/s^2."""
    where = str(path)
    if sensor_set is not None:
        raise InputError("sensor_set", f"{sensor_set!r}, but {where} holds one set", "none")
    chosen = checks.columns(content, "imu_cols", [f"{k}_{a}" for k in ("gyr", "acc") for a in "xyz"], where)
    tables = []
    for segment in SEGMENTS:
        table = checks.numbers(content, f"imu_{segment}", (None, 6), where)[:, chosen]
        checks.plausible_gyr(table[:, :3], f"{where}: imu_{segment}: gyr")
        checks.plausible_acc(table[:, 3:], f"{where}: imu_{segment}: acc")
        tables.append(table)
    checks.equal_lengths({f"imu_{s}": len(t) for s, t in zip(SEGMENTS, tables, strict=True)}, where)
    samples = np.stack(tables, axis=1)
    rate = rate_of(content, "hz", where)
    return MotionRecording(
        path=path, source_format=FORMAT, sensor_set=None, sensors=SEGMENTS, rate=rate,
        stamps_ns=stamps_of_rate(len(samples), rate), gyr=np.ascontiguousarray(samples[:, :, :3]),
        acc=np.ascontiguousarray(samples[:, :, 3:]), mag=None, reference=_reference(content, where),
        pairs=((0, 1),))


def _reference(content: Mapping[str, Any], where: str) -> Reference:
    names = ["TIME"] + [f"QUATERNION_{i}" for i in range(4)]
    chosen = checks.columns(content, "gt_cols", names, where)
    tables = [checks.numbers(content, f"gt_{segment}", (None, 5), where)[:, chosen] for segment in SEGMENTS]
    checks.equal_lengths({f"gt_{s}": len(t) for s, t in zip(SEGMENTS, tables, strict=True)}, where)
    if not np.array_equal(tables[0][:, 0], tables[1][:, 0], equal_nan=True):
        raise InputError(f"{where}: gt_{SEGMENTS[1]}", f"has other times than gt_{SEGMENTS[0]}",
                         "equal times")
    stamps, _ = stamps_of_times(tables[0][:, 0], _US, f"{where}: gt_{SEGMENTS[0]}: TIME")
    each = [checks.orientations(np.ascontiguousarray(table[:, 1:]), f"{where}: gt_{segment}")
            for segment, table in zip(SEGMENTS, tables, strict=True)]
    return Reference(stamps_ns=stamps, orientation=np.stack(each, axis=1),
                     scored=np.ones(stamps.size, dtype=bool), sensor_frames=False, north=False)
