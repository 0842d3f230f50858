"""Tables of one's own recordings of stimulated muscle, and the TOML file that describes them.

    person = "P1"
    side = "right"
    frequency_hz = 40
    muscles = ["biceps", "flexor carpi radialis"]
    torque = "device"               # of the device on the arm; or "muscle": of the muscle, as a sensor shows it
    baseline = "visit_median"       # or "passive", "none"; see SteadyTrials
    steady = "trials.csv"           # tables beside this file; one or more of the four
    courses = "ramps.csv"
    movements = "reaching.csv"
    forces = "force.csv"

    [device]
    zero_deg = {elbow_flexion = 90}             # anatomical angle at which the table's angle is 0
    friction_nm = {elbow_flexion = 0.3}
    stiffness_nm_rad = {elbow_flexion = 100}

    [electrodes]
    biceps = "5 x 5 cm over the belly, and over its tendon"

    [widths.biceps]
    lowest_us = 20
    highest_us = 34
    current_ma = 60

Columns are `QUANTITY_UNIT`, and `JOINT_DIRECTION_UNIT` for a joint's angle or torque: `elbow_flexion_deg`,
`wrist_extension_nm`. The opposite direction is the same joint with the opposite sign.

| table | columns of text | columns of numbers |
|---|---|---|
| steady, a row a trial | muscle ("passive": none), posture* | visit, order*, repeat*, time*, current, pulse_width; of each joint: angle, reference* (`elbow_flexion_reference_deg`), torque, sd*, creep* (`elbow_flexion_sd_nm`), stiffness* |
| courses, a row a sample | recording, muscle | time, current, pulse_width; of each joint: angle, torque, reference*, stiffness* |
| movements, a row a sample | recording | time; of each joint: angle, reference*, torque*, planned*; of each muscle: `MUSCLE_current_ma`, `MUSCLE_pulse_width_us` |
| forces, a row a sample | recording, muscle*, kind* | time, force, length*, pulse (1 in the row in which a pulse begins) |

Those with * may be left out; `steady` needs `posture` or `reference`. A posture without a code gets the ranks of its
reference angles, such as "0110".
"""  # noqa: E501 - rows of a table

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np

from fesloop.errors import InputError, did_you_mean
from fesloop.streams.formats.layout import read_described_by
from fesloop.streams.stimulation.recording import (
    LARGEST_CURRENT_A,
    LONGEST_PULSE_S,
    OPPOSITES,
    PASSIVE,
    Array,
    Baseline,
    ForceCourse,
    Movement,
    SteadyTrials,
    StimulationRecording,
    Texts,
    TorqueCourse,
    Whole,
    direction_of,
    largest_torque_nm,
    utf8_name,
)
from fesloop.streams.text_table import TextForm, read_columns

ALLOWED = "a TOML file that describes tables of stimulated muscle"
UNITS: Mapping[str, Mapping[str, float]] = {
    "current": {"a": 1.0, "ma": 1e-3, "ua": 1e-6},
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0},
    "angle": {"rad": 1.0, "deg": np.pi / 180.0},
    "torque": {"nm": 1.0, "mnm": 1e-3, "ncm": 1e-2},
    "stiffness": {"nm_rad": 1.0, "nm_deg": 180.0 / np.pi},
    "force": {"n": 1.0, "mn": 1e-3},
    "length": {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6}}
"""Factors to SI by dimension and unit, as columns name it; letters' case does not matter."""
_TEXTS = ("recording", "muscle", "posture", "kind")
_COUNTS = ("visit", "order", "repeat", "pulse")
_OF_TABLE = {"current": "current", "pulse_width": "time", "time": "time", "force": "force",
             "length": "length"}
_OF_JOINT = {"": ("angle", "torque"), "reference": ("angle",), "sd": ("torque",), "creep": ("torque",),
             "planned": ("torque",), "stiffness": ("stiffness",)}
