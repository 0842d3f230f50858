"""Movement of a hand as a file recorded its joint angles."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BPoly, make_interp_spline
from scipy.signal import butter, sosfiltfilt

from fesloop.errors import InputError, did_you_mean
from fesloop.experiment.angle_courses import read_courses
from fesloop.forms.schema import require_not_negative
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.segments import SegmentTree
from fesloop.hand.skeleton import hand_tree
from plants.moving_hand.path import ARM, MotionPath

Array = NDArray[np.float64]
_LEAST = 12
"""Least number of samples: a filter of second order, forwards and backwards, needs more than nine."""
_BEYOND_DEG = 30.0
"""Distance beyond a joint's range at which a sign or a zero is wrong, rather than a joint lax (chosen)."""
_GAP_S, _GAP_STEPS = 0.1, 2.5
"""Longest distance of two samples, or so many times the usual one: half a period of the quickest movements of
a hand, so that a straight line is no guess (chosen)."""
_STOP_S = 0.5
"""Time in which the hand comes to rest behind the last sample (chosen)."""
_FREEDOMS = hand_tree(HandSize()).freedoms


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordedAngles:
    """Joint angles of a file (`fesloop.experiment.angle_courses`), which a hand follows.

    Samples are brought to their mean rate by straight lines, low-passed without delay (Butterworth of second
    order, forwards and backwards), and joined by a quintic spline, whose derivatives are the hand's rates and
    accelerations.

    Attributes
    ----------
    file: path of the file. signal, trial: of a recording of fesloop, such as "tracker.angles".
    columns: columns by freedom that are not named after it, "-NAME" for one of the opposite sign. Freedoms
        without a column keep the angle of `rest_deg`.
    start_s, duration_s: part of the file that is used; all by default.
    lowpass_hz: cut-off of the low pass (chosen: usual for movements of people); 0: none, so that noise of
        angles becomes noise of accelerations.
    still_s: time before, in which the hand is in the posture of `rest_deg`, from which trackers begin.
    approach_s: time from there to the first sample.
    fingerprint: SHA-256 of the file's names, times and values; filled in. Where it is given, the file must
        not have changed.
    """

    file: str
    signal: str = ""
    trial: int = 0
    columns: dict[str, str] = field(default_factory=dict)
    start_s: float = 0.0
    duration_s: float | None = None
    lowpass_hz: float = 6.0
    still_s: float = 1.5
    approach_s: float = 1.0
    fingerprint: str = ""
    times_s: Array = field(init=False, repr=False, compare=False)
    angles: Array = field(init=False, repr=False, compare=False)
    freedoms: tuple[str, ...] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        require_not_negative("recorded", self, "trial", "start_s", "lowpass_hz", "still_s")
        if not (math.isfinite(self.approach_s) and self.approach_s > 0.0):
            raise InputError("approach_s", f"{self.approach_s:g}", "above 0")
        courses = read_courses(self.file, self.signal, self.trial)
        found = courses.fingerprint()
        if self.fingerprint not in ("", found):
            raise InputError(self.file, f"has changed: its fingerprint is {found[:12]}",
                             f"{self.fingerprint[:12]}", "bring the file back, or leave fingerprint out")
        columns = self._columns(courses.names)
        signs = [-1.0 if name.startswith("-") else 1.0 for name in columns.values()]
        values = signs * courses.values[:, [courses.names.index(name.removeprefix("-"))
                                            for name in columns.values()]]
        stop = math.inf if self.duration_s is None else self.start_s + self.duration_s
        since = courses.times_s - courses.times_s[0]
        used = (since >= self.start_s) & (since <= stop)
        if used.sum() < _LEAST:
            raise InputError(self.file, f"holds {used.sum()} samples from start_s on, for duration_s",
                             f"{_LEAST} or more")
        times, angles = since[used] - since[used][0], values[used]
        self._require_samples(since[used])
        self._require_angles(tuple(columns), times, angles)
        rate = (times.size - 1) / float(times[-1])
        if self.lowpass_hz >= 0.5 * rate:
            raise InputError("lowpass_hz", f"{self.lowpass_hz:g}", f"below {0.5 * rate:g} Hz, half the rate "
                             f"of {self.file}", "lower it, or state 0 for none")
        for key, value in (("fingerprint", found), ("freedoms", tuple(columns)), ("times_s", times),
                           ("angles", angles)):
            object.__setattr__(self, key, value)

    def _columns(self, names: tuple[str, ...]) -> Mapping[str, str]:
        """Columns of the file by freedom."""
        columns = {name: name for name in names if name in _FREEDOMS} | self.columns
        if not columns:
            raise InputError(self.file, f"has no column of a freedom of the hand, but {', '.join(names[:9])}",
                             ", ".join(_FREEDOMS), 'state columns = { FREEDOM = "COLUMN" }')
        for freedom, name in columns.items():
            if freedom not in _FREEDOMS:
                raise InputError(f"columns.{freedom}", "is no freedom of the hand", ", ".join(_FREEDOMS),
                                 did_you_mean(freedom, _FREEDOMS))
            if name.removeprefix("-") not in names:
                raise InputError(f"columns.{freedom}", f"{name!r} is not in {self.file}",
                                 ", ".join(names[:40]), did_you_mean(name, names))
        return columns

    def _require_samples(self, since: Array) -> None:
        """Raise InputError for a gap, across which the movement is not known."""
        steps = np.diff(since)
        k, longest = int(steps.argmax()), max(_GAP_S, _GAP_STEPS * float(np.median(steps)))
        if steps[k] > longest * (1.0 + 1e-6):  # stamps are rounded
            raise InputError(self.file, f"has no samples for {steps[k]:.4g} s, from {since[k]:.4g} s on",
                             f"gaps of at most {longest:.3g} s", "use a part with start_s and duration_s")

    def _require_angles(self, freedoms: tuple[str, ...], times: Array, angles: Array) -> None:
        """Raise InputError for missing angles, and for those that no hand has."""
        ranges = np.degrees(hand_tree(HandSize()).ranges)
        for freedom, column in zip(freedoms, angles.T, strict=True):
            lost = ~np.isfinite(column)
            if lost.any():
                raise InputError(f"{self.file}: {freedom}", f"has {lost.sum()} samples without a number, the "
                                 f"first at {times[lost][0] + self.start_s:.4g} s", "a number in each",
                                 "fill the gaps, or use a part with start_s and duration_s")
            low, high = ranges[_FREEDOMS.index(freedom)]
            least, most = np.degrees([column.min(), column.max()])
            if least < low - _BEYOND_DEG or most > high + _BEYOND_DEG:
                raise InputError(f"{self.file}: {freedom}", f"is {least:.4g} to {most:.4g} deg",
                                 f"{low:.4g} to {high:.4g} deg, the joint's range, or little beyond",
                                 f'mend unit or zero, or its sign: columns = {{ {freedom} = "-NAME" }}')

    @property
    def length_s(self) -> float:
        """Duration of the movement, with what is before and behind the recording."""
        return self.still_s + self.approach_s + float(self.times_s[-1]) + _STOP_S


