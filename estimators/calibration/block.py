"""`segment_calibration`: rotation of samples from the sensors' frames to the segments'."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal, cast

import numpy as np
from numpy.typing import NDArray

from estimators.calibration.poses import (
    USUAL_LIMITS,
    FlatPose,
    Flexion,
    PoseLimits,
    fault_errors,
    flat_faults,
    flexion_faults,
)
from estimators.calibration.sensor_to_segment import (
    FLEXION,
    assumed_mounting,
    directions,
    dorsal,
    mounting_faults,
    mounting_from_flat,
    mounting_from_poses,
)
from fesloop.compiled import compiled
from fesloop.errors import InputError, did_you_mean
from fesloop.hand.kinematics_kernels import turned
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_S, duration_ns
from fesloop.loop.signals import NEVER, Port, Sample, Sensors, Value
from fesloop.models.calibration import NO_CALIBRATION, Calibration

Array = NDArray[np.float64]
Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
Window = tuple[float, float]
METHODS = ("assumed", "flat", "poses")


@dataclass(slots=True, eq=False)
class SegmentCalibrationState:
    """State of a SegmentCalibration.

    Attributes
    ----------
    rotations: (n, 4), sensor to segment.
    passing: (n,), mask of the calibrated sensors.
    flat, flexion: sums over the poses.
    newest_ns: newest captures of gyroscopes and accelerometers.
    settled: whether `rotations` are final.
    announced: whether "calibrating" has been reported.
    """

    rotations: Array
    passing: NDArray[np.bool_]
    flat: FlatPose
    flexion: Flexion
    newest_ns: list[int]
    settled: bool = False
    announced: bool = False


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SegmentCalibration:
    """Samples in the segments' frames from samples in the sensors' frames.

    Inputs `gyr` (n, 3) rad/s, `acc` (n, 3) m/s^2 and, where there are magnetometers, `mag` (n, 3) T (left
    without a wire its output is zero). Outputs are the same, rotated. All outputs carry the stamps of all
    inputs together, as of any block: where gyroscopes are faster than accelerometers, a tracker after this
    block cannot distinguish held samples from new ones by their stamps.

    `method` "assumed" rotates by the stated `rotations` or the `calibration`. "poses" finds the rotations in
    the first trial of a run (Kortier et al. 2014, doi 10.1186/1743-0003-11-70, eq. 34): the wearer keeps the
    hand flat with its back upwards throughout `flat_s`, raises it, and flexes every joint of every sensed
    segment, the thumb's about its own axes, within `flexion_s`. Status "calibrating" until `flexion_s` ends,
    then "calibrated". "calibration_failed" names a sensor with an unusable pose, and the remedy.

    Before calibration, and after a failed one, a sensor's outputs are NaN, which trackers treat as lost
    samples.

    Attributes
    ----------
    sensors: number n; 0 takes it from the wire.
    side: side of the hand, which decides where its back points in the segments' frames
        (fesloop.hand.skeleton).
    method: "assumed", "flat" or "poses".
    rotations: from each sensor's frame to its segment's (w, x, y, z); one for all, or one each; empty: both
        frames coincide. For "poses", where given, the poses are checked against them.
    assumed: numbers of sensors that keep their stated rotation whatever the poses show, such as a forearm's
        on the table.
    flat_s, flexion_s: begin and end of the poses, s from the run's start, by the instants of capture (3 s
        flat: doi 10.3390/s19010208, section 2.4.2).
    verticals: direction upwards in each segment's frame in the flat pose; empty: dorsal for all.
    axes: first axis of rotation of each segment in the flexion; empty: +z, flexion, for all.
    limits: limits beyond which a pose is refused.
    sensed: names of the sensors; empty: those of the wired recording, or numbers.
    calibration: rotations by sensor name from `fesloop calibrate`, as { file = "calibration.toml" }, in place
        of `rotations`.
    """

    sensors: int = 0
    side: Literal["left", "right"] = "right"
    method: Literal["assumed", "flat", "poses"] = "assumed"
    rotations: tuple[Quaternion, ...] = ()
    assumed: tuple[int, ...] = ()
    flat_s: Window = (0.0, 3.0)
    flexion_s: Window = (4.0, 9.0)
    verticals: tuple[Vector, ...] = ()
    axes: tuple[Vector, ...] = ()
    limits: PoseLimits = USUAL_LIMITS
    sensed: tuple[str, ...] = ()
    calibration: Calibration = NO_CALIBRATION
    _sensors: Sensors | None = field(init=False, repr=False, compare=False, default=None)

    def __post_init__(self) -> None:
        if self.sensors < 0:
            raise InputError("sensors", f"{self.sensors}", "1 or more, or 0 to take it from the wire")
        if self.method not in METHODS:
            raise InputError("method", f"{self.method!r}", ", ".join(METHODS),
                             did_you_mean(self.method, METHODS))
        if self.calibration.sensors and self.rotations:
            raise InputError("rotations", "is given together with calibration", "one of the two")
        dorsal(self.side)
        ends = [end for name in ("flat_s", "flexion_s") for end in self._window_ns(name)]
        if self.method == "poses" and ends[2] < ends[1]:
            raise InputError("flexion_s", f"begins at {self.flexion_s[0]:g} s, before flat_s ends",
                             f"from {self.flat_s[1]:g} s on")
        if self.sensors:
            assumed_mounting(self.rotations, self.sensors)
            self._known_directions()
            for sensor in self.assumed:
                if not 0 <= sensor < self.sensors:
                    raise InputError("assumed", f"{sensor}", f"0 to {self.sensors - 1}")
            if self.sensed and len(self.sensed) != self.sensors:
                raise InputError("sensed", f"names {len(self.sensed)} segments, {self.sensors} sensors are "
                                           "wired", "one name a sensor, or none")

    @property
    def inputs(self) -> tuple[Port, ...]:
        """gyr, acc and mag, in the sensors' frames."""
        gyr, acc, mag = self.outputs
        return replace(gyr, gaps=False), replace(acc, gaps=False), replace(mag, gaps=False, optional=True)

    @property
    def outputs(self) -> tuple[Port, ...]:
        """gyr, acc and mag, in the segments' frames."""
        shape = (self.sensors or None, 3)
        return tuple(Port(name, shape, unit, gaps=True, sensors=self._sensors)
                     for name, unit in (("gyr", "rad/s"), ("acc", "m/s^2"), ("mag", "T")))

    def with_sensors(self, sources: Mapping[str, Sensors]) -> SegmentCalibration:
        """The block with the names of the wired sensors, for its outputs and `calibration`."""
        told = replace(self)
        object.__setattr__(told, "_sensors", next(iter(sources.values())))
        told._stated_rotations()
        return told

    def _stated_rotations(self) -> tuple[Quaternion, ...]:
        """Rotations as stated, or by name from the calibration. Raises InputError for unknown sensors."""
        if not self.calibration.sensors:
            return self.rotations
        names = self.sensed or (() if self._sensors is None else self._sensors.names)
        if not names:
            raise InputError("calibration", "names sensors, and the wired ones have no names",
                             "names in `sensed`", f"sensed = [...], of {self.sensors} names")
        return self.calibration.rotations(names)

    def resolve(self, shapes: Mapping[str, tuple[int, ...]]) -> SegmentCalibration:
        """The block for the number of wired sensors."""
        return replace(self, sensors=shapes["gyr"][0])

    def init(self, context: Context) -> SegmentCalibrationState:
        """State with the stated rotations, which are final for "assumed"."""
        settled = self.method == "assumed"
        return SegmentCalibrationState(
            rotations=assumed_mounting(self._stated_rotations(), self.sensors),
            passing=np.full(self.sensors, settled), flat=FlatPose.of(self.sensors),
            flexion=Flexion.of(self.sensors), newest_ns=[NEVER, NEVER], settled=settled)

    def next_trial(self, state: SegmentCalibrationState, context: Context) -> SegmentCalibrationState:
        """Keep a finished calibration for the next trial; restart an unfinished one."""
        return state if state.settled else self.init(context)

    def step(
        self, state: SegmentCalibrationState, inputs: Sequence[Sample], tick: Tick
    ) -> tuple[Value, ...]:
        """One rotated sample of every sensor."""
        if not state.settled:
            if not state.announced:
                tick.report("calibrating", f"flat hand from {self.flat_s[0]:g} to {self.flat_s[1]:g} s, "
                            f"flexion from {self.flexion_s[0]:g} to {self.flexion_s[1]:g} s")
                state.announced = True
            self._gather(state, inputs)
            if tick.time_ns >= self._window_ns("flat_s" if self.method == "flat" else "flexion_s")[1]:
                self._settle(state, tick)
        gyr, acc, mag = (sample.value for sample in inputs)
        return cast(tuple[Value, ...], turn_samples(state.rotations, state.passing, gyr, acc, mag))

    def _gather(self, state: SegmentCalibrationState, inputs: Sequence[Sample]) -> None:
        """Add new samples to the pose in whose window they were captured."""
        flat, flexion = self._window_ns("flat_s"), self._window_ns("flexion_s")
        for kind in range(2):
            sample, before = inputs[kind], state.newest_ns[kind]
            at = sample.newest_ns
            if at <= before:
                continue
            state.newest_ns[kind] = at
            rows: Any = sample.value
            if flat[0] <= at < flat[1]:
                (state.flat.take_gyr, state.flat.take_acc)[kind](rows[np.newaxis])
            elif kind == 0 and flexion[0] <= at < flexion[1]:
                elapsed = 0.0 if before == NEVER else (at - before) / NS_PER_S
                state.flexion.take((rows - state.flat.bias())[np.newaxis], np.array([elapsed]))

    def _settle(self, state: SegmentCalibrationState, tick: Tick) -> None:
        """Compute the rotations, and report their quality."""
        verticals, axes = self._known_directions()
        stated = state.rotations if self.rotations or self.calibration.sensors else None
        faults = flat_faults(state.flat, self.limits, stated, verticals)
        if self.method == "flat":
            rotations, told = mounting_from_flat(state.flat, verticals, state.rotations), ""
        else:
            found = mounting_from_poses(state.flat, state.flexion, verticals, axes)
            faults += flexion_faults(state.flexion, self.limits)
            faults += mounting_faults(found, self.limits, stated)
            rotations = found.rotations
        errors = fault_errors((fault for fault in faults if fault.sensor not in self.assumed), self.sensed)
        for error in errors.values():
            tick.report("calibration_failed", str(error))
        by_poses = np.ones(self.sensors, dtype=np.bool_)
        by_poses[list(self.assumed)] = False
        by_poses[list(errors)] = False
        if self.method == "poses" and by_poses.any():
            skew, wobble = np.abs(found.skew_deg[by_poses]).max(), found.wobble_deg[by_poses].max()
            told = f": axes within {skew:.1f} deg of their angle, flexion within {wobble:.1f} deg of one axis"
        state.rotations[by_poses] = rotations[by_poses]
        state.passing[:] = by_poses
        state.passing[list(self.assumed)] = True
        state.settled = True
        if by_poses.any():
            tick.report("calibrated", f"{by_poses.sum()} of {self.sensors} sensors by poses{told}")

    def _known_directions(self) -> tuple[Array, Array]:
        """Direction upwards in the flat pose and axis of flexion, in the segments' frames, (n, 3) each."""
        return (directions(self.verticals, dorsal(self.side), self.sensors, "verticals"),
                directions(self.axes, FLEXION, self.sensors, "axes"))

    def _window_ns(self, name: str) -> tuple[int, int]:
        begin, end = (duration_ns(second, NS_PER_S, name) for second in getattr(self, name))
        if not begin < end:
            raise InputError(name, f"{getattr(self, name)}", "begin before end, s")
        return begin, end


@compiled
def turn_samples(rotations: Any, passing: Any, gyr: Any, acc: Any, mag: Any) -> tuple[Any, Any, Any]:
    """Rotate three kinds of samples (n, 3) by quaternions (n, 4); NaN where not `passing` (n,)."""
    rows = np.full((3, passing.size, 3), np.nan)
    for i in range(passing.size):
        if passing[i]:
            q = (rotations[i, 0], rotations[i, 1], rotations[i, 2], rotations[i, 3])
            rows[0, i, 0], rows[0, i, 1], rows[0, i, 2] = turned(q, gyr[i, 0], gyr[i, 1], gyr[i, 2])
            rows[1, i, 0], rows[1, i, 1], rows[1, i, 2] = turned(q, acc[i, 0], acc[i, 1], acc[i, 2])
            rows[2, i, 0], rows[2, i, 1], rows[2, i, 2] = turned(q, mag[i, 0], mag[i, 1], mag[i, 2])
    return rows[0], rows[1], rows[2]
