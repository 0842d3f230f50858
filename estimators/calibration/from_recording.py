"""Calibration from a recording of inertial sensors, with or without an optical reference.

The steps are those of Salchow-Hoemmen et al. 2019 (doi 10.3390/s19010208, section 3.1.2): the axes of hinges
in the sensors' frames, the orientation of each sensor on its segment, the offset between two clocks, the
centre about which a marker turns (eq. 28), and the transformation to the wrist's frame (eq. 29).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple, TypeVar, cast

import numpy as np
from numpy.typing import NDArray
from scipy.signal import butter, sosfiltfilt
from scipy.spatial.transform import Rotation

from estimators.calibration.frame_alignment import (
    FrameAlignment,
    align_directions,
    align_points,
    alignment,
)
from estimators.calibration.joint_axis import hinge_axes, rates_across
from estimators.calibration.poses import USUAL_LIMITS, FlatPose, PoseLimits, flat_faults, raise_faults
from estimators.calibration.rotation_centre import rotation_centre
from estimators.calibration.sensor_to_segment import FLEXION, dorsal, rotation_from_axes
from estimators.calibration.time_offset import time_offset
from fesloop.errors import InputError, InputErrors, did_you_mean
from fesloop.hand import quaternion
from fesloop.loop.clock import NS_PER_S
from fesloop.models.calibration import (
    Calibration,
    CentreCalibration,
    ClockCalibration,
    FrameCalibration,
    HingeCalibration,
    Quaternion,
    SensorRotation,
    Vector,
)
from fesloop.streams.files import open_recording
from fesloop.streams.recording import MotionRecording, Reference
from fesloop.streams.text_table import TextForm, read_table

Array = NDArray[np.float64]
Window = tuple[float, float]
_Found = TypeVar("_Found")
LEAST_MOVING_RAD_S = 0.2
"""Rate below which a sample shows no axis of rotation (chosen: above a gyroscope's bias and tremor)."""
LARGEST_RESIDUAL_SHARE = 0.35
"""Rms difference of the rates across a hinge's axis, over their rms, beyond which the joint is no hinge
(chosen: hinges with rigid sensors have 0.02 to 0.28, a saddle 0.37)."""
LARGEST_MISFIT_M = 0.01
"""Misfit of markers at rest beyond which some have moved or are mistaken for each other (chosen)."""
LARGEST_RADIUS_M = 2.0
"""Distances beyond this are no arm's: positions are likely in another unit (chosen)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CalibrationTask:
    """Parts of a recording to calibrate, and the intervals that they are calibrated from.

    Attributes
    ----------
    joints: hinges as "PARENT-CHILD"; empty: all pairs of the recording.
    flat_s: begin and end of a rest with the hand flat, back upwards, s; None: there is none. Each hinge
        first flexes after it.
    side: side of the hand, which decides where dorsal is.
    low_pass_hz: cut-off of a low-pass filter before axes are sought, for sensors on soft tissue; 0: none.
    markers: file of marker positions; "": none.
    marker: the marker whose arcs show the centre of rotation.
    sensor: the sensor on the marker's segment, whose rates show the time offset; "": the marker's namesake.
    arcs_s: begin and end of the arcs on the markers' clock, s; None: the whole file.
    rotation: from the marker system's frame to the target frame (w, x, y, z), where it is known.
    fixture: file of the positions, in the target frame, of markers that do not move; "": none.
    limits: limits of the flat pose.
    """

    joints: tuple[str, ...] = ()
    flat_s: Window | None = None
    side: str = "right"
    low_pass_hz: float = 0.0
    markers: str = ""
    marker: str = ""
    sensor: str = ""
    arcs_s: Window | None = None
    rotation: Quaternion | None = None
    fixture: str = ""
    limits: PoseLimits = USUAL_LIMITS

    def __post_init__(self) -> None:
        dorsal(self.side)
        for name in ("flat_s", "arcs_s"):
            window = getattr(self, name)
            if window is not None and not window[0] < window[1]:
                raise InputError(name, f"{window[0]:g} to {window[1]:g} s", "a begin before the end")
        if not self.low_pass_hz >= 0.0:
            raise InputError("low_pass_hz", f"{self.low_pass_hz}", "0 or more")
        if self.rotation is not None and self.fixture:
            raise InputError("rotation", "is given together with fixture", "one of the two")
        for name in ("marker", "rotation", "fixture", "arcs_s"):
            if getattr(self, name) and not self.markers:
                raise InputError(name, "is given without markers", "a file of marker positions beside it")
        if self.rotation is not None and not self.marker:
            raise InputError("rotation", "is given without marker",
                             "the marker whose centre of rotation is the origin")


class Markers(NamedTuple):
    """Positions of markers.

    Attributes
    ----------
    path: path of the file.
    times_s: (m,), s on the clock of the marker system.
    positions: (m, 3) by name, m; NaN where unknown.
    """

    path: str
    times_s: Array
    positions: Mapping[str, Array]

    def of(self, name: str) -> Array:
        """Positions of a marker. Raises InputError for an unknown name."""
        if name not in self.positions:
            raise InputError(f"{self.path}: {name}", "is no marker of this file", ", ".join(self.positions),
                             did_you_mean(name, self.positions))
        return self.positions[name]


@dataclass(frozen=True, slots=True, eq=False)
class Calibrated:
    """A calibration.

    Attributes
    ----------
    calibration: everything that was found.
    refused: a line for each part that was tried by default and could not be found.
    markers: markers of the file, or None.
    """

    calibration: Calibration
    refused: tuple[str, ...]
    markers: Markers | None

    def write_markers(self, path: Path) -> None:
        """Write the markers in the target frame (eq. 29), on the sensors' clock where its offset is known.

        Raises InputError where no transformation was found, or the file cannot be written.
        """
        if self.markers is None or not self.calibration.frames:
            raise InputError("markers", "no transformation to another frame is known", "--rotation with "
                             "--marker, or --fixture")
        frame, markers = self.calibration.frames[0], self.markers
        to_frame = FrameAlignment(np.array(frame.rotation), np.array(frame.origin_m))
        late_s = sum(each.offset_s for each in self.calibration.clocks if each.other == markers.path)
        header = ["time_s", *(f"{name}_{axis}" for name in markers.positions for axis in "xyz")]
        columns = [markers.times_s + late_s, *(to_frame.points(each) for each in markers.positions.values())]
        try:
            np.savetxt(path, np.column_stack(columns), fmt="%.9g", delimiter=",", header=",".join(header),
                       comments="")
        except OSError as fault:
            raise InputError(str(path), f"cannot be written: {fault.strerror}", "a file") from None


class _Attempts:
    """Faults of the parts that the user named, and of those tried by default."""

    def __init__(self) -> None:
        self.named: list[InputError] = []
        self.unnamed: list[InputError] = []

    def result(self, where: str, attempt: Callable[[], _Found], named: bool) -> list[_Found]:
        """One result, or none, with its fault kept, where the attempt raises InputError."""
        try:
            return [attempt()]
        except InputError as fault:
            faults = fault.faults if isinstance(fault, InputErrors) else [fault]
            (self.named if named else self.unnamed).extend(each.within(where) for each in faults)
            return []


def calibrate_recording(path: str, *, sensor_set: str | None = None, layout: str | None = None,
                        **task: Any) -> Calibrated:
    """Calibrate the sensors, joints, clocks and frames of a recording.

    Parameters
    ----------
    path, sensor_set, layout: as in `fesloop.streams.files.open_recording`.
    task: fields of `CalibrationTask`.

    Raises InputError for input that cannot be used, for a part that is named in `task` and cannot be found,
    and where nothing can be found.
    """
    stated = CalibrationTask(**task)
    recording = open_recording(path, sensor_set, layout)
    attempts = _Attempts()
    hinges = _hinges(recording, stated, attempts)
    clocks: list[ClockCalibration] = []
    rotations: list[SensorRotation] = []
    if stated.flat_s is not None:
        for found in attempts.result("flat", lambda: rotations_from_flat(recording, hinges, stated), True):
            rotations += found
    if recording.reference is not None:
        rates = reference_rates(recording.reference)
        clocks = attempts.result("reference", lambda: _reference_clock(recording, rates), False)
        if stated.flat_s is None:
            offset_s = clocks[0].offset_s if clocks else 0.0
            for number, name in enumerate(recording.sensors):
                rotations += attempts.result(name, partial(
                    rotation_from_reference, recording, number, rates, offset_s), False)
    markers = read_markers(stated.markers) if stated.markers else None
    centres: list[CentreCalibration] = []
    frames: list[FrameCalibration] = []
    if markers is not None:
        if stated.marker:
            centres = attempts.result(stated.marker, lambda: marker_centre(markers, stated), True)
        if stated.fixture:
            frames = attempts.result(stated.fixture, lambda: _fixture_frame(markers, stated.fixture), True)
        if centres:
            sensor = stated.sensor or stated.marker
            clocks += attempts.result(stated.markers, lambda: _marker_clock(
                recording, markers, stated, centres[0], sensor), bool(stated.sensor))
            if stated.rotation is not None:
                frame = alignment(stated.rotation, centres[0].centre_m)
                frames = [FrameCalibration(rotation=_four(frame.rotation), origin_m=_three(frame.origin))]
    if attempts.named:
        raise InputErrors(attempts.named)
    calibration = Calibration(source=recording.path.name, sensors=tuple(rotations), hinges=tuple(hinges),
                              clocks=tuple(clocks), centres=tuple(centres), frames=tuple(frames))
    if calibration.empty:
        raise InputErrors(attempts.unnamed or [InputError(
            path, "has neither pairs of sensors nor a reference", "one of the two",
            "name hinges with --joint, or give a file of markers")])
    return Calibrated(calibration, tuple(str(fault) for fault in attempts.unnamed), markers)


def _hinges(recording: MotionRecording, task: CalibrationTask, attempts: _Attempts) -> list[HingeCalibration]:
    """Axes of the named hinges, or of all pairs of the recording."""
    names = recording.sensors
    if not task.joints:
        pairs = dict.fromkeys(recording.pairs)
    else:
        known = {f"{parent}-{child}": (i, j) for i, parent in enumerate(names)
                 for j, child in enumerate(names) if i != j}
        for joint in task.joints:
            if joint not in known:
                raise InputError("joint", f"{joint!r}", f"PARENT-CHILD, two of {', '.join(names)}",
                                 did_you_mean(joint, known))
        pairs = dict.fromkeys(known[joint] for joint in task.joints)
    if not pairs:
        return []
    gyr, acc = (_low_passed(recording, kind, task.low_pass_hz) for kind in (recording.gyr, recording.acc))
    return [hinge for pair in pairs for hinge in attempts.result(
        recording.pair_name(pair), partial(_hinge, names, pair, gyr, acc), bool(task.joints))]


def _hinge(names: Sequence[str], pair: tuple[int, int], gyr: Array, acc: Array) -> HingeCalibration:
    both = list(pair)
    found = hinge_axes(gyr[:, both], acc[:, both])
    across = rates_across(gyr[:, both], found.axes)
    share = found.gyr_rms / math.sqrt(np.nanmean(across**2))
    if not share <= LARGEST_RESIDUAL_SHARE:
        raise InputError("hinge axis", f"{100.0 * share:.0f} % of the rates across it differ between the "
                         "sensors", f"{100.0 * LARGEST_RESIDUAL_SHARE:g} % or less",
                         "name hinges alone with --joint, and set --low-pass 3 for sensors on soft tissue")
    return HingeCalibration(
        parent=names[pair[0]], child=names[pair[1]], parent_axis=_three(found.axes[0]),
        child_axis=_three(found.axes[1]), parent_sd_deg=float(found.sd_deg[0]),
        child_sd_deg=float(found.sd_deg[1]), residual_deg_s=math.degrees(found.gyr_rms))


def _low_passed(recording: MotionRecording, samples: Array, cut_hz: float) -> Array:
    """Samples (m, n, 3) below a frequency, forwards and backwards so that nothing is delayed; NaN stays.

    Raises InputError where the recording has no rate, or too low a one.
    """
    if cut_hz == 0.0:
        return samples
    if recording.rate is None or not cut_hz < 0.5 * float(recording.rate):
        raise InputError("low_pass_hz", f"{cut_hz:g}", "below half the rate of an evenly sampled recording")
    known = np.isfinite(samples)
    rows = np.arange(len(samples))
    flat, known_columns = samples.reshape(len(samples), -1), known.reshape(len(samples), -1)
    bridged = np.column_stack([np.interp(rows, rows[sure], column[sure]) if sure.any() else 0.0 * rows
                               for column, sure in zip(flat.T, known_columns.T, strict=True)])
    slow = sosfiltfilt(butter(2, cut_hz, fs=float(recording.rate), output="sos"), bridged, axis=0)
    return np.where(known, slow.reshape(samples.shape), np.nan)


def rotations_from_flat(recording: MotionRecording, hinges: Sequence[HingeCalibration],
                        task: CalibrationTask) -> list[SensorRotation]:
    """Orientation of each sensor of a hinge: from the vertical of the flat hand and from the hinge's axis.

    The method is eq. 34 of doi 10.1186/1743-0003-11-70, with the axis from both sensors in place of one
    sensor's rate. The furthest turn of a hinge after the rest counts as flexion, about +z.

    Raises InputErrors, a line a sensor.
    """
    assert task.flat_s is not None
    begin, end = task.flat_s
    times = recording.stamps_ns / NS_PER_S
    still, moving = (times >= begin) & (times < end), times >= end
    names = list(recording.sensors)
    sensed = sorted({names.index(name) for hinge in hinges for name in (hinge.parent, hinge.child)})
    if not sensed:
        raise InputError("sensors", "no hinge has a known axis", "one or more", "name hinges with --joint")
    flat = FlatPose.of(len(sensed))
    flat.take_gyr(recording.gyr[still][:, sensed])
    flat.take_acc(recording.acc[still][:, sensed])
    back = np.tile(dorsal(task.side), (len(sensed), 1))
    raise_faults(flat_faults(flat, task.limits, None, back), [names[number] for number in sensed])
    bias, up = flat.bias(), flat.vertical()
    axes = np.zeros((len(sensed), 3))
    for hinge in hinges:
        ends = [(hinge.parent, np.array(hinge.parent_axis), hinge.parent_sd_deg),
                (hinge.child, np.array(hinge.child_axis), hinge.child_sd_deg)]
        rates = [(recording.gyr[moving, names.index(name)] - bias[sensed.index(names.index(name))]) @ axis
                 for name, axis, _ in ends]
        turn = np.cumsum(np.nan_to_num(rates[1] - rates[0])[:-1] * np.diff(times[moving]))
        furthest = float(turn[np.argmax(np.abs(turn))]) if turn.size else 0.0
        if not math.degrees(abs(furthest)) >= task.limits.least_flexion_deg:
            raise InputError(f"{hinge.parent}-{hinge.child}", f"turns by {math.degrees(abs(furthest)):.0f} "
                             "deg after the rest", f"{task.limits.least_flexion_deg:g} deg or more",
                             "flex every joint, and further")
        for name, axis, sd in ends:
            axes[sensed.index(names.index(name))] += math.copysign(1.0, furthest) * axis / max(sd, 1e-3) ** 2
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    skew = 90.0 - np.degrees(np.arccos(np.clip(np.sum(axes * up, axis=1), -1.0, 1.0)))
    wrong = [InputError(names[number], f"axis and vertical are {skew[k]:+.0f} deg from perpendicular",
                        f"within {task.limits.skew_deg:g} deg", "lay the whole hand flat on a table")
             for k, number in enumerate(sensed) if not abs(skew[k]) <= task.limits.skew_deg]
    if wrong:
        raise InputErrors(wrong)
    rotations = rotation_from_axes((up, axes), (back, np.tile(FLEXION, (len(sensed), 1))))
    return [SensorRotation(name=names[number], rotation=_four(rotations[k]), off_deg=abs(float(skew[k])) / 2,
                           method="flat") for k, number in enumerate(sensed)]


class ReferenceRates(NamedTuple):
    """Angular rates of the segments of a reference.

    Attributes
    ----------
    times_s: (m,), s, halfway between two of its samples.
    rates: (m, n, 3), rad/s, in the segments' frames; NaN where unknown.
    """

    times_s: Array
    rates: Array


def reference_rates(reference: Reference) -> ReferenceRates:
    """Angular rates from the turn between each two samples; unknown across gaps."""
    times = reference.stamps_ns / NS_PER_S
    steps = np.diff(times)
    turned = quaternion.relative(reference.orientation[:-1], reference.orientation[1:])
    rates = np.full((*turned.shape[:-1], 3), np.nan)
    known = np.isfinite(turned).all(axis=-1) & (steps <= 3.0 * np.median(steps))[:, np.newaxis]
    rates[known] = Rotation.from_quat(turned[known], scalar_first=True).as_rotvec()
    return ReferenceRates(0.5 * (times[:-1] + times[1:]), rates / steps[:, np.newaxis, np.newaxis])


def _reference_clock(recording: MotionRecording, reference: ReferenceRates) -> ClockCalibration:
    """Offset of the reference's clock, by the sensor whose rates fit the reference's best."""
    times, found, fault = recording.stamps_ns / NS_PER_S, [], None
    for number, name in enumerate(recording.sensors):
        try:
            found.append((name, time_offset(times, recording.gyr[:, number], reference.times_s,
                                            reference.rates[:, number])))
        except InputError as refused:
            fault = fault or refused
    if not found:
        raise fault or InputError("sensors", "none", "one or more")
    name, best = max(found, key=lambda each: each[1].peak)
    return ClockCalibration(other="reference", offset_s=best.offset_s, peak=best.peak,
                            second_peak=best.second_peak, sensor=name)


def rotation_from_reference(recording: MotionRecording, sensor: int, reference: ReferenceRates,
                            offset_s: float) -> SensorRotation:
    """Orientation of a sensor on its segment: the rotation that takes its rates to the reference's."""
    times = recording.stamps_ns / NS_PER_S
    gyr = np.column_stack([np.interp(reference.times_s + offset_s, times, column, np.nan, np.nan)
                           for column in recording.gyr[:, sensor].T])
    rates = reference.rates[:, sensor]
    size = np.minimum(np.linalg.norm(gyr, axis=1), np.linalg.norm(rates, axis=1))
    moving = size > LEAST_MOVING_RAD_S
    if not moving.any():
        raise InputError("rates", f"never exceed {LEAST_MOVING_RAD_S:g} rad/s in both", "a motion",
                         "turn the sensor about two axes")
    found = align_directions(gyr[moving], rates[moving], size[moving] ** 2)
    return SensorRotation(name=recording.sensors[sensor], rotation=_four(found.rotation),
                          off_deg=math.degrees(found.rms), method="reference")


def read_markers(path: str) -> Markers:
    """Positions from a table with the columns time_s and NAME_x, NAME_y, NAME_z of each marker, m.

    Raises InputError for another table.
    """
    table = read_table(Path(path), TextForm())
    columns = dict(zip(table.names, table.values.T, strict=True))
    names = [name[:-2] for name in table.names if name.endswith("_x")]
    lacking = [f"{name}_{axis}" for name in names for axis in "yz" if f"{name}_{axis}" not in columns]
    if not names or lacking:
        raise InputError(path, f"lacks {', '.join(lacking) or 'columns of markers'}",
                         "time_s, and NAME_x, NAME_y, NAME_z of each marker, in m")
    positions = {name: np.column_stack([columns[f"{name}_{axis}"] for axis in "xyz"]) for name in names}
    return Markers(path, columns.get("time_s", np.full(len(table.values), np.nan)), positions)


def marker_centre(markers: Markers, task: CalibrationTask) -> CentreCalibration:
    """Centre about which the marker turns (doi 10.3390/s19010208, eq. 28)."""
    found = rotation_centre(markers.of(task.marker)[_during(markers, task.arcs_s)])
    if not found.radius <= LARGEST_RADIUS_M:
        raise InputError("positions", f"turn about a centre {found.radius:.3g} m away",
                         f"{LARGEST_RADIUS_M:g} m or less", "give positions in metres")
    return CentreCalibration(marker=task.marker, centre_m=_three(found.centre), radius_m=found.radius,
                             deviation_m=found.deviation, sd_m=found.sd)


def _during(markers: Markers, window: Window | None) -> NDArray[np.bool_]:
    if window is None:
        return np.ones(markers.times_s.size, dtype=np.bool_)
    return np.asarray((markers.times_s >= window[0]) & (markers.times_s < window[1]))


def _marker_clock(recording: MotionRecording, markers: Markers, task: CalibrationTask,
                  centre: CentreCalibration, sensor: str) -> ClockCalibration:
    """Offset of the markers' clock, from the speed of the marker about its centre and a sensor's rate."""
    if sensor not in recording.sensors:
        raise InputError("sensor", f"{sensor!r}", ", ".join(recording.sensors),
                         did_you_mean(sensor, recording.sensors))
    during = _during(markers, task.arcs_s)
    times, away = markers.times_s[during], markers.of(task.marker)[during] - np.array(centre.centre_m)
    sine = np.linalg.norm(np.cross(away[:-1], away[1:]), axis=1)
    speed = np.arctan2(sine, np.sum(away[:-1] * away[1:], axis=1)) / np.diff(times)
    number = recording.sensors.index(sensor)
    found = time_offset(recording.stamps_ns / NS_PER_S, recording.gyr[:, number],
                        0.5 * (times[:-1] + times[1:]), speed)
    return ClockCalibration(other=task.markers, offset_s=found.offset_s, peak=found.peak,
                            second_peak=found.second_peak, sensor=sensor)


def _fixture_frame(markers: Markers, path: str) -> FrameCalibration:
    """Transformation to the frame in which the positions of markers at rest are known."""
    fixture = read_markers(path)
    known, seen = (np.stack([np.nanmean(each.of(name), axis=0) for name in fixture.positions])
                   for each in (fixture, markers))
    found = align_points(seen, known)
    if not found.rms <= LARGEST_MISFIT_M:
        raise InputError("markers", f"are {1e3 * found.rms:.1f} mm (rms) from where the fixture has them",
                         f"{1e3 * LARGEST_MISFIT_M:g} mm or less",
                         "check their names and units, and that they did not move")
    return FrameCalibration(rotation=_four(found.rotation), origin_m=_three(found.origin), rms_m=found.rms)


def _three(vector: Array) -> Vector:
    return cast(Vector, tuple(np.asarray(vector).tolist()))


def _four(rotation: Array) -> Quaternion:
    return cast(Quaternion, tuple(np.asarray(rotation).tolist()))
