"""The first relative orientation from gravity and a joint's axes, against random joints."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from estimators.heading import UNKNOWN, first_orientation
from estimators.joint_constraints import BALL, HINGE, SADDLE
from fesloop.hand import quaternion

SEEDS = st.integers(0, 2**32 - 1)


def posed(kind, seed):
    """(axes, up in both frames, child to parent) of a joint in a random attitude."""
    rng = np.random.default_rng(seed)
    axis = rng.normal(size=3)
    axis /= np.linalg.norm(axis)
    other = axis if kind == HINGE else np.cross(axis, rng.normal(size=3))
    other = other / np.linalg.norm(other)
    true = quaternion.multiply(quaternion.from_axis_angle(axis, rng.uniform(-1, 1)),
                               quaternion.from_axis_angle(other, rng.uniform(-1, 1) * (kind != HINGE)))
    parent = quaternion.normalized(rng.normal(size=4))
    up = [quaternion.rotate(quaternion.conjugate(q), [0.0, 0.0, 9.81])
          for q in (parent, quaternion.multiply(parent, true))]
    return np.array([axis, other]), np.array(up), true


@given(SEEDS)
@settings(deadline=None, max_examples=50)
def test_a_hinge_is_known_from_one_sample(seed):
    axes, up, true = posed(HINGE, seed)
    found, sd = first_orientation(HINGE, axes, up, 0.1)
    level = math.sqrt(max(0.0, 1.0 - (axes[0] @ up[0] / 9.81) ** 2))
    assert sd == pytest.approx(min(0.1 / max(level, 1e-6), UNKNOWN), rel=1e-6)
    if level > 0.01:
        assert quaternion.rotation_angle(quaternion.relative(true, found)) < 1e-5


@given(SEEDS, st.sampled_from([SADDLE, BALL]))
@settings(deadline=None, max_examples=50)
def test_both_see_one_vertical_and_a_saddles_axes_are_perpendicular(seed, kind):
    axes, up, true = posed(kind, seed)
    found, sd = first_orientation(kind, axes, up, 0.1)
    assert sd == UNKNOWN
    np.testing.assert_allclose(quaternion.rotate(found, up[1]), up[0], atol=1e-6)
    if kind == SADDLE:
        assert axes[0] @ quaternion.rotate(found, axes[1]) == pytest.approx(0.0, abs=1e-6)
        assert quaternion.rotation_angle(found) <= quaternion.rotation_angle(true) + 1e-6


def test_a_sensor_upside_down():
    up = np.array([[0.0, 0.0, 9.81], [0.0, 0.0, -9.81]])
    found, _ = first_orientation(HINGE, np.array([[1.0, 0.0, 0.0]] * 2), up, 0.1)
    np.testing.assert_allclose(np.abs(found), [0.0, 1.0, 0.0, 0.0], atol=1e-9)
