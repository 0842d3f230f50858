"""Results of a calibration of sensors, joints, clocks and frames, and their file.

`fesloop calibrate` writes the file. It is TOML; units are SI unless a name says otherwise.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from types import MappingProxyType
from typing import Any, ClassVar

from fesloop.errors import InputError
from fesloop.forms.schema import plain
from fesloop.forms.toml import tables_of_file, write_tables

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
FORMAT = "fesloop calibration 1"
_MADE_BY = "a file that fesloop calibrate wrote"
_UNIT = 1e-3
"""Largest error of a quaternion's length in a file."""


def _require_finite(where: str, numbers: Sequence[float]) -> None:
    if not all(math.isfinite(number) for number in numbers):
        raise InputError(where, f"{list(numbers)}", "finite numbers")


@dataclass(frozen=True, slots=True, kw_only=True)
class SensorRotation:
    """Orientation of one sensor on its segment.

    Attributes
    ----------
    name: name of the sensor.
    rotation: from the sensor's frame to its segment's (w, x, y, z).
    off_deg: angle between the directions that the rotation was found from and those that it gives, deg.
    method: "flat" (vertical and joint axis) or "reference" (rates of a reference).
    """

    name: str
    rotation: Quaternion
    off_deg: float = 0.0
    method: str = ""

    def __post_init__(self) -> None:
        _require_finite(f"{self.name}.rotation", self.rotation)
        length = math.hypot(*self.rotation)
        if not abs(length - 1.0) <= _UNIT:
            raise InputError(f"{self.name}.rotation", f"has length {length:g}",
                             "a quaternion (w, x, y, z) of length 1")
        object.__setattr__(self, "rotation", tuple(part / length for part in self.rotation))


@dataclass(frozen=True, slots=True, kw_only=True)
class HingeCalibration:
    """Axis of a hinge in the frames of the sensors on its two segments.

    Attributes
    ----------
    parent, child: names of the sensors.
    parent_axis, child_axis: unit vectors of one direction, in each sensor's frame.
    parent_sd_deg, child_sd_deg: sd of each axis, deg.
    residual_deg_s: rms difference of the rates across the axis, deg/s; 0 for an ideal hinge.
    """

    parent: str
    child: str
    parent_axis: Vector
    child_axis: Vector
    parent_sd_deg: float = 0.0
    child_sd_deg: float = 0.0
    residual_deg_s: float = 0.0

    def __post_init__(self) -> None:
        for name in ("parent_axis", "child_axis"):
            _require_finite(f"{self.parent}-{self.child}.{name}", getattr(self, name))


@dataclass(frozen=True, slots=True, kw_only=True)
class ClockCalibration:
    """Offset between the clocks of the sensors and of another system.

    Attributes
    ----------
    other: the other system: "reference" for the recording's own, or a file of markers.
    offset_s: seconds to add to the other system's times to have them on the sensors' clock.
    peak: correlation of both signals at this offset, at most 1.
    second_peak: the next highest correlation; 0 without one.
    sensor: name of the sensor whose rates were compared.
    """

    other: str
    offset_s: float
    peak: float
    second_peak: float
    sensor: str

    @property
    def late_ms(self) -> float:
        """Delay of the other system's stamps, ms: what `fesloop fit-error --reference-late` takes."""
        return -1e3 * self.offset_s


@dataclass(frozen=True, slots=True, kw_only=True)
class CentreCalibration:
    """Centre about which a marker turns, in the frame of the marker system.

    Attributes
    ----------
    marker: name of the marker.
    centre_m: position of the centre, m.
    radius_m: mean distance of the marker from it, m.
    deviation_m: mean absolute deviation from that distance, m.
    sd_m: sd of the centre along the direction in which it is known worst, m.
    """

    marker: str
    centre_m: Vector
    radius_m: float
    deviation_m: float
    sd_m: float


@dataclass(frozen=True, slots=True, kw_only=True)
class FrameCalibration:
    """Transformation from the frame of the marker system to another frame, such as the wrist's.

    A point p becomes `rotation` applied to p - origin_m (doi 10.3390/s19010208, eq. 29).

    Attributes
    ----------
    rotation: from the marker system's coordinates to the other frame's (w, x, y, z).
    origin_m: origin of the other frame in the marker system's coordinates, m.
    rms_m: rms distance of the points after the transformation from where they should be, m; 0 where the
        rotation was given and not fitted.
    """

    rotation: Quaternion
    origin_m: Vector
    rms_m: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Calibration:
    """Result of `fesloop calibrate`.

    Attributes
    ----------
    source: the recording that it was made from.
    sensors: orientation of each sensor on its segment.
    hinges: axes of joints.
    clocks: offsets of other clocks.
    centres: centres of rotation.
    frames: transformations of the marker system's frame; one at most.
    """

    FILE_KEYS: ClassVar[Mapping[str, type]] = MappingProxyType({})
    OFFERED_BY: ClassVar[str] = ""

    @staticmethod
    def file_tables(path: Path) -> dict[str, Any]:
        """Read the parameters' tables from a file, unchecked. Raises InputError for another kind of file."""
        return tables_of_file(path, FORMAT, "a calibration", "fesloop calibrate")

    source: str = ""
    sensors: tuple[SensorRotation, ...] = ()
    hinges: tuple[HingeCalibration, ...] = ()
    clocks: tuple[ClockCalibration, ...] = ()
    centres: tuple[CentreCalibration, ...] = ()
    frames: tuple[FrameCalibration, ...] = ()

    def __post_init__(self) -> None:
        names = [each.name for each in self.sensors]
        if len(set(names)) < len(names):
            raise InputError("sensors", f"{', '.join(names)}", "each sensor once")

    @property
    def empty(self) -> bool:
        """Whether nothing was found."""
        return not any(getattr(self, each.name) for each in fields(self) if each.name != "source")

    def rotations(self, names: Sequence[str]) -> tuple[Quaternion, ...]:
        """Rotations of the named sensors, sensor to segment. Raises InputError if one is missing."""
        known = {each.name: each.rotation for each in self.sensors}
        missing = [name for name in names if name not in known]
        if missing:
            raise InputError("calibration", f"has no rotation of {', '.join(missing)}",
                             ", ".join(known) or "a file with a table `sensors`",
                             "calibrate with these sensors, or add their rotations to the file")
        return tuple(known[name] for name in names)

    def save(self, path: str | Path) -> None:
        """Write the file. Raises InputError where it cannot be written."""
        table = {key: value for key, value in _rounded(plain(self)).items() if value}
        write_tables(path, {"format": FORMAT, **table})


NO_CALIBRATION = Calibration()


def _rounded(value: Any) -> Any:
    """The same with eight significant digits, more than any recording shows."""
    if isinstance(value, dict):
        return {key: _rounded(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_rounded(item) for item in value]
    return float(f"{value:.8g}") if isinstance(value, float) else value
