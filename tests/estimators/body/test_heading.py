"""The first relative orientations from gravity and a joint's axes, against random joints."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from estimators.body.joint_constraints import BALL, HINGE, SADDLE
from estimators.constrained.beginning import ANY, ANY_SD, first_orientations
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


def away_from(true, found):
    """Angle of each of (h, 4) to `true`, rad."""
    return quaternion.rotation_angle(quaternion.relative(true, found))


@given(SEEDS)
@settings(deadline=None, max_examples=50)
def test_a_hinge_is_known_from_one_sample_unless_its_axis_is_upright(seed):
    axes, up, true = posed(HINGE, seed)
    found, sd = first_orientations(HINGE, axes, up, 0.1)
    level = math.sqrt(max(0.0, 1.0 - (axes[0] @ up[0] / 9.81) ** 2))
    if level > 0.2 + 1e-9:
        assert sd == pytest.approx(0.1 / level, rel=1e-6)
        assert away_from(true, found).tolist() == pytest.approx([0.0], abs=1e-5)
    else:
        assert (len(found), sd) == (ANY, ANY_SD)


@given(SEEDS, st.sampled_from([SADDLE, BALL]))
@settings(deadline=None, max_examples=50)
def test_the_true_heading_is_among_those_of_a_saddle_and_beside_those_of_a_ball(seed, kind):
    axes, up, true = posed(kind, seed)
    found, sd = first_orientations(kind, axes, up, 0.1)
    for each in found:
        np.testing.assert_allclose(quaternion.rotate(each, up[1]), up[0], atol=1e-6)
        if kind == SADDLE and len(found) == 2:
            assert axes[0] @ quaternion.rotate(each, axes[1]) == pytest.approx(0.0, abs=1e-6)
    nearest = away_from(true, found).min()
    assert nearest < (1e-5 if len(found) == 2 else math.pi / ANY + 1e-5)
    assert len(found) == 2 or (len(found), sd) == (ANY, ANY_SD)
    assert (np.diff(quaternion.rotation_angle(found)) >= 0.0).all()


def test_a_sensor_upside_down():
    up = np.array([[0.0, 0.0, 9.81], [0.0, 0.0, -9.81]])
    found, _ = first_orientations(HINGE, np.array([[1.0, 0.0, 0.0]] * 2), up, 0.1)
    np.testing.assert_allclose(np.abs(found), [[0.0, 1.0, 0.0, 0.0]], atol=1e-9)