_PASSIVE = ("", "passive", "none")
_UNEVEN = 0.02
"""Greatest departure of a sample from even spacing, in periods (chosen: decimals of a table)."""
_POSTURE_RAD = np.radians(0.1)
"""Reference angles nearer than this are one posture (chosen: finer than any device holds)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DeviceLayout:
    """The device that holds the arm: numbers by joint.

    Attributes
    ----------
    zero_deg: anatomical angle at which the tables' angle is 0.
    friction_nm: dry friction. stiffness_nm_rad: of its position controller.
    """

    zero_deg: dict[str, float] = field(default_factory=dict)
    friction_nm: dict[str, float] = field(default_factory=dict)
    stiffness_nm_rad: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, kw_only=True)
class WidthsLayout:
    """Usable pulse widths of a muscle at a current."""

    lowest_us: float
    highest_us: float
    current_ma: float

    def __post_init__(self) -> None:
        if not 0.0 <= self.lowest_us < self.highest_us:
            raise InputError("highest_us", f"{self.highest_us:g} is not above lowest_us, {self.lowest_us:g}",
                             "more than lowest_us")


@dataclass(frozen=True, slots=True, kw_only=True)
class StimulationLayout:
    """Description of one person's tables; see the module. Names of joints may be of either direction."""

    person: str
    frequency_hz: float
    muscles: tuple[str, ...]
    torque: Literal["device", "muscle"] | None = None
    side: Literal["left", "right", ""] = ""
    baseline: Baseline = "visit_median"
    steady: str = ""
    courses: str = ""
    movements: str = ""
    forces: str = ""
    notes: str = ""
    ignore: tuple[str, ...] = ()
    text: TextForm = field(default_factory=TextForm)
    device: DeviceLayout = field(default_factory=DeviceLayout)
    electrodes: dict[str, str] = field(default_factory=dict)
    widths: dict[str, WidthsLayout] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not (self.steady or self.courses or self.movements or self.forces):
            raise InputError("steady", "no table is named", "steady, courses, movements or forces")
        if self.torque is None and (self.steady or self.courses or self.movements):
            raise InputError("torque", "is missing", '"device": torque of the device on the arm; "muscle": '
                             "torque of the muscle", "state which of them the tables hold")
        for key, names in (("electrodes", self.electrodes), ("widths", self.widths)):
            for name in names:
                if name not in self.muscles:
                    raise InputError(f"{key}.{name}", "is no muscle of `muscles`", ", ".join(self.muscles),
                                     did_you_mean(name, self.muscles))


def read_tables(path: Path) -> StimulationRecording:
    """The recording that a TOML file describes.

    Raises InputError, InputErrors: faults with file, line and column.
    """
    layout: StimulationLayout = read_described_by(path, StimulationLayout, ALLOWED)
    tables = {kind: _Table.read(path.parent / name, kind, layout) for kind in _PARTS
              if (name := getattr(layout, kind))}
    joints = next((table.joints for table in tables.values() if table.joints), ())
    for table in tables.values():
        table.require_joints(joints if table.kind != "forces" else ())
    numbers = {key: _by_joint(getattr(layout.device, key), joints, f"{path}: device.{key}", signed)
               for key, signed in (("zero_deg", True), ("friction_nm", False), ("stiffness_nm_rad", False))}
    parts: dict[str, Any] = {kind: _PARTS[kind](table, layout, joints, numbers["stiffness_nm_rad"])
                             for kind, table in tables.items()}
    widths = np.array([[np.nan] * 3 if name not in layout.widths else [
        layout.widths[name].lowest_us * 1e-6, layout.widths[name].highest_us * 1e-6,
        layout.widths[name].current_ma * 1e-3] for name in layout.muscles]).reshape(-1, 3)
    try:
        return StimulationRecording(
            person=layout.person, muscles=layout.muscles, joints=joints,
            zero_rad=np.radians(numbers["zero_deg"]), friction_nm=numbers["friction_nm"],
            frequency_hz=layout.frequency_hz, lowest_width_s=widths[:, 0].copy(),
            highest_width_s=widths[:, 1].copy(), width_current_a=widths[:, 2].copy(), source=utf8_name(path),
            source_format="table", side=layout.side, electrodes=layout.electrodes, notes=layout.notes,
            **parts)
    except InputError as fault:
        raise _in_table(fault, path, tables) from None


