"""Frames aligned by eq. 29 and by what both have seen, against dual quaternions and known motions."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from estimators.calibration.frame_alignment import align_directions, align_points, alignment
from fesloop.errors import InputError
from fesloop.hand import dual_quaternion, quaternion

SEEDS = st.integers(0, 2**32 - 1)


def drawn(seed):
    """A rotation (4,), an origin (3,), and points (12, 3) in frame a and in frame b."""
    rng = np.random.default_rng(seed)
    turn, origin, in_a = Rotation.random(rng=rng), rng.normal(size=3), rng.normal(size=(12, 3))
    return turn.as_quat(scalar_first=True), origin, in_a, turn.apply(in_a - origin)


@settings(deadline=None, max_examples=25)
@given(SEEDS)
def test_a_known_motion_is_found_by_points(seed):
    turn, origin, in_a, in_b = drawn(seed)
    found = align_points(in_a, in_b)
    assert quaternion.rotation_angle(quaternion.relative(found.rotation, turn)) < 1e-7
    np.testing.assert_allclose(found.origin, origin, atol=1e-9)
    np.testing.assert_allclose(found.points(in_a), in_b, atol=1e-9)
    assert found.rms < 1e-9


@settings(deadline=None, max_examples=25)
@given(SEEDS)
def test_a_known_rotation_is_found_by_directions(seed):
    turn, _, in_a, _ = drawn(seed)
    rng = np.random.default_rng(seed)
    found = align_directions(in_a, 3.0 * quaternion.rotate(turn, in_a))
    assert quaternion.rotation_angle(quaternion.relative(found.rotation, turn)) < 1e-7
    noisy = quaternion.rotate(turn, in_a) + 0.01 * rng.normal(size=in_a.shape) * np.linalg.norm(
        in_a, axis=1, keepdims=True)
    found = align_directions(in_a, noisy)
    assert quaternion.rotation_angle(quaternion.relative(found.rotation, turn)) < 0.05
    assert 0.005 < found.rms < 0.03


def test_equation_29_is_a_translation_and_then_a_rotation():
    turn, origin, in_a, in_b = drawn(1)
    motion = dual_quaternion.multiply(dual_quaternion.rotation(turn), dual_quaternion.translation(-origin))
    found = alignment(turn, origin)
    np.testing.assert_allclose(found.points(in_a), in_b, atol=1e-12)
    np.testing.assert_allclose(found.points(in_a), dual_quaternion.transform(motion, in_a), atol=1e-12)
    np.testing.assert_allclose(found.points(origin), 0.0, atol=1e-12)
    poses = quaternion.normalized(np.ones((2, 4)))
    np.testing.assert_allclose(found.orientations(poses), quaternion.multiply(turn, poses))


def test_what_is_unknown_or_weighs_nothing_is_left_out():
    turn, _, in_a, in_b = drawn(2)
    in_b[3], in_a[4], in_b[5] = np.nan, np.nan, 7.0
    weights = np.ones(12)
    weights[5] = 0.0
    found = align_points(in_a, in_b, weights)
    assert quaternion.rotation_angle(quaternion.relative(found.rotation, turn)) < 1e-7


@pytest.mark.parametrize(("a", "b", "found"), [
    (np.eye(3)[[0, 0, 0]], np.eye(3)[[1, 1, 1]], "directions are parallel"),
    (np.ones((2, 3)), np.ones((3, 3)), r"shapes \(2, 3\) and \(3, 3\)"),
    (np.full((3, 3), np.nan), np.eye(3), "0 pairs are known"), (np.zeros((3, 3)), np.eye(3), "is zero"),
])
def test_what_fixes_no_rotation_is_refused(a, b, found):
    with pytest.raises(InputError, match=found):
        align_directions(a, b)


def test_misuse_is_named():
    line = np.outer(np.arange(5.0), [1.0, 2.0, 3.0])
    with pytest.raises(InputError, match="points lie on one line"):
        align_points(line, line)
    with pytest.raises(InputError, match="weights"):
        align_points(np.eye(3), np.eye(3), [1.0, -1.0, 1.0])
    with pytest.raises(InputError, match="rotation"):
        alignment([2.0, 0, 0, 0], [0, 0, 0])
    with pytest.raises(InputError, match="centre"):
        alignment([1.0, 0, 0, 0], [0, np.nan, 0])
