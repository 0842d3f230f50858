"""Layouts: TOML files that state which columns of a table or .mat file hold which samples.

    rate = 100                      # Hz, exact: "2000/7"; or time = "t" with units.time
    every = {acc = 2, mag = 10}     # rows from one sample to the next, of kinds that are not in every row
    pairs = [["forearm", "hand"]]   # parent and child of neighbouring segments
    resample = 100                  # Hz, of common instants, for sensors of different instants or uneven ones

    [units]                         # of the file; converted to SI
    gyr = "deg/s"
    acc = "g"

    [text]                          # text files only
    separator = ";"

    [sensors.hand]
    gyr = ["wx", "wy", "wz"]        # columns by name, or by number from 1
    acc = {variable = "imu.data", columns = [4, 5, 6]}    # of a matrix in a .mat or .npz file
    mag = "imu.field"               # a whole variable, (n, 3) or (3, n)
    # or of another file of as many rows: mag = {file = "mag.csv", columns = ["x", "y", "z"]}
    orientation = ["q0", "q1", "q2", "q3"]
    axes = ["-z", "-x", "y"]        # of the sensor, that point along the segment's x, y and z
    own_axes = {mag = ["y", "x", "-z"]}   # of one kind, that point along the sensor's x, y and z
    rotation_deg = [0, 0, 15]       # of the sensor against its segment, a rotation vector
    time = "t_hand"                 # of this sensor alone, by the clock of the others

    [reference]                     # what the orientations are, if there are any
    order = "xyzw"
    direction = "reference_to_segment"
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import TypeAdapter, ValidationError
from scipy.spatial.transform import Rotation

from fesloop.errors import InputError, InputErrors
from fesloop.forms.toml import TomlError, tables_of
from fesloop.loop.signals import require_pairs
from fesloop.streams.text_table import TextForm, read_text

_ALLOWED = "a layout file (TOML)"
_MOST_ROWS = 1000
_AXES = ("x", "y", "z")
_HALF_TURN_DEG = 180.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Columns:
    """Some columns of a matrix in a file that holds several, or of another file.

    Attributes
    ----------
    file: name of the other file, in the folder of the recording, of as many rows; empty: the recording.
    variable: name of the matrix, empty in a text table; a dot leads into a structure; of an XDF file, the
        name of a stream. An array (n, a, b) has the columns of its first row of b, then those of the next.
    columns: numbers from 1; of a stream or a table also names.

    Raises InputError without both.
    """

    columns: tuple[int | str, ...]
    variable: str = ""
    file: str = ""

    def __post_init__(self) -> None:
        if not (self.variable or self.file):
            raise InputError("variable", "is missing", "variable, file, or both", "or give the columns alone")


Place = str | int | tuple[str | int, ...] | Columns
"""A variable or column by name, a column by number from 1, several columns, or columns of a variable."""


@dataclass(frozen=True, slots=True, kw_only=True)
class EveryLayout:
    """Rows from one sample of a kind to the next; each value holds until then."""

    gyr: int = 1
    acc: int = 1
    mag: int = 1

    def __post_init__(self) -> None:
        for kind in ("gyr", "acc", "mag"):
            rows = getattr(self, kind)
            if not 1 <= rows <= _MOST_ROWS:
                raise InputError(kind, f"{rows}", f"1 to {_MOST_ROWS} rows")


def _signed(axes: Sequence[str], where: str) -> NDArray[np.float64]:
    """Matrix (3, 3) to the frame whose x, y and z these axes are; InputError unless each is named once."""
    if sorted(axis.removeprefix("-") for axis in axes) != sorted(_AXES):
        raise InputError(where, f"{list(axes)}", 'each of x, y and z once, such as ["-z", "-x", "y"]')
    return np.array([(-1.0 if axis.startswith("-") else 1.0) * np.eye(3)["xyz".index(axis[-1])]
                     for axis in axes])


@dataclass(frozen=True, slots=True, kw_only=True)
class OwnAxes:
    """Axes of single kinds of samples that point along the sensor's x, y and z.

    They may be left-handed: chips of magnetometers often are against those of accelerometers, and an
    accelerometer that gives -g upwards at rest has ["-x", "-y", "-z"].
    """

    gyr: tuple[str, str, str] = _AXES
    acc: tuple[str, str, str] = _AXES
    mag: tuple[str, str, str] = _AXES

    def __post_init__(self) -> None:
        for kind in ("gyr", "acc", "mag"):
            _signed(getattr(self, kind), f"own_axes.{kind}")


@dataclass(frozen=True, slots=True, kw_only=True)
class SensorLayout:
    """Columns of one sensor's samples.

    Attributes
    ----------
    gyr, acc, mag: three columns each; `mag` may be left out.
    orientation: four columns, a quaternion measured by other means; may be left out.
    axes: axes of the sensor that point along x, y and z of its segment. Samples are then converted to the
        segment's frame; so are reference orientations where the reference has `sensor_frames`.
    own_axes: axes of its gyroscopes, accelerometers or magnetometers, where they are not the sensor's.
    rotation_deg: rotation vector, deg, of the frame of `axes` against that of the segment, about the
        segment's x, y and z: samples in the segment's frame are those of the sensor turned by it.
    time: instants of this sensor's samples, where its rows are not those of the others; of their clock.
        Rows without an instant are no samples of it.
    every: as in `Layout`, where this sensor's is another one.
    """

    gyr: Place
    acc: Place
    mag: Place | None = None
    orientation: Place | None = None
    axes: tuple[str, str, str] = _AXES
    own_axes: OwnAxes = field(default_factory=OwnAxes)
    rotation_deg: tuple[float, float, float] = (0.0, 0.0, 0.0)
    time: Place | None = None
    every: EveryLayout | None = None

    def __post_init__(self) -> None:
        if np.linalg.det(_signed(self.axes, "axes")) < 0.0:
            raise InputError("axes", f"{list(self.axes)} is left-handed", "a right-handed frame",
                             "change one sign; for one kind of samples, state own_axes")
        if not np.linalg.norm(self.rotation_deg) <= _HALF_TURN_DEG:
            raise InputError("rotation_deg", f"{list(self.rotation_deg)}",
                             "x, y, z of at most 180 deg in all")

    def turned(self, samples: NDArray[np.float64], kind: str = "") -> NDArray[np.float64]:
        """Samples (n, 3) along the axes of the segment, from those along the sensor's, or its `kind`'s."""
        for axes in ((getattr(self.own_axes, kind), self.axes) if kind else (self.axes,)):
            signs = [-1.0 if axis.startswith("-") else 1.0 for axis in axes]
            samples = samples[:, ["xyz".index(axis[-1]) for axis in axes]] * signs
        if any(self.rotation_deg):
            samples = samples @ Rotation.from_rotvec(self.rotation_deg, degrees=True).as_matrix().T
        return np.asarray(samples)


@dataclass(frozen=True, slots=True, kw_only=True)
class UnitsLayout:
    """Units of the file, as `fesloop.streams.labels` knows them."""

    gyr: str = "rad/s"
    acc: str = "m/s^2"
    mag: str = "T"
    time: str = "s"


@dataclass(frozen=True, slots=True, kw_only=True)
class ReferenceLayout:
    """Meaning of the orientations in the file.

    Attributes
    ----------
    order: order of a quaternion's components.
    direction: whether a quaternion turns coordinates of the segment into those of the reference, or back.
    sensor_frames: whether a segment's frame is its sensor's.
    north: whether the reference frame is ENU.
    rate, time: rate or instants of the orientations; those of the samples where neither is given. Instants of
        samples and orientations are of one clock; where either has only a rate, both begin together.
    scored: column of 1 at instants to be scored and 0 elsewhere; every instant is scored where it is left
        out.
    """

    order: Literal["wxyz", "xyzw"] = "wxyz"
    direction: Literal["segment_to_reference", "reference_to_segment"] = "segment_to_reference"
    sensor_frames: bool = True
    north: bool = False
    rate: str | int | float | None = None
    time: Place | None = None
    scored: Place | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Layout:
    """Columns, units and times of a file.

    Attributes
    ----------
    sensors: layouts by the sensor's name, in the order of the recording.
    rate: sampling rate, Hz; or `time`: column of the instants, in `units.time`, from any origin.
    every: number of rows per sample, for kinds of samples that are not in every row; of all sensors that
        state none of their own. A sample that is missing then counts as held, not as lost.
    units, text, reference: their own tables.
    pairs: names of (parent, child) sensors on neighbouring segments, each pair once, in no loop.
    resample: rate of common instants, Hz, for streams of an XDF file and for sensors with instants of their
        own; of a table with one `time`, to even out its instants.
    """

    sensors: dict[str, SensorLayout]
    rate: str | int | float | None = None
    time: Place | None = None
    every: EveryLayout = field(default_factory=EveryLayout)
    units: UnitsLayout = field(default_factory=UnitsLayout)
    text: TextForm = field(default_factory=TextForm)
    reference: ReferenceLayout = field(default_factory=ReferenceLayout)
    pairs: tuple[tuple[str, str], ...] = ()
    resample: str | int | float | None = None

    def __post_init__(self) -> None:
        if not self.sensors:
            raise InputError("sensors", "no sensor", "one or more, [sensors.NAME]")
        timed = [each.time is not None for each in self.sensors.values()]
        if all(timed) and self.rate is None and self.time is None:
            pass  # each sensor has instants of its own
        elif (self.rate is None) == (self.time is None):
            raise InputError("rate", "neither rate nor time is given" if self.rate is None
                             else "both rate and time are given", "one of the two")
        if self.reference.rate is not None and self.reference.time is not None:
            raise InputError("reference.rate", "both rate and time are given", "one of the two, or none")
        if any(timed) and self.rate is not None:
            raise InputError(f"sensors.{list(self.sensors)[timed.index(True)]}.time", "is given beside rate",
                             "one of the two")
        if self.resample is not None or any(timed):
            stated = [f"sensors.{name}.orientation" for name, each in self.sensors.items()
                      if each.orientation]
            stated += ["every"] * (self.every != EveryLayout())
            stated += [f"sensors.{name}.every" for name, each in self.sensors.items() if each.every]
            if stated:
                raise InputError(stated[0], "is given beside "
                                 + ("resample" if self.resample is not None else "the time of a sensor"),
                                 "one of the two")
        for pair in self.pairs:
            for name in pair:
                if name not in self.sensors:
                    raise InputError("pairs", f"{name!r} is no sensor", ", ".join(self.sensors))
        names = list(self.sensors)
        require_pairs([(names.index(parent), names.index(child)) for parent, child in self.pairs], names,
                      "pairs")
        given = [each.orientation is not None for each in self.sensors.values()]
        if any(given) and not all(given):
            name = list(self.sensors)[given.index(False)]
            raise InputError(f"sensors.{name}.orientation", "is missing, others have it", "all or none")


def read_layout(path: Path) -> Layout:
    """The layout in a file.

    Raises InputError, InputErrors: every fault of the file, one line each, with file and key.
    """
    layout: Layout = read_described_by(path, Layout, _ALLOWED)
    return layout


def read_described_by(path: Path, kind: type[Any], allowed: str) -> Any:
    """Object of a dataclass from a TOML file whose keys are its fields; `allowed` names such a file.

    Raises InputError, InputErrors: every fault of the file, one line each, with file and key.
    """
    from fesloop.forms.faults import faults_of
    from fesloop.forms.schema import keys_at, make, table

    name = str(path)
    try:
        document = tables_of(read_text(path, allowed))
    except TomlError as fault:
        raise InputError(name, f"is not TOML: {fault}", remedy="mend the line") from None
    form = table(kind, {})
    try:
        TypeAdapter(form).validate_json(json.dumps(document))
    except ValidationError as fault:
        raise InputErrors([_in_file(each, name) for each in faults_of(
            fault.errors(include_url=False), document, lambda path: keys_at(form, path, document),
            tagged=False)]) from None
    try:
        return make(kind, document, {}, "")
    except InputError as fault:
        raise _in_file(fault, name) from None


def _in_file(fault: Any, name: str) -> InputError:
    where = fault.where.removeprefix(".").removeprefix(": ")
    return InputError(f"{name}: {where}" if where else name, fault.found, fault.allowed, fault.remedy)