def _in_table(fault: InputError, path: Path, tables: Mapping[str, _Table]) -> InputError:
    """A fault of the recording, led by its file: a trial's by the table and line that it is from."""
    row = re.match(r"steady: row (\d+)", fault.where)
    if row is None:
        return fault.within(str(path))
    table, rest = tables["steady"], fault.where[row.end():]
    return InputError(f"{table.where}: line {table.lines[int(row[1]) - 1]}{rest}", fault.found, fault.allowed,
                      fault.remedy)


class _Column(NamedTuple):
    """A column: its name in the file, its values in SI units and of the joint's own direction."""

    name: str
    values: Any


@dataclass(frozen=True, slots=True)
class _Table:
    """A table of one kind: columns by what they hold, such as "current", or (joint, "angle")."""

    kind: str
    where: str
    lines: Whole
    columns: dict[Any, _Column]
    joints: tuple[str, ...]

    @classmethod
    def read(cls, path: Path, kind: str, layout: StimulationLayout) -> _Table:
        """Read a table; InputError for columns that are not understood, or hold one quantity twice."""
        found = read_columns(path, layout.text, {*_TEXTS, *layout.ignore})
        columns: dict[Any, _Column] = {}
        for name, values in found["columns"].items():
            if name in layout.ignore:
                continue
            key, factor = _meaning(name, kind, layout, f"{path}: column {name!r}")
            if key in columns:
                raise InputError(f"{path}: column {name!r}", f"says the same as column {columns[key].name!r}",
                                 "one of the two", f"remove it, or add it to `ignore` ({ALLOWED})")
            columns[key] = _Column(name, values if isinstance(values, list) else np.asarray(values) * factor)
        joints = tuple(dict.fromkeys(key[0] for key in columns
                                     if isinstance(key, tuple) and key[0] not in layout.muscles))
        table = cls(kind, str(path), found["line"], columns, joints)
        table._require_possible()
        return table

    def fault(self, key: Any, row: int, found: str, allowed: str, remedy: str = "") -> InputError:
        """An error at a column and row."""
        return InputError(f"{self.where}: line {self.lines[row]}: column {self.columns[key].name!r}", found,
                          allowed, remedy)

    def require_joints(self, joints: Sequence[str]) -> None:
        """Raise InputError for a joint that another table has, or has not."""
        for joint in {*joints} ^ {*self.joints}:
            raise InputError(self.where, f"has {'a' if joint in self.joints else 'no'} column of {joint}, "
                             f"another table has {'none' if joint in self.joints else 'one'}",
                             "the same joints in all tables")

    def _require_possible(self) -> None:
        """Raise InputError for a number beyond what joint or stimulator can do, with its line."""
        for key, column in self.columns.items():
            what = key[1] if isinstance(key, tuple) else key
            limits = {"angle": (np.pi, "deg", 180.0 / np.pi), "reference": (np.pi, "deg", 180.0 / np.pi),
                      "current": (LARGEST_CURRENT_A, "mA", 1e3), "pulse_width": (LONGEST_PULSE_S, "us", 1e6)}
            if isinstance(key, tuple) and what in ("torque", "sd", "creep", "planned"):
                limits[what] = (largest_torque_nm(key[0]), "N m", 1.0)
            if what not in limits:
                continue
            limit, unit, factor = limits[what]
            least = 0.0 if what in ("current", "pulse_width") else -limit
            beyond = (column.values > limit) | (column.values < least)
            if beyond.any():
                row = int(np.argmax(beyond))
                raise self.fault(key, row, f"{column.values[row] * factor:.4g} {unit} is beyond what "
                                 + ("a stimulator gives" if least == 0.0 else "this joint can do"),
                                 f"{least * factor:.4g} to {limit * factor:.4g} {unit}",
                                 "check the unit in the column's name")

    def get(self, key: Any, name: str) -> Any:
        """Values of a column that must be there; `name` as it would be called."""
        if key not in self.columns:
            names = [column.name for column in self.columns.values()]
            raise InputError(self.where, f"has no column {name!r}", f"the columns of a table of {self.kind}",
                             did_you_mean(name, names) or f"it has {', '.join(names[:12])}")
        values = self.columns[key].values
        if not isinstance(values, list) and not np.isfinite(values).all():
            row = int(np.argmin(np.isfinite(values)))
            raise self.fault(key, row, "is missing" if np.isnan(values[row]) else "is not finite",
                             "a number in every row")
        return values

    def whole(self, key: str) -> Whole:
        """Whole numbers of a column that must be there."""
        values = self.get(key, key)
        uneven = values != np.round(values)
        if uneven.any() or (np.abs(values) > 2**53).any():
            row = int(np.argmax(uneven | (np.abs(values) > 2**53)))
            raise self.fault(key, row, f"{values[row]:g} is no whole number", "0, 1, 2, ...")
        return np.asarray(values, np.int64)

    def of_joints(self, what: str, joints: Sequence[str], rows: Any = slice(None), *,
                  needed: bool = False, lacks: bool = True) -> Array:
        """(rows, joints) of a quantity, NaN where its column is left out, unless it is needed.

        `lacks`: whether single numbers may be missing.
        """
        out = np.full((len(self.lines), len(joints)), np.nan)
        for j, joint in enumerate(joints):
            if (needed and (joint, what) not in self.columns) or not lacks:
                self.get((joint, what), f"{joint}_{'deg' if what == 'angle' else 'nm'}")
            if (joint, what) in self.columns:
                out[:, j] = self.columns[joint, what].values
        return np.asarray(out[rows])

    def muscles(self, layout: StimulationLayout, *, passive: bool) -> Whole:
        """Numbers of the muscles of all rows."""
        names = self.get("muscle", "muscle") if "muscle" in self.columns or len(layout.muscles) > 1 \
            else [layout.muscles[0]] * len(self.lines)
        number = {name: i for i, name in enumerate(layout.muscles)}
        if passive:
            number = {**dict.fromkeys(_PASSIVE, PASSIVE), **number}
        for row, name in enumerate(names):
            if name not in number:
                raise self.fault("muscle", row, f"{name!r} is no muscle of `muscles`",
                                 ", ".join(repr(each) for each in number if each),
                                 did_you_mean(name, number))
        return np.array([number[name] for name in names], np.int64)

    def recordings(self) -> Iterable[tuple[str, Whole]]:
        """Name and rows of each recording in the table, in order."""
        rows: dict[str, list[int]] = {}
        for row, name in enumerate(self.get("recording", "recording")):
            rows.setdefault(name, []).append(row)
        return [(name, np.array(each)) for name, each in rows.items()]

    def period(self, rows: Whole) -> float:
        """Time between the samples of a recording; InputError where they are not evenly spaced."""
        time = self.get("time", "time_s")[rows]
        if len(time) < 2:
            raise self.fault("time", int(rows[0]), "is a recording of one sample", "two or more")
        period = float(time[-1] - time[0]) / (len(time) - 1)
        wrong = np.abs(np.diff(time) - period) > _UNEVEN * abs(period)
        if period <= 0.0 or wrong.any():
            row = int(rows[int(np.argmax(wrong)) + 1])
            raise self.fault("time", row, "is not evenly spaced in its recording",
                             f"every {period:.6g} s" if period > 0.0 else "increasing times",
                             "resample it, or split the recording")
        return float(f"{period:.9g}")

    def constant(self, key: Any, name: str, rows: Whole) -> float:
        """The one value of a column in a recording."""
        values = self.get(key, name)[rows]
        changes = values != values[0]
        if changes.any():
            raise self.fault(key, int(rows[int(np.argmax(changes))]), "changes within its recording",
                             f"{self.columns[key].values[rows[0]]:g} in all its rows", "split the recording")
        return float(values[0])


