"""Rates beyond a gyroscope's range: what they miss is reported, and is part of the sds."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tracker_parts import RATE, run_tracker

from estimators.arrivals import CLIPPED, LOST, Overrun
from estimators.constrained import ConstrainedTracker
from estimators.salchow import SalchowM2
from fesloop.hand.segments import Segment
from fesloop.loop.block import Tick

EXCESS = np.radians(500.0)
PAIR = (Segment(name="a", offset=(0.0, 0.05, 0.0)),
        Segment(name="b", parent="a", joint="hinge", joint_name="ab", offset=(0.0, 0.04, 0.0)))


@settings(deadline=None)
@given(st.lists(st.tuples(st.integers(0, 2), st.integers(1, 5)), max_size=6))
def test_each_sensor_is_reported_once_after_the_movement_that_cost_it_12_deg(bursts):
    overrun, tick, missed, expected = Overrun(3, EXCESS), Tick(), np.zeros(3), set()
    for sensor, ticks in bursts:
        codes = np.zeros((3, 3), dtype=np.uint8)
        codes[0, sensor] = CLIPPED
        codes[1] = CLIPPED | LOST  # accelerations do not count
        for _ in range(ticks):
            overrun.note(codes, 0.01, tick)
        missed[sensor] += 5.0 * ticks
        before = len(tick.reports)
        overrun.note(np.zeros((3, 3), dtype=np.uint8), 0.01, tick)
        new = set(np.flatnonzero(missed > 12.0)) - expected
        expected |= new
        assert len(tick.reports) - before == bool(new)
        if new:
            assert tick.reports[-1][0] == "rates_beyond_range"
            assert f"gyr of sensor {sensor} can" in tick.reports[-1][1]


@pytest.mark.parametrize("kind", [SalchowM2, ConstrainedTracker])
def test_a_joint_that_snaps_beyond_the_range_is_reported_and_has_a_larger_sd(kind):
    """A hinge turns about the vertical, by 90 deg at 3000 deg/s, measured by gyroscopes of 2000 deg/s."""
    rate = np.zeros(400)
    rate[200:203] = 3000.0
    errors, sds = [], []
    for limit in (4000.0, 2000.0):
        gyr, acc = np.zeros((400, 2, 3)), np.tile([0.0, 0.0, 9.81], (400, 2, 1))
        gyr[:, 1, 2] = np.radians(rate)
        rng = np.random.default_rng(1)
        gyr = np.minimum(gyr + 5e-4 * rng.normal(size=gyr.shape), np.radians(limit))
        tracker = kind(sensors=2, segments=PAIR, initial_pose_s=1.0, gyr_range_deg_s=limit)
        outputs, reports, _ = run_tracker(tracker, gyr, acc + 0.04 * rng.normal(size=acc.shape))
        after = 200 + RATE // 10
        errors.append(abs(np.degrees(outputs[1][after, 0]) - 90.0))
        sds.append(np.degrees(outputs[2][after, 0]))
        assert ("rates_beyond_range" in dict(reports)) == (limit < 3000.0)
    assert errors[0] < 10.0
    assert errors[1] > 20.0
    assert errors[1] < 2.5 * sds[1]
    assert sds[1] > sds[0] + 5.0