def recorded_path(recorded: RecordedAngles, tree: SegmentTree, rest: Array, knot_s: float) -> MotionPath:
    """Path of a hand that follows recorded angles from a posture `rest` (d,), rad; its forearm is still."""
    times, angles = recorded.times_s, recorded.angles
    even = np.linspace(0.0, float(times[-1]), times.size)
    values = np.stack([np.interp(even, times, column) for column in angles.T], axis=1)
    if recorded.lowpass_hz:
        rate = (times.size - 1) / float(times[-1])
        values = sosfiltfilt(butter(2, recorded.lowpass_hz, fs=rate, output="sos"), values, axis=0)
    spline = make_interp_spline(even, values, k=5)
    at = [tree.freedom(name) for name in recorded.freedoms]
    first, last = ([spline(end), spline(end, 1), spline(end, 2)] for end in (0.0, even[-1]))
    begin, end = recorded.still_s + recorded.approach_s, recorded.still_s + recorded.approach_s + even[-1]
    still = np.zeros(len(at))
    approach = BPoly.from_derivatives([recorded.still_s, begin], [[rest[at], still, still], first])
    leave = BPoly.from_derivatives([end, end + _STOP_S], [last, [last[0], still, still]])
    knot_times = knot_s * np.arange(1 + math.ceil(recorded.length_s / knot_s))
    knots = np.zeros((knot_times.size, 3, 2 * ARM + rest.size))
    knots[:, 0, ARM:-ARM] = rest
    for order in range(3):
        course = np.zeros((knot_times.size, len(at)))
        course[:] = rest[at] if order == 0 else 0.0
        for since, until, piece, shift in (
                (recorded.still_s, begin, approach, 0.0), (begin, end, spline, begin),
                (end, end + _STOP_S, leave, 0.0)):
            within = (knot_times >= since) & (knot_times <= until)
            course[within] = piece(knot_times[within] - shift, order)
        if order == 0:
            course[knot_times > end + _STOP_S] = last[0]
        knots[:, order, ARM + np.array(at)] = course
    return MotionPath(knot_s, knots, [])
