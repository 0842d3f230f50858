"""Recordings of inertial sensors, of whatever file."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.errors import InputError
from fesloop.loop.signals import require_pairs


def content_hash(named: Any, arrays: Sequence[NDArray[Any] | None]) -> str:
    """SHA-256 of plain values and of arrays with their types and shapes, as hexadecimal text."""
    forms = [None if array is None else [array.dtype.str, array.shape] for array in arrays]
    total = hashlib.sha256(json.dumps([named, forms]).encode())
    for array in arrays:
        if array is not None:
            total.update(np.ascontiguousarray(array).tobytes())
    return total.hexdigest()


def require_the_same(path: str, given: str, found: str) -> None:
    """Raise InputError for a file whose contents are not those of a fingerprint that is given."""
    if given not in ("", found):
        raise InputError("recording", f"{path} has changed, its fingerprint is {found[:12]}", f"{given[:12]}",
                         'bring the file back, or set fingerprint to "" to play this one')


Array = NDArray[np.float64]
Stamps = NDArray[np.int64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Reference:
    """Orientations measured by other means, with a time base of their own.

    Attributes
    ----------
    stamps_ns: (m,), ns on the recording's time base, increasing.
    orientation: (m, n_sensors, 4), segment to reference frame (z up), w x y z; NaN where unknown.
    scored: (m,), instants to be scored.
    sensor_frames: whether a segment's frame is its sensor's, so that orientations can be compared; where
        it is not, the angle between two segments still can.
    north: whether the reference frame is ENU; where it is not, only headings relative to a constant are
        comparable.
    """

    stamps_ns: Stamps
    orientation: Array
    scored: NDArray[np.bool_]
    sensor_frames: bool
    north: bool


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MotionRecording:
    """Samples of one or more inertial sensors. Arrays are read-only.

    Attributes
    ----------
    path: the file.
    source_format: of the file that the samples come from, such as "broad" or "xdf"; it outlives an import.
    sensor_set: name of the set of sensors, where the file holds more than one on the same segments.
    sensors: their names, n_sensors of them.
    rate: exact, Hz; None where the samples are not evenly spaced.
    stamps_ns: (n_samples,), from 0 on.
    gyr, acc: (n_samples, n_sensors, 3), rad/s and m/s^2 in the sensor's frame; acc is +g upwards at rest;
        NaN where a sensor's sample was lost.
    mag: (n_samples, n_sensors, 3), T, NaN where lost; or None.
    reference: orientations to compare a tracker with, or None.
    pairs: (parent, child) numbers of sensors on neighbouring segments.
    source: name of the file that was imported; empty where this is the file itself.
    source_units: units in which that file gives "gyr", "acc" and "mag", as it names them; empty where it
        names none.
    left_out: labels of channels of the file's inertial sensors that are not understood, and so not here.
    resampled_hz: by name, the rate that each stream of the source had before all were brought to common
        instants, Hz; empty where samples are as they were taken.
    origin_s: instant of the first sample on the clock of the source, which stamps its other streams (muscle
        signals, markers) too; None where the source has no instants.
    """

    path: Path
    source_format: str
    sensor_set: str | None
    sensors: tuple[str, ...]
    rate: Fraction | None
    stamps_ns: Stamps
    gyr: Array
    acc: Array
    mag: Array | None
    reference: Reference | None
    pairs: tuple[tuple[int, int], ...]
    source: str = ""
    source_units: Mapping[str, str] = field(default_factory=dict)
    left_out: tuple[str, ...] = ()
    resampled_hz: Mapping[str, float] = field(default_factory=dict)
    origin_s: float | None = None

    def fingerprint(self) -> str:
        """SHA-256 of all that blocks and scores use, as hexadecimal text; not of path and source."""
        named: list[Any] = [self.sensors, self.pairs, None if self.rate is None else str(self.rate)]
        arrays: list[NDArray[Any] | None] = [self.stamps_ns, self.gyr, self.acc, self.mag]
        if self.reference is not None:
            named += [self.reference.sensor_frames, self.reference.north]
            arrays += [self.reference.stamps_ns, self.reference.orientation, self.reference.scored]
        return content_hash(named, arrays)

    def __post_init__(self) -> None:
        shape = (self.stamps_ns.size, len(self.sensors), 3)
        named = [("gyr", self.gyr), ("acc", self.acc)] + ([("mag", self.mag)] if self.mag is not None else [])
        for name, array in named:
            if array.shape != shape:
                raise InputError(f"{self.path}: {name}", f"has shape {array.shape}", f"{shape}")
            array.flags.writeable = False
        require_pairs(self.pairs, self.sensors, f"{self.path}: pairs")
        self.stamps_ns.flags.writeable = False
        if self.reference is not None:
            self.reference.orientation.flags.writeable = False

    @property
    def samples(self) -> int:
        """Number of samples of each sensor."""
        return int(self.stamps_ns.size)

    @property
    def duration_ns(self) -> int:
        """Instant of the last sample, ns."""
        return int(self.stamps_ns[-1])

    def pair_name(self, pair: tuple[int, int]) -> str:
        """"parent-child", as metrics call it."""
        return f"{self.sensors[pair[0]]}-{self.sensors[pair[1]]}"
