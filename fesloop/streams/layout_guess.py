"""A layout to start from: sensors, kinds, units and instants, guessed from labels and from values.

Labels are read as those of streams (`fesloop.streams.labels`). Where they say nothing, an accelerometer is
known by gravity, the gyroscope beside it by its place, and units by what numbers are possible in them. Every
guess that no label states is a note.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import takewhile
from typing import Any, NamedTuple

import numpy as np

from fesloop.streams.agreement import agreements
from fesloop.streams.checks import Array
from fesloop.streams.labels import GRAVITY, factor, is_unit, read_label

_KINDS = ("gyr", "acc", "mag")
_GRAVITY_IN = {"m/s^2": GRAVITY, "g": 1.0, "mg": 1e3}
_GRAVITY_WITHIN = 0.15
"""Relative deviation of the median length of accelerations from gravity; half of them are within twice as
much, which rates, small at rest and large in motion, are not (chosen)."""
_EARTH_IN = {"uT": 1.0, "gauss": 1e-2, "mgauss": 10.0, "nT": 1e3, "mT": 1e-3, "T": 1e-6}
_EARTH_UT = (18.0, 90.0)
"""Fields that magnetometers measure, uT: the earth's is 23 to 67 (NOAA, World Magnetic Model 2025)."""
_FASTEST_RAD_S = 35.0
"""Rate above which numbers are no rad/s, the range of 2000 deg/s of usual gyroscopes."""
_DEGREES_WITHIN = 1.3
"""Ratio to 180 / pi within which a factor that explains gravity means degrees (chosen)."""
_TIME = re.compile(r"(?i)^(?:time(?:[_\s-]?stamp)?s?|t|ts|stamps?|sec(?:onds)?|elapsed)"
                   r"(?:[_\s-]?(?P<unit>s|ms|us|ns|sec|seconds))?$")
_UNIT = re.compile(r"^(?P<label>.*?)\s*[\[(](?P<unit>[^\])]*)[\])]\s*$")
_TIME_UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
_RATES_HZ = (10.0, 8000.0)
"""Rates of inertial sensors by which the unit of instants is known (chosen)."""
_USUAL = 0.95
"""Share of the distances between samples of a kind that are equal where it has a rate of its own (chosen)."""
_LEAST = 3


class Labelled(NamedTuple):
    """A column of numbers.

    Attributes
    ----------
    label, unit, type: as the file has them, empty where it has none.
    values: (n,).
    stream: what it belongs to: a stream of XDF, a variable of a container, "" of a text table.
    number: its number there, from 1.
    whole: whether the stream has exactly three columns, which a layout may name together.
    name: by which a layout takes it from a text table or a stream of XDF; empty where it has none.
    """

    label: str
    unit: str
    type: str
    values: Array
    stream: str
    number: int
    whole: bool = False
    name: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class Triple:
    """Three columns that are x, y and z of one kind of samples of a sensor; `unit` as the file states it."""

    sensor: str
    kind: str
    columns: tuple[Labelled, Labelled, Labelled]
    unit: str

    @property
    def samples(self) -> Array:
        """(n, 3), in the file's unit."""
        return np.column_stack([column.values for column in self.columns])


def unit_apart(label: str, unit: str = "") -> tuple[str, str]:
    """A label and its unit, which may be in brackets behind it: `acc_x [g]`."""
    match = _UNIT.match(label)
    return (match["label"], unit or match["unit"]) if match else (label, unit)


def triples_of(columns: Sequence[Labelled], notes: list[str]) -> list[Triple]:
    """Sensors' samples among columns, by labels or else by values; doubts are added to `notes`."""
    found: dict[tuple[str, str, str], dict[str, Labelled]] = {}
    streams = list(dict.fromkeys(column.stream for column in columns))
    labelled = [(column, read) for column in columns if (read := read_label(column.label, column.type))]
    named = any(read.sensor for _, read in labelled)
    for column, read in labelled:
        alone = read.sensor or (column.stream if len(streams) > 1 and not named else "") or "imu"
        found.setdefault((alone, read.quantity, column.stream), {}).setdefault(read.axis, column)
    triples = []
    for (sensor, kind, _), axes in found.items():
        if len(axes) < len("xyz"):
            notes.append(f"{sensor}: {kind} has no axis {next(axis for axis in 'xyz' if axis not in axes)}: "
                         "left out")
            continue
        x, y, z = (axes[axis] for axis in "xyz")
        triples.append(Triple(sensor, kind, (x, y, z), x.unit))
    return triples or _by_values(columns, notes)


