"""`recorded`: a reference from a file."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from controllers.reference.course import (
    Samples,
    checked_ranges,
    instants_ahead,
    reference_ports,
    reference_values,
    require_in_range,
    require_preview,
)
from fesloop.errors import InputError, did_you_mean
from fesloop.experiment.angle_courses import NamedCourses, read_courses
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_S, duration_ns
from fesloop.loop.signals import Port, Sample, Value
from fesloop.streams.blocks.synergies import READY, Synergies

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Recorded:
    """Samples of a file with straight lines between them, constant before the first and after the last.

    The file is a recording of fesloop (.h5), a file of OpenSim (.mot, .sto), or a CSV, NPZ or MATLAB 5 file
    with `time_s` or `time_ms` and a column `ROW_deg` or `ROW_rad` for each row. At t the reference is the
    file's at

        start_s + (t - shift_s) / stretch      after its first instant.

    Attributes
    ----------
    file: path of the file.
    signal: signal of a recording, such as "truth.synergies".
    trial: trial of a recording.
    rows: elements of `angles`, in this order: columns of the file, or ready synergies (of the block
        `synergies`) of freedoms that are its columns. Empty: all columns, in the file's order. Columns
        without names in the file take these.
    start_s: time of the file before its part that is used.
    duration_s: duration of that part; by default all.
    shift_s: time in a trial at which it begins.
    stretch: factor on all durations.
    range_deg: range of motion of some rows, in place of the one that follows from their joints.
    preview: number of coming instants in the output `preview`; 0: no such output.
    preview_period_ms: distance between them; the first is one period after now.
    fingerprint: SHA-256 of names, times and values; filled in by default. Where it is given, as in the
        recording of a run, the file must not have changed.

    Outputs: `angles` (m,) rad, and `preview` (preview, m) rad.
    """

    file: str
    signal: str = ""
    trial: int = 0
    rows: tuple[str, ...] = ()
    start_s: float = 0.0
    duration_s: float | None = None
    shift_s: float = 0.0
    stretch: float = 1.0
    range_deg: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    preview: int = 0
    preview_period_ms: float = 25.0
    fingerprint: str = ""
    course: Samples = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        require_preview(self.preview, self.preview_period_ms)
        if self.trial < 0:
            raise InputError("trial", f"{self.trial}", "0 or more")
        if not (math.isfinite(self.stretch) and self.stretch > 0.0):
            raise InputError("stretch", f"{self.stretch:g}", "a finite number above 0")
        courses = read_courses(self.file, self.signal, self.trial)
        found = courses.fingerprint()
        if self.fingerprint not in ("", found):
            raise InputError(self.file, f"has changed: its fingerprint is {found[:12]}",
                             f"{self.fingerprint[:12]}", "bring the file back, or leave fingerprint out")
        courses = _rows_of(self.file, courses, self.rows)
        object.__setattr__(self, "range_deg", checked_ranges(courses.names, self.range_deg))
        courses = self._window(courses)
        _require_range(self.file, courses, self.range_deg)
        shift = duration_ns(self.shift_s, NS_PER_S, "shift_s") / NS_PER_S
        times = shift + self.stretch * (courses.times_s - courses.times_s[0])
        course = Samples(times, courses.values)
        for key, value in (("fingerprint", found), ("rows", courses.names), ("course", course)):
            object.__setattr__(self, key, value)

    def _window(self, courses: NamedCourses) -> NamedCourses:
        """Part of the courses that is used, at the file's own times."""
        times = courses.times_s
        start = float(times[0]) + duration_ns(self.start_s, NS_PER_S, "start_s") / NS_PER_S
        if start >= times[-1]:
            raise InputError("start_s", f"{self.start_s:g} is past the end of {self.file}",
                             f"below {times[-1] - times[0]:g}")
        stop = float(times[-1])
        if self.duration_s is not None:
            if duration_ns(self.duration_s, NS_PER_S, "duration_s") == 0:
                raise InputError("duration_s", f"{self.duration_s:g}", "above 0, or omitted for all")
            stop = min(stop, start + self.duration_s)
        within = np.concatenate([[start], times[(times > start) & (times < stop)], [stop]])
        return NamedCourses(courses.names, within, Samples(times, courses.values).at(within))

    @property
    def inputs(self) -> tuple[Port, ...]:
        """None: a source."""
        return ()

    @property
    def outputs(self) -> tuple[Port, ...]:
        """`angles`, and `preview` if there is one."""
        return reference_ports(self.course, self.preview)

    def init(self, context: Context) -> Array:
        """Times of now and of the preview, relative to the tick."""
        return instants_ahead(self.preview, self.preview_period_ms)

    def step(self, state: Array, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
        """Reference of this tick and its preview."""
        return reference_values(self.course, state, tick)


def _rows_of(file: str, courses: NamedCourses, rows: tuple[str, ...]) -> NamedCourses:
    """Courses of the named rows; of all columns where none are named."""
    names, width = courses.names or rows, courses.values.shape[1]
    if len(names) != width:
        raise InputError("rows", f"{len(rows)} names, and {file} has none",
                         f"{width}, one for each column of the signal")
    columns = []
    for row in rows or names:
        known = (*names, *(name for name, weights in READY.items() if set(weights) <= set(names)))
        if row not in known:
            raise InputError("rows", f"{row!r} is not in {file}", ", ".join(known), did_you_mean(row, known))
        if row in names:
            columns.append(courses.values[:, names.index(row)])
        else:
            columns.append(courses.values @ Synergies(rows=(row,), freedoms=names).matrix[0])
    return NamedCourses(rows or names, courses.times_s, np.stack(columns, axis=-1))


def _require_range(file: str, courses: NamedCourses, range_deg: Mapping[str, Sequence[float]]) -> None:
    """Raise InputError where a row is not finite or leaves its range of motion, naming the first instant."""
    degrees = np.degrees(courses.values)
    for row, values in zip(courses.names, degrees.T, strict=True):
        lost = ~np.isfinite(values)
        furthest = (np.argmax(lost),) if lost.any() else (np.argmin(values), np.argmax(values))
        for at in furthest:
            require_in_range(f"{file}: {row} at {courses.times_s[at]:g} s", row, float(values[at]), range_deg)
