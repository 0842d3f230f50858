"""Tilts of hinges' axes from neighbouring accelerometers, against sensors turned by known rotations."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tracker_parts import run_tracker
from worn_parts import Worn, WornHand

from estimators.kortier import KortierTracker
from estimators.kortier.tilts import compare_along_hinges, mounting_scale, new_tilts
from fesloop.hand import quaternion
from fesloop.hand.segments import Segment
from fesloop.loop.block import Context
from fesloop.loop.clock import RateClock

ACROSS, AXIS = np.eye(3)[:2], np.eye(3)[2]
ELBOW = (Segment(name="upper"),
         Segment(name="lower", parent="upper", joint="hinge", joint_name="elbow", offset=(0.0, -0.2, 0.0)))
LONG_S = 1.0
"""Time between samples, in which the errors of soft tissue are new ones."""


def elbow(**ways):
    """Tracker of one hinge, about z, and its state."""
    tracker = KortierTracker(sensors=2, segments=ELBOW, magnetometers=False, **ways)
    state = tracker.init(Context("tracker", clock=RateClock.from_rate(100)))
    state.filters.seen[:] = True
    state.moment.acc_variance[:] = tracker.acc_sd ** 2
    return tracker, state


def compare(tracker, state, acc):
    """Compare samples (n, 2, 3) one after the other."""
    for sample in acc:
        state.moment.acc[:] = sample
        compare_along_hinges(tracker.worn.chains, state.filters.seen, state.moment, LONG_S, LONG_S,
                             tracker.settings.trust, tracker.settings.gates, state.tilts)


def still(rng, count, turns):
    """Accelerations (count, 2, 3) in postures at rest; `turns` (2, 3), rad, of sensors on segments."""
    up = quaternion.normalized(rng.normal(size=(count, 4)))
    bent = quaternion.about_z(rng.uniform(0.0, 1.5, count))
    f_p = quaternion.rotate(up, [0.0, 0.0, 9.81])
    f_c = quaternion.rotate(quaternion.conjugate(bent), f_p)
    turns = turns + 1e-15
    sensors = quaternion.from_axis_angle(turns, np.linalg.norm(turns, axis=1))
    return quaternion.rotate(quaternion.conjugate(sensors), np.stack([f_p, f_c], axis=1))


@given(st.integers(0, 2**32 - 1))
@settings(deadline=None, max_examples=15)
def test_tilts_are_those_of_the_turned_sensors(seed):
    rng = np.random.default_rng(seed)
    turns = np.radians(2.0) * rng.uniform(-1.0, 1.0, size=(2, 3))
    tracker, state = elbow(constraint_sd_deg=0.01)
    compare(tracker, state, still(rng, 200, turns))
    # A sensor turned by v sees an axis turned by -v.
    parent, child = -np.cross(turns, AXIS) @ ACROSS.T
    expected = np.concatenate([0.5 * (parent + child), child - parent])
    np.testing.assert_allclose(np.degrees(state.tilts.mean[0]), np.degrees(expected), atol=0.25)


@given(st.integers(0, 2**32 - 1))
@settings(deadline=None, max_examples=15)
def test_tilts_and_their_covariance_are_those_of_least_squares(seed):
    rng = np.random.default_rng(seed)
    tracker, state = elbow()
    stated = state.tilts.covariance[0].copy()
    m, t = math.radians(tracker.mounting_sd_deg) ** 2, math.radians(tracker.axis_sd_deg) ** 2
    np.testing.assert_allclose(stated, np.diag([t + 0.5 * m, t + 0.5 * m, 2.0 * m, 2.0 * m]), rtol=1e-12)
    acc = still(rng, 20, np.zeros((2, 3))) + 0.02 * rng.normal(size=(20, 2, 3))
    compare(tracker, state, acc)
    rows = np.hstack([(acc[:, 0] - acc[:, 1]) @ ACROSS.T, -0.5 * (acc[:, 0] + acc[:, 1]) @ ACROSS.T])
    tissue = math.radians(tracker.constraint_sd_deg) ** 2 * np.sum(acc[:, 0] ** 2, axis=1)
    weights = 1.0 / (2.0 * tracker.acc_sd ** 2 + tissue)
    covariance = np.linalg.inv(np.linalg.inv(stated) + (weights[:, None] * rows).T @ rows)
    np.testing.assert_allclose(state.tilts.covariance[0], covariance, rtol=1e-8, atol=1e-14)
    mean = covariance @ rows.T @ (weights * (acc[:, 1] - acc[:, 0])[:, 2])
    np.testing.assert_allclose(state.tilts.mean[0], mean, rtol=1e-8, atol=1e-12)


@pytest.mark.parametrize("fault", ["unseen", "lost", "fast", "unlike"])
def test_accelerations_that_fail_a_gate_show_nothing(fault):
    rng = np.random.default_rng(2)
    tracker, state = elbow()
    acc = still(rng, 5, np.zeros((2, 3)))
    if fault == "unseen":
        state.filters.seen[0] = False
    elif fault == "lost":
        state.moment.acc_variance[1] = math.inf
    elif fault == "fast":
        state.moment.rates[0, 1] = 1.1 * tracker.rate_limit
    else:
        acc[:, 1] *= 1.1
    compare(tracker, state, acc)
    assert (state.tilts.mean == 0.0).all()
    stated = new_tilts(tracker.worn.chains, tracker.worn.wrong).covariance
    np.testing.assert_array_equal(state.tilts.covariance, stated)


@pytest.mark.parametrize("true", [0.2, 1.0, 2.0])
def test_mounting_is_as_wrong_as_its_tilts_show(true):
    """Ten hinges with tilts of `true` times the stated sd, some of them seen to a hundredth of its square."""
    tracker = KortierTracker(sensors=17, magnetometers=False)
    state = tracker.init(Context("tracker", clock=RateClock.from_rate(100)))
    chains, wrong, tilts = tracker.worn.chains, tracker.worn.wrong, state.tilts
    assert mounting_scale(chains, wrong, tilts) == pytest.approx(1.0)
    # Half of a strip's mounting is common to its sensors: 25 + 3/4 25 and 25 deg^2.
    sds = np.radians(np.sqrt([43.75, 43.75, 25.0, 25.0]))
    hinges = np.flatnonzero(chains.freedoms == 1)
    assert len(hinges) == 10
    for count, k in enumerate(hinges, start=1):
        tilts.mean[k], tilts.covariance[k] = true * sds, 0.01 * np.diag(sds ** 2)
        expected = (2.0 + 4.0 * count * true ** 2) / (2.0 + 4.0 * count * 0.99)
        assert mounting_scale(chains, wrong, tilts) == pytest.approx(expected)
    tilts.mean[chains.freedoms > 1] = 10.0
    assert mounting_scale(chains, wrong, tilts) == pytest.approx(expected)


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.2, 1.0])
def test_a_hand_with_turned_sensors_and_tilted_joints_has_the_scale_of_both(share):
    hand = WornHand(3, Worn(mounting_deg=5.0 * share, axes_deg=5.0 * share, acc_bias=0.0))
    gyr, acc, _, _ = hand.chunk(0, 4000)
    tracker = KortierTracker(sensors=17, magnetometers=False)
    _, _, state = run_tracker(tracker, gyr, acc)
    squares, names = 0.0, hand.nominal.names
    for segment, name in zip(hand.tree.segments, names, strict=True):
        if segment.joint == "hinge":
            both = [names.index(segment.parent), names.index(name)]
            parent, child = quaternion.rotate(quaternion.conjugate(hand.mounting[both]),
                                              np.array(segment.axes[0]))[:, :2]
            squares += np.sum((0.5 * (parent + child)) ** 2 / np.radians(1.0) ** 2 / 43.75)
            squares += np.sum((child - parent) ** 2 / np.radians(1.0) ** 2 / 25.0)
    expected = (2.0 + squares) / 42.0
    print(f"{share}: true {expected:.3f}, found {state.scale:.3f}")
    assert state.scale == pytest.approx(expected, rel=0.25)
