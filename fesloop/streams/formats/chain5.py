"""chain5: a jointed chain of five segments, each with a rigid and a foam-mounted 9-axis sensor.

The optical reference runs at a rate of its own and is NaN where markers were occluded. The recording does
not state the unit of its magnetometers, whose samples have a length near 0.6: they are read as gauss.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from fesloop.errors import InputError
from fesloop.loop.clock import NS_PER_S
from fesloop.streams import checks
from fesloop.streams.recording import Array, MotionRecording, Reference
from fesloop.streams.timebase import rate_of, stamps_of_rate

FORMAT = "chain5"
SETS = ("rigid", "nonrigid")
SEGMENTS = ("seg1", "seg2", "seg3", "seg4", "seg5")
PAIRS = ((0, 1), (1, 2), (2, 3), (3, 4), (1, 3), (2, 4))
"""Spherical joint; hinges about x, y, z; and, a segment left out, the two saddles (x then y, y then z)."""
WARM_UP_S = 5
"""Not scored: the trackers of the published figures settle in this time."""
_T_PER_GAUSS = 1e-4


def holds(content: Mapping[str, Any]) -> bool:
    """Whether a file's keys are those of this set."""
    return "omc" in content or any(f"imu_{name}" in content for name in SETS)


def read(path: Path, content: Mapping[str, Any], sensor_set: str | None) -> MotionRecording:
    """The recording of one sensor set, "rigid" where none is asked for."""
    where = str(path)
    chosen = sensor_set or SETS[0]
    if chosen not in SETS:
        raise InputError("sensor_set", f"{where} has no sensor set {chosen!r}", ", ".join(SETS))
    key = f"imu_{chosen}"
    names = [f"{segment}_{kind}_{axis}"
             for segment in SEGMENTS for kind in ("acc", "gyr", "mag") for axis in "xyz"]
    table = checks.numbers(content, key, (None, None), where)
    samples = _picked(content, key, table, names, where).reshape(-1, len(SEGMENTS), 3, 3)
    acc, gyr, mag = (np.ascontiguousarray(samples[:, :, i]) for i in range(3))
    mag *= _T_PER_GAUSS
    for i, segment in enumerate(SEGMENTS):
        checks.plausible_gyr(gyr[:, i], f"{where}: {key}: {segment}_gyr")
        checks.plausible_acc(acc[:, i], f"{where}: {key}: {segment}_acc")
        checks.plausible_mag(mag[:, i], f"{where}: {key}: {segment}_mag")
    rate = rate_of(content, f"{key}_hz", where)
    return MotionRecording(
        path=path, source_format=FORMAT, sensor_set=chosen, sensors=SEGMENTS, rate=rate,
        stamps_ns=stamps_of_rate(len(table), rate), gyr=gyr, acc=acc, mag=mag,
        reference=_reference(content, where), pairs=PAIRS)


def _reference(content: Mapping[str, Any], where: str) -> Reference:
    table = checks.numbers(content, "omc", (None, None), where)
    names = [f"{segment}_quat_{part}" for segment in SEGMENTS for part in "wxyz"]
    quaternions = _picked(content, "omc", table, names, where).reshape(-1, len(SEGMENTS), 4)
    each = [checks.orientations(quaternions[:, i], f"{where}: omc: {segment}_quat")
            for i, segment in enumerate(SEGMENTS)]
    stamps = stamps_of_rate(len(table), rate_of(content, "omc_hz", where))
    return Reference(stamps_ns=stamps, orientation=np.stack(each, axis=1),
                     scored=stamps >= WARM_UP_S * NS_PER_S, sensor_frames=True, north=False)


def _picked(content: Mapping[str, Any], key: str, table: Array, names: list[str], where: str) -> Array:
    """The named columns of a table whose column names stand under `key`_cols."""
    chosen = checks.columns(content, f"{key}_cols", names, where)
    listed = np.size(content[f"{key}_cols"])
    if listed != table.shape[1]:
        raise InputError(f"{where}: {key}", f"has {table.shape[1]} columns, {key}_cols names {listed}",
                         "a name a column")
    return table[:, chosen]
