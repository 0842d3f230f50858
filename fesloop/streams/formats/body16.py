"""body16: 6-axis sensors worn all over the body, the example recording of the qmt toolbox."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from fesloop.errors import InputError
from fesloop.streams import checks
from fesloop.streams.recording import MotionRecording
from fesloop.streams.timebase import stamps_of_times

FORMAT = "body16"
_NEIGHBOURS = (
    ("hip", "lower_back"), ("lower_back", "upper_back"), ("upper_back", "head"),
    ("upper_back", "upper_arm_left"), ("upper_arm_left", "forearm_left"), ("forearm_left", "hand_left"),
    ("upper_back", "upper_arm_right"), ("upper_arm_right", "forearm_right"), ("forearm_right", "hand_right"),
    ("hip", "upper_leg_left"), ("upper_leg_left", "lower_leg_left"), ("lower_leg_left", "foot_left"),
    ("hip", "upper_leg_right"), ("upper_leg_right", "lower_leg_right"), ("lower_leg_right", "foot_right"),
)


def holds(content: Mapping[str, Any]) -> bool:
    """Whether a file's keys are those of this set: a structure a sensor, with gyr and acc."""
    structures = [value for value in content.values() if isinstance(value, Mapping)]
    return any("gyr" in structure or "acc" in structure for structure in structures)


def read(path: Path, content: Mapping[str, Any], sensor_set: str | None) -> MotionRecording:
    """The recording. `t` s, gyr rad/s, acc m/s^2; its `quat` fields are no reference and are not read."""
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
        path=path, source_format=FORMAT, sensor_set=None, sensors=sensors, rate=rate, stamps_ns=stamps,
        gyr=np.stack(gyr, axis=1), acc=np.stack(acc, axis=1), mag=None, reference=None, pairs=pairs)