def _meaning(name: str, kind: str, layout: StimulationLayout, where: str) -> tuple[Any, float]:
    """Meaning of a column and factor of its numbers; InputError for a name that is not understood."""
    if name in _TEXTS or name in _COUNTS:
        return name, 1.0
    folded = name.replace("µ", "u").replace("μ", "u")
    for dimension, unit, factor in _ENDINGS:
        if not folded.lower().endswith(f"_{unit}"):
            continue
        what = folded[:-len(unit) - 1]
        if _OF_TABLE.get(what) == dimension:
            return what, factor
        ending = next((each for each in _OF_JOINT if each and what.endswith(f"_{each}")), "")
        if dimension in _OF_JOINT[ending]:
            joint, sign = _own_direction(what.removesuffix(f"_{ending}") if ending else what, where)
            return (joint, ending or dimension), factor * (sign if ending not in ("sd", "stiffness") else 1.0)
        for muscle in layout.muscles if kind == "movements" else ():
            for quantity in ("current", "pulse_width"):
                if what == f"{muscle}_{quantity}" and _OF_TABLE[quantity] == dimension:
                    return (muscle, quantity), factor
        if what in _OF_TABLE:
            expected = ", ".join(f"{what}_{each}" for each in UNITS[_OF_TABLE[what]])
            raise InputError(where, f"{unit!r} is no unit of {what.replace('_', ' ')}", expected)
    raise InputError(where, "is not understood", "QUANTITY_UNIT or JOINT_DIRECTION_UNIT, such as current_ma, "
                     "pulse_width_us, elbow_flexion_deg, wrist_flexion_nm",
                     did_you_mean(name, _COMMON) or "rename it, or add it to `ignore`")


