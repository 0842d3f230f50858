"""BROAD: one 9-axis sensor under an optical reference (Laidig et al. 2021, doi 10.3390/data6070072)."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from fesloop.errors import InputError
from fesloop.streams import checks
from fesloop.streams.recording import MotionRecording, Reference
from fesloop.streams.timebase import rate_of, stamps_of_rate

FORMAT = "broad"
_T_PER_UT = 1e-6


def holds(content: Mapping[str, Any]) -> bool:
    """Whether a file's keys are those of this set."""
    return sum(key in content for key in ("imu_gyr", "imu_acc", "imu_mag", "opt_quat", "movement")) >= 2


def read(path: Path, content: Mapping[str, Any], sensor_set: str | None) -> MotionRecording:
    """The recording. imu_gyr rad/s, imu_acc m/s^2, imu_mag uT; `movement` marks the samples to score."""
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
        path=path, source_format=FORMAT, sensor_set=None, sensors=("imu",), rate=rate, stamps_ns=stamps,
        gyr=gyr[:, np.newaxis], acc=acc[:, np.newaxis], mag=mag[:, np.newaxis], reference=reference, pairs=())