def _by_values(columns: Sequence[Labelled], notes: list[str]) -> list[Triple]:
    """Accelerometers by gravity, and the gyroscopes beside them."""
    triples: list[Triple] = []
    for stream in dict.fromkeys(column.stream for column in columns):
        own = [column for column in columns if column.stream == stream and np.isfinite(column.values).any()]
        pairs, gyr_first = _pairs(own)
        for gyr, start in pairs:
            labels = [column.label for each in (gyr, start) for column in own[each:each + 3]]
            alike = takewhile(lambda letters: len(set(letters)) == 1, zip(*labels, strict=False))
            sensor = "".join(letters[0] for letters in alike).rstrip("_-. ") \
                or f"sensor{len(triples) // 2 + 1}"
            if sensor in {triple.sensor for triple in triples}:
                sensor = f"{sensor}{len(triples) // 2 + 1}"
            for kind, first in (("gyr", gyr), ("acc", start)):
                x, y, z = own[first:first + 3]
                triples.append(Triple(sensor, kind, (x, y, z), ""))
    if triples:
        notes.append("no label names a kind of samples: accelerometers are columns in which gravity is, "
                     f"gyroscopes those {'before' if gyr_first else 'behind'} them; check both")
    return triples


def _pairs(own: Sequence[Labelled]) -> tuple[list[tuple[int, int]], bool]:
    """First columns of gyroscopes and their accelerometers, and whether gyroscopes come first.

    Gravity is also in the window one column beside an accelerometer's, as far as the neighbour is small. Of
    all ways to divide the columns into threes, and of the one that takes gravity where it comes first, that
    with the most pairs is taken, of equals the one that begins earliest.
    """
    def has_gravity(at: int) -> bool:
        return bool(gravity_unit(np.column_stack([column.values for column in own[at:at + 3]])))

    def paired(starts: list[int]) -> tuple[list[tuple[int, int]], bool]:
        first = bool(starts) and all(start >= 3 and start - 3 not in starts for start in starts)
        beside = [(start - 3 if first else start + 3, start) for start in starts]
        return [(gyr, start) for gyr, start in beside if gyr + 3 <= len(own) and gyr not in starts], first

    anywhere, at = [], 0
    while at + 3 <= len(own):
        if has_gravity(at):
            anywhere.append(at)
        at += 3 if has_gravity(at) else 1
    ways = [[at for at in range(offset, len(own) - 2, 3) if has_gravity(at)] for offset in range(3)]
    return max(map(paired, [*ways, anywhere]), key=lambda way: len(way[0]))


def gravity_unit(samples: Array) -> str:
    """Unit in which samples (n, 3) are those of an accelerometer in quiet motion; empty for none."""
    length = np.linalg.norm(samples, axis=1)
    known = length[np.isfinite(length)]
    middle = float(np.median(known)) if known.size else 0.0
    return next((unit for unit, gravity in _GRAVITY_IN.items()
                 if abs(middle / gravity - 1.0) < _GRAVITY_WITHIN
                 and float(np.median(np.abs(known / gravity - 1.0))) < 2.0 * _GRAVITY_WITHIN), "")


def units_of(triples: Sequence[Triple], times_s: Array | None, notes: list[str]) -> dict[str, str]:
    """Unit of each kind: as labels state it, or else by the values; doubts are added to `notes`."""
    units: dict[str, str] = {}
    for kind in _KINDS:
        own = [triple for triple in triples if triple.kind == kind]
        stated = list(dict.fromkeys(triple.unit for triple in own if is_unit(kind, triple.unit)))
        if not own:
            continue
        if stated:
            units[kind] = stated[0]
            if len(stated) > 1:
                notes.append(f"{kind} is in {' and in '.join(stated)}, a layout has one unit of a kind: "
                             f"{stated[0]} is written")
            continue
        unit = _guessed_unit(kind, own, triples, times_s)
        states = f"{own[0].unit!r} is no unit of {kind}" if own[0].unit else f"no unit of {kind} is stated"
        notes.append(f"{states}: by its numbers it is {unit}" if unit else
                     f"{states}, and its numbers fit none: write units.{kind}")
        if unit:
            units[kind] = unit
    return units


def _guessed_unit(kind: str, own: Sequence[Triple], triples: Sequence[Triple],
                  times_s: Array | None) -> str:
    if kind == "acc":
        return gravity_unit(own[0].samples)
    if kind == "mag":
        middle = float(np.nanmedian(np.linalg.norm(own[0].samples, axis=1)))
        return next((unit for unit, each in _EARTH_IN.items()
                     if _EARTH_UT[0] * each <= middle <= _EARTH_UT[1] * each), "")
    fastest = max(float(np.nanmax(np.abs(triple.samples))) for triple in own)
    if fastest > _FASTEST_RAD_S:
        return "deg/s"
    pairs = {triple.sensor: triple for triple in triples if triple.kind == "acc"}
    both = next(((gyr, pairs[gyr.sensor]) for gyr in own if gyr.sensor in pairs
                 and len(gyr.samples) == len(pairs[gyr.sensor].samples)), None)
    if both is not None and times_s is not None and times_s.size == len(both[0].samples):
        gyr, acc = both
        unit = acc.unit if is_unit("acc", acc.unit) else gravity_unit(acc.samples)
        if unit:
            scale = factor("acc", unit, "acc")
            verdict = agreements(times_s, gyr.samples[:, np.newaxis], scale * acc.samples[:, np.newaxis])[0]
            ratio = verdict.factor * 180.0 / np.pi
            scaled = verdict.verdict in ("scale", "axes_and_scale")
            if scaled and 1.0 / _DEGREES_WITHIN < ratio < _DEGREES_WITHIN:
                return "deg/s"
    return "rad/s"


