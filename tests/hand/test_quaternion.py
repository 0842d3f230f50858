"""Quaternion algebra against scipy's rotations and against its own definitions."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation, Slerp

from fesloop.hand import quaternion as q
from fesloop.hand import quaternion_kernels as kernels

angle = st.floats(-np.pi, np.pi)
seeds = st.integers(0, 2**32 - 1)


def random_rotations(seed, count=8):
    return Rotation.random(count, rng=np.random.default_rng(seed))


def wxyz(rotation):
    return rotation.as_quat(scalar_first=True)


def same_rotation(a, b):
    return np.allclose(np.abs(np.sum(a * b, axis=-1)), 1.0, atol=1e-12)


@given(seeds)
def test_algebra_equals_scipys(seed):
    a, b = random_rotations(seed), random_rotations(seed + 1)
    vectors = np.random.default_rng(seed).normal(size=(8, 3))
    assert same_rotation(q.multiply(wxyz(a), wxyz(b)), wxyz(a * b))
    assert same_rotation(q.relative(wxyz(a), wxyz(b)), wxyz(a.inv() * b))
    np.testing.assert_allclose(q.rotate(wxyz(a), vectors), a.apply(vectors), atol=1e-12)
    np.testing.assert_allclose(q.to_matrix(wxyz(a)), a.as_matrix(), atol=1e-12)
    np.testing.assert_allclose(q.rotation_angle(wxyz(a)), a.magnitude(), atol=1e-12)


@given(angle, st.floats(-1.5, 1.5), angle)
def test_intrinsic_euler_angles_equal_scipys(z, x, y):
    ours = q.from_euler_zxy(z, x, y)
    assert same_rotation(ours, wxyz(Rotation.from_euler("ZXY", [z, x, y])))
    np.testing.assert_allclose(np.exp(1j * q.euler_zxy(ours)), np.exp(1j * np.array([z, x, y])), atol=1e-9)


@given(angle, st.floats(0.0, 3.0), angle)
def test_heading_and_inclination_take_a_rotation_apart(heading, tilt, direction):
    axis = [np.cos(direction), np.sin(direction), 0.0]
    both = q.multiply(q.from_axis_angle(axis, tilt), q.about_z(heading))
    assert np.exp(1j * q.twist_z(both)) == pytest.approx(np.exp(1j * heading), abs=1e-9)
    assert q.tilt_z(both) == pytest.approx(tilt, abs=1e-9)
    up = q.rotate(both, [0.0, 0.0, 1.0])
    assert np.arccos(np.clip(up[2], -1.0, 1.0)) == pytest.approx(tilt, abs=1e-6)


@given(seeds)
def test_sign_of_a_quaternion_changes_no_angle(seed):
    some = wxyz(random_rotations(seed))
    for measure in (q.rotation_angle, q.twist_z, q.tilt_z):
        np.testing.assert_allclose(np.exp(1j * measure(some)), np.exp(1j * measure(-some)), atol=1e-12)


@pytest.mark.parametrize("name", ["conjugate", "rotation_angle", "twist_z", "tilt_z", "euler_z_of_zxy",
                                  "euler_x_of_zxy", "euler_y_of_zxy"])
def test_compiled_kernels_equal_plain_python(name):
    kernel = getattr(kernels, name)
    for row in wxyz(random_rotations(3)):
        np.testing.assert_allclose(kernel(tuple(row)), kernel.py_func(tuple(row)), rtol=1e-14, atol=1e-14)


def test_compiled_product_equals_plain_python():
    a, b = (tuple(row) for row in wxyz(random_rotations(4))[:2])
    np.testing.assert_allclose(kernels.multiply(a, b), kernels.multiply.py_func(a, b), rtol=1e-14)
    np.testing.assert_allclose(kernels.about_z(0.3), kernels.about_z.py_func(0.3), rtol=1e-14)


@given(seeds)
def test_interpolation_equals_scipys_slerp(seed):
    rotations = random_rotations(seed)
    times = np.cumsum(np.random.default_rng(seed).integers(1, 10**9, 8))
    at = np.sort(np.random.default_rng(seed + 7).integers(times[0], times[-1] + 1, 20))
    at[:2] = times[0], times[-1]
    expected = Slerp(times.astype(float), rotations)(at.astype(float))
    assert same_rotation(q.interpolate(times, wxyz(rotations), at), wxyz(expected))


def test_interpolation_does_not_extrapolate_nor_bridge_gaps():
    times = np.array([0, 10, 20, 30])
    rows = np.tile([1.0, 0.0, 0.0, 0.0], (4, 1))
    rows[2] = np.nan
    known = np.isfinite(q.interpolate(times, rows, np.array([-1, 0, 5, 10, 15, 25, 31]))).all(axis=1)
    assert known.tolist() == [False, True, True, True, False, False, False]


def test_normalized_has_length_one_and_gives_nan_for_zero():
    rows = np.array([[2.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0]])
    assert q.normalized(rows)[0].tolist() == [1.0, 0.0, 0.0, 0.0]
    assert np.isnan(q.normalized(rows)[1]).all()