_ENDINGS = sorted(((dimension, unit, factor) for dimension, units in UNITS.items()
                   for unit, factor in units.items()), key=lambda each: -len(each[1]))
_COMMON = [*_TEXTS, *_COUNTS, "current_ma", "pulse_width_us", "time_s", "force_n", "length_mm"]


def _own_direction(joint: str, where: str) -> tuple[str, float]:
    """Name of a joint in its own direction, and the sign of numbers in the given one."""
    direction = direction_of(joint, where)
    for own, opposite in OPPOSITES.items():
        if direction == opposite:
            return f"{joint.removesuffix(direction)}{own}", -1.0
    return joint, 1.0


def _by_joint(given: Mapping[str, float], joints: Sequence[str], where: str, signed: bool) -> Array:
    """(joints,) of numbers by joint; NaN where none is given."""
    out = np.full(len(joints), np.nan)
    for name, value in given.items():
        joint, sign = _own_direction(name, where)
        if joint not in joints:
            raise InputError(f"{where}.{name}", "is no joint of the tables", ", ".join(joints) or "none")
        if not signed and value < 0.0:
            raise InputError(f"{where}.{name}", f"{value:g}", "0 or more")
        out[joints.index(joint)] = value * (sign if signed else 1.0)
    return out


def _of_device(torque: Array, layout: StimulationLayout) -> Array:
    """Torque that the device exerts, of that which the table holds."""
    return torque if layout.torque == "device" else np.asarray(-torque)


def _steady(table: _Table, layout: StimulationLayout, joints: Sequence[str],
            stiffness: Array) -> SteadyTrials:
    muscle, visit = table.muscles(layout, passive=True), table.whole("visit")
    angle, torque = (table.of_joints(what, joints, lacks=False) for what in ("angle", "torque"))
    reference = table.of_joints("reference", joints)
    if "posture" not in table.columns and np.isnan(reference).any():
        raise InputError(table.where, "does not name postures", "a column `posture`, or the reference angle "
                         "of every joint, such as elbow_flexion_reference_deg", "add one of the two")
    reference = np.where(np.isnan(reference), angle, reference)
    posture = np.array(table.columns["posture"].values, str) if "posture" in table.columns \
        else _codes(reference)
    own = table.of_joints("stiffness", joints)
    order = table.whole("order") if "order" in table.columns else _order(visit)
    repeat = table.whole("repeat") if "repeat" in table.columns else _repeat(posture, visit)
    return SteadyTrials(
        muscle=muscle, posture=posture, visit=visit, order=order, repeat=repeat,
        time_s=np.asarray(table.columns["time"].values) if "time" in table.columns
        else np.full(len(muscle), np.nan),
        reference_rad=reference, angle_rad=angle, pulse_width_s=table.get("pulse_width", "pulse_width_us"),
        current_a=table.get("current", "current_ma"), device_torque_nm=_of_device(torque, layout),
        device_torque_sd_nm=table.of_joints("sd", joints),
        creep_nm=_of_device(table.of_joints("creep", joints), layout),
        stiffness_nm_rad=np.where(np.isnan(own), stiffness, own), baseline=layout.baseline)