def time_of(columns: Sequence[Labelled], notes: list[str]) -> tuple[Labelled, str] | None:
    """Column of the instants and its unit, by its label and its values; None where there is none."""
    def rising(column: Labelled) -> bool:
        steps = np.diff(column.values)
        return steps.size >= _LEAST - 1 and bool(np.isfinite(steps).all() and (steps > 0.0).all())

    labelled = [(column, match["unit"] or "") for column in columns
                if (match := _TIME.match(column.label.strip()))]
    if not labelled:
        unread = [column for column in columns if read_label(column.label, column.type) is None]
        labelled = [(column, "") for column in unread if rising(column)][:1]
        if labelled:
            notes.append(f"column {labelled[0][0].label or labelled[0][0].number} rises throughout: "
                         "it is taken for the instants")
    for column, unit in labelled:
        if not rising(column):
            notes.append(f"{column.label or column.number} does not rise throughout, and gives no instants")
            continue
        step = float(np.median(np.diff(column.values)))
        own = column.unit or unit
        if is_unit("time", own):
            return column, own
        fits = [name for name, size in _TIME_UNITS.items()
                if _RATES_HZ[0] <= 1.0 / (step * size) <= _RATES_HZ[1]]
        if bool((np.diff(column.values) == 1.0).all()) or not fits:
            notes.append(f"{column.label or column.number} counts samples, or is in an unknown unit: "
                         "it gives no instants")
            continue
        notes.append(f"no unit of time is stated: by the rate it is {fits[0]}")
        return column, fits[0]
    return None


def every_of(triples: Sequence[Triple]) -> dict[str, dict[str, int]]:
    """Rows from one sample to the next, {sensor: {kind: rows}}, of kinds that are not in every row."""
    found: dict[str, dict[str, int]] = {}
    for triple in triples:
        rows = np.diff(np.flatnonzero(np.isfinite(triple.samples).all(axis=1)))
        usual = int(np.median(rows)) if rows.size else 1
        if usual > 1 and (rows == usual).mean() >= _USUAL:
            found.setdefault(triple.sensor, {})[triple.kind] = usual
    return found


def place_of(columns: Sequence[Labelled], names: Sequence[str]) -> Any:
    """How a layout names columns; `names` are all those of a text table, where they may recur."""
    first = columns[0]
    if not first.stream:
        named = all(column.name and names.count(column.name) == 1 for column in columns)
        return [column.name if named else column.number for column in columns]
    if first.whole and len(columns) == len("xyz"):
        return first.stream
    if len({column.stream for column in columns}) > 1:
        return [column.stream for column in columns]
    return {"variable": first.stream, "columns": [column.name or column.number for column in columns]}


def layout_of(triples: Sequence[Triple], units: Mapping[str, str], base: Mapping[str, Any],
              names: Sequence[str], notes: list[str]) -> dict[str, Any]:
    """Tables of a layout; `base` has its rate or time, and other keys. Empty without a whole sensor.

    `names`: those of all columns of a text table.
    """
    sensors: dict[str, dict[str, Any]] = {}
    every = every_of(triples)
    kinds = {name: {triple.kind for triple in triples if triple.sensor == name}
             for name in dict.fromkeys(triple.sensor for triple in triples)}
    whole = [name for name, own in kinds.items() if {"gyr", "acc"} <= own]
    with_mag = bool(whole) and "mag" in units and all("mag" in kinds[name] for name in whole)
    for name, own in kinds.items():
        if name not in whole:
            notes.append(f"{name} has {' and '.join(sorted(own))} alone, and no "
                         f"{' and '.join(sorted({'gyr', 'acc'} - own))}: left out")
    if not with_mag and any("mag" in kinds[name] for name in whole):
        notes.append("magnetometers are left out: their unit is unknown, or not every sensor has one")
    for triple in triples:
        if triple.sensor in whole and (triple.kind != "mag" or with_mag):
            sensors.setdefault(triple.sensor, {})[triple.kind] = place_of(triple.columns, names)
    for name, rows in every.items():
        if name in sensors and "resample" not in base:
            sensors[name]["every"] = rows
    kept = {kind: unit for kind, unit in units.items() if kind != "mag" or with_mag}
    stated = {**base.get("units", {}), **kept}
    return {**base, "units": stated, "sensors": sensors} if sensors else {}
