"""What the trackers of Salchow-Hoemmen et al. 2019 share: fusing, taking the initial pose, the posture."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.body.alignment import aligned_value
from estimators.body.body import UNSEEN_SD, Body
from estimators.calibration.initial_pose import (
    KEEP_STILL,
    NO_SAMPLE,
    faults,
    headings,
    known_angles,
    moved,
    sensor_name,
    ties_of,
)
from estimators.calibration.still_record import add_samples, rest_of
from estimators.salchow.kernels import find_seen, follow_gaps, posture
from estimators.salchow.method import InitialPose, Method
from estimators.salchow.state import SalchowState
from estimators.samples.faults import LOST
from fesloop.loop.block import Tick
from fesloop.loop.clock import NS_PER_S
from fesloop.loop.signals import Sample, Value

Array = NDArray[np.float64]
Outputs = tuple[Array, Array, Array, Array, Array, Array]


def track(state: SalchowState, body: Body, inputs: Sequence[Sample], tick: Tick) -> tuple[Value, ...]:
    """A tick of a tracker."""
    method = state.method
    ticks = tick.index + 1 - state.ticks
    state.ticks = tick.index + 1
    gyr_s, acc_s, mag_s = state.arrivals.note(inputs, tick)
    fresh = (gyr_s > 0.0, acc_s > 0.0, mag_s > 0.0)
    _fuse(state, method, inputs, fresh, ticks)
    fused = state.bank.orientation()
    if method.pose is not None and state.aligned_ns is None:
        if not _take_pose(state, body, method, method.pose, inputs, fresh, tick):
            _, angles, sd, tips, tip_sd, _ = _posture(state, body, method, state.known, 0.0, tick)
            if state.failing:
                sd[:] = UNSEEN_SD
            return fused, angles, sd, tips, tip_sd, aligned_value(False)
        fused = state.bank.orientation()
    elapsed_s = (tick.time_ns - (state.aligned_ns or 0)) / NS_PER_S
    return _posture(state, body, method, fused, elapsed_s, tick)


def _fuse(
    state: SalchowState, method: Method, inputs: Sequence[Sample], fresh: tuple[bool, bool, bool], ticks: int
) -> None:
    """Update the filters. They count time in samples: ticks skipped while busy are made good with these."""
    _, new_acc, new_mag = fresh
    gyr: Any = inputs[0].value
    acc: Any = inputs[1].value if new_acc else None
    mag: Any = inputs[2].value if new_mag else None
    codes = state.arrivals.codes
    lost = follow_gaps(codes, ticks * state.period_s, method.unseen_rate, state.forget, state.silent_s,
                       state.gaps)
    for _ in range(ticks):
        if not lost:
            state.bank.update(gyr, acc, mag)
            continue
        turning, forced, held = (codes & LOST) == 0
        state.bank.update_only(turning & forced & held, gyr, acc, mag)
        state.bank.update_only(turning & forced & ~held, gyr, acc, None)
        state.bank.update_only(turning & ~forced, gyr, None, None)


def _take_pose(
    state: SalchowState, body: Body, method: Method, pose: InitialPose, inputs: Sequence[Sample],
    fresh: tuple[bool, bool, bool], tick: Tick
) -> bool:
    """Go on with the initial pose; align where it is over: whether it is now."""
    if state.pose_ticks == 0 and not state.failing and state.quiet_ns < 0:
        tick.report("aligning", f"{KEEP_STILL} for {pose.duration_s:g} s")
        state.quiet_ns = tick.time_ns
    needed = max(2, math.ceil(pose.duration_s / state.period_s - 1e-9))
    gyr: Any = inputs[0].value
    acc: Any = inputs[1].value
    mag: Any = inputs[-1].value
    half = int(2 * state.pose_ticks >= needed)
    moving = add_samples(gyr, acc, mag, state.arrivals.codes, np.array(fresh), half,
                         math.radians(pose.limits.rate_deg_s), state.record)
    state.pose_ticks += 1
    if moving < 0 and state.pose_ticks < needed:
        return False
    if moving >= 0:
        found = [moved(body, moving, gyr[moving])]
    else:
        found = _align(state, body, method, pose, needed, tick)
    state.record.clear()
    state.pose_ticks, state.failing = 0, bool(found)
    if found and tick.time_ns >= state.quiet_ns:
        then = f"{'; '.join(found)}: {KEEP_STILL} for {pose.duration_s:g} s, the next that is still is taken"
        if found == [NO_SAMPLE]:
            tick.report("waiting", then)
        else:
            tick.report("initial_pose_failed", then)
        state.quiet_ns = tick.time_ns + round(pose.duration_s * NS_PER_S)
    return not found


def _align(
    state: SalchowState, body: Body, method: Method, pose: InitialPose, needed: int, tick: Tick
) -> list[str]:
    """Set biases and headings by a pose that is over; or why not."""
    rest = rest_of(state.record, method.magnetometer)
    ties = state.ties
    if not rest.present.all():
        ties = ties_of(body, known_angles(body.tree, pose.angles_deg), rest.present)
    found = faults(state.record, rest, body, ties, pose.limits, needed)
    if found:
        return found
    state.bank.begin(rest.present, rest.bias, rest.acc, rest.mag, needed)
    turn = 0.5 * headings(ties, state.bank.orientation())
    state.headings[:, 0], state.headings[:, 1] = np.cos(turn), np.sin(turn)
    state.posed, state.aligned_ns = rest.present, tick.time_ns
    state.gaps[:] = 0.0
    left_out = ", ".join(sensor_name(body, int(s)) for s in np.flatnonzero(~rest.present))
    tick.report("aligned", f"without {left_out}: no sample" if left_out else "initial pose taken")
    return []


def _posture(
    state: SalchowState, body: Body, method: Method, fused: Array, elapsed_s: float, tick: Tick
) -> Outputs:
    tree = body.tree
    changed = find_seen(tree.layout, body.sensors, state.silent_s, state.posed, method.gap_s, state.seen)
    if changed or state.unseen is None:
        _report_unseen(state, body, tick)
    tilt = UNSEEN_SD if state.failing else method.mounting_sd
    heading = min(math.hypot(method.heading_sd, method.drift * elapsed_s), UNSEEN_SD)
    freedoms, tips = len(tree.ranges), len(body.tips)
    arrays = (np.empty((len(fused), 4)), np.empty(freedoms), np.empty(freedoms), np.empty((tips, 3)),
              np.empty((tips, 3)))
    posture(tree.layout, tree.geometry, tree.ranges, body.sensors, state.counted, body.tips, fused,
            state.headings, state.seen, method.constrained, tilt ** 2, heading ** 2, state.gaps, *arrays)
    if elapsed_s > 0.0:
        state.plausible.note(arrays[1], tick)
    return *arrays, aligned_value(True)


def _report_unseen(state: SalchowState, body: Body, tick: Tick) -> None:
    before = state.unseen or ()
    now = tuple(joint for joint, seen in zip(body.joints, state.seen, strict=True) if joint and not seen)
    state.unseen = now
    for status, these, others in (("unseen", now, before), ("seen", before, now)):
        changed = [joint for joint in these if joint not in others]
        if changed:
            tick.report(status, "joint " + ", ".join(changed))
