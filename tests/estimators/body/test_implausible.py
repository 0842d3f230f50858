"""Angles that no joint can have are reported once, and those that joints have are not."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tracker_parts import run_tracker

from estimators.body.body import of_tree, of_unknown_joints
from estimators.constrained.block import ConstrainedTracker
from estimators.fusion.trackers import VqfTracker
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.skeleton import hand_tree
from fesloop.loop.block import Tick

TREE = hand_tree(HandSize())
MARGIN = math.radians(60.0)


def told(watch, angles, period_ns=10_000_000):
    """How often it reports, over rows of angles."""
    tick, found = Tick(), []
    for index, row in enumerate(angles):
        tick.index, tick.time_ns, tick.reports = index, index * period_ns, []
        watch.note(np.ascontiguousarray(row), tick)
        found += tick.reports
    assert all(status == "implausible_angle" for status, _ in found)
    return [detail for _, detail in found]


@given(freedom=st.integers(0, len(TREE.ranges) - 1), beyond_deg=st.floats(-59.0, 90.0), upwards=st.booleans(),
       turns=st.integers(-1, 1), ticks=st.integers(1, 120))
@settings(max_examples=100, deadline=None)
def test_what_is_far_beyond_a_range_for_long_is_reported_once(freedom, beyond_deg, upwards, turns, ticks):
    low, high = TREE.ranges[freedom]
    beyond = math.radians(beyond_deg)
    angle = high + beyond if upwards else low - beyond
    angles = np.zeros((200, len(TREE.ranges)))
    angles[:] = TREE.ranges.mean(axis=1)
    angles[20:20 + ticks, freedom] = angle + 2.0 * math.pi * turns
    from_other_side = (2.0 * math.pi - (high - low)) - beyond
    expected = beyond > MARGIN and from_other_side > MARGIN and ticks > 50
    if abs(beyond - MARGIN) > 1e-6 and abs(from_other_side - MARGIN) > 1e-6:
        found = told(of_tree(TREE), angles)
        assert len(found) == expected
        assert all(each.startswith(TREE.freedoms[freedom]) for each in found)


@given(speed_deg_s=st.floats(-900.0, 900.0), start_deg=st.floats(-90.0, 90.0))
@settings(max_examples=60, deadline=None)
def test_joints_of_unknown_range_may_not_turn_round(speed_deg_s, start_deg):
    true = np.radians(start_deg + speed_deg_s * 0.01 * np.arange(300))[:, np.newaxis]
    wrapped = (true + math.pi) % (2.0 * math.pi) - math.pi
    beyond = np.count_nonzero(np.abs(true) > math.pi)
    if abs(beyond - 51) > 1:
        assert len(told(of_unknown_joints(["joint 0-1"]), wrapped)) == (beyond > 51)


@pytest.mark.parametrize("tracker", [VqfTracker(sensors=2), ConstrainedTracker(
    sensors=2, sensed=("F2p", "F2m"))])
@pytest.mark.parametrize("wrong", [True, False])
def test_a_sensor_whose_accelerometer_is_negated_is_reported(tracker, wrong):
    times = 0.01 * np.arange(3000)
    gyr, acc = np.zeros((2, times.size, 2, 3))
    flexion = 0.6 * (1.0 - np.cos(2.0 * math.pi * 0.4 * times))
    tilt = 0.8 * np.sin(2.0 * math.pi * 0.15 * times)
    for sensor, angle in enumerate((tilt, tilt + flexion)):
        gyr[:, sensor, 2] = np.gradient(angle, 0.01)
        acc[:, sensor, :2] = 9.81 * np.column_stack([np.sin(angle), np.cos(angle)])
    if wrong:
        acc[:, 1] *= -1.0
    reports = run_tracker(tracker, gyr, acc)[1]
    assert ("implausible_angle" in str(reports)) == wrong