def _codes(reference: Array) -> Texts:
    """Code of each row's posture: ranks of its reference angles, a digit or more a joint."""
    ranks = []
    for column in reference.T:
        levels, place = np.unique(np.round(column / _POSTURE_RAD), return_inverse=True)
        digits = len(str(len(levels) - 1))
        ranks.append([f"{rank:0{digits}d}" for rank in place])
    return np.array(["".join(each) for each in zip(*ranks, strict=True)])


def _order(visit: Whole) -> Whole:
    """Place of each row in its visit."""
    return np.array([np.count_nonzero(visit[:row] == number) for row, number in enumerate(visit)], np.int64)


def _repeat(posture: Texts, visit: Whole) -> Whole:
    """Number of earlier visits of each row's posture."""
    first = {number: row for row, number in reversed(list(enumerate(visit.tolist())))}
    out = np.zeros(len(visit), np.int64)
    for code in np.unique(posture):
        visits = sorted({*visit[posture == code].tolist()}, key=first.__getitem__)
        out[posture == code] = [visits.index(number) for number in visit[posture == code].tolist()]
    return out


def _courses(table: _Table, layout: StimulationLayout, joints: Sequence[str],
             stiffness: Array) -> tuple[TorqueCourse, ...]:
    muscle, found = table.muscles(layout, passive=False), []
    for name, rows in table.recordings():
        if len(set(muscle[rows])) > 1:
            raise table.fault("muscle", int(rows[np.argmax(muscle[rows] != muscle[rows[0]])]),
                              "changes within its recording", "one muscle a recording", "split the recording")
        own = table.of_joints("stiffness", joints, rows)[0]
        found.append(TorqueCourse(
            name=name, muscle=int(muscle[rows[0]]), current_a=table.constant("current", "current_ma", rows),
            period_s=table.period(rows), pulse_width_s=table.get("pulse_width", "pulse_width_us")[rows],
            reference_rad=table.of_joints("reference", joints, rows)[0],
            stiffness_nm_rad=np.where(np.isnan(own), stiffness, own),
            angle_rad=table.of_joints("angle", joints, rows, needed=True),
            device_torque_nm=_of_device(table.of_joints("torque", joints, rows, needed=True), layout)))
    return tuple(found)


def _movements(table: _Table, layout: StimulationLayout, joints: Sequence[str],
               stiffness: Array) -> tuple[Movement, ...]:
    return tuple(Movement(
        name=name, period_s=table.period(rows), reference_rad=table.of_joints("reference", joints, rows),
        angle_rad=table.of_joints("angle", joints, rows, needed=True),
        device_torque_nm=_of_device(table.of_joints("torque", joints, rows), layout),
        planned_nm=table.of_joints("planned", joints, rows),
        pulse_width_s=np.stack([table.get((muscle, "pulse_width"), f"{muscle}_pulse_width_us")[rows]
                                for muscle in layout.muscles], axis=1),
        current_a=np.array([table.constant((muscle, "current"), f"{muscle}_current_ma", rows)
                            for muscle in layout.muscles])) for name, rows in table.recordings())


def _forces(table: _Table, layout: StimulationLayout, joints: Sequence[str],
            stiffness: Array) -> tuple[ForceCourse, ...]:
    muscle, pulse, found = table.muscles(layout, passive=False), table.whole("pulse"), []
    kinds = table.columns["kind"].values if "kind" in table.columns else [""] * len(table.lines)
    table.get("force", "force_n")
    for name, rows in table.recordings():
        time = table.get("time", "time_s")[rows]
        found.append(ForceCourse(
            name=name, kind=kinds[rows[0]], muscle=int(muscle[rows[0]]), start_s=float(time[0]),
            period_s=table.period(rows), force_n=table.columns["force"].values[rows],
            length_m=table.columns["length"].values[rows] if "length" in table.columns
            else np.full(len(rows), np.nan), pulses_s=time[pulse[rows] == 1] - time[0]))
    return tuple(found)


_PARTS: Mapping[str, Callable[[_Table, StimulationLayout, Sequence[str], Array], Any]] = {
    "steady": _steady, "courses": _courses, "movements": _movements, "forces": _forces}
