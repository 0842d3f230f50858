"""Dual quaternions against homogeneous matrices and their own definition."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from fesloop.hand import dual_quaternion as dual
from fesloop.hand import quaternion

seeds = st.integers(0, 2**32 - 1)


def drawn(seed):
    rng = np.random.default_rng(seed)
    return quaternion.normalized(rng.normal(size=(4, 4))), rng.normal(size=(4, 3))


def pose(seed):
    """Rotation, then translation along the turned axes: (4, 8) and (4, 4, 4)."""
    q, t = drawn(seed)
    turn, step = np.zeros((4, 4, 4)), np.tile(np.eye(4), (4, 1, 1))
    turn[:, :3, :3], turn[:, 3, 3], step[:, :3, 3] = quaternion.to_matrix(q), 1.0, t
    return dual.multiply(dual.rotation(q), dual.translation(t)), turn @ step


@given(seeds)
def test_products_and_inverses_equal_matrices(seed):
    (a, matrix_a), (b, matrix_b) = pose(seed), pose(seed + 1)
    points = np.random.default_rng(seed + 2).normal(size=(4, 3))
    for ours, matrix in ((dual.multiply(a, b), matrix_a @ matrix_b),
                         (dual.inverse(a), np.linalg.inv(matrix_a))):
        expected = np.einsum("tij,tj->ti", matrix[:, :3, :3], points) + matrix[:, :3, 3]
        np.testing.assert_allclose(dual.transform(ours, points), expected, atol=1e-12)
        np.testing.assert_allclose(dual.position(ours), matrix[:, :3, 3], atol=1e-12)
        turned = quaternion.to_matrix(dual.orientation(ours))
        np.testing.assert_allclose(turned, matrix[:, :3, :3], atol=1e-12)


@given(seeds)
def test_both_unity_conditions_survive_products(seed):
    product = dual.multiply(pose(seed)[0], pose(seed + 1)[0])
    real, dual_part = product[:, :4], product[:, 4:]
    np.testing.assert_allclose(np.linalg.norm(real, axis=1), 1.0, atol=1e-12)
    np.testing.assert_allclose(np.sum(real * dual_part, axis=1), 0.0, atol=1e-12)


@given(seeds)
def test_transforming_a_point_is_the_sandwich_of_equation_13(seed):
    some = pose(seed)[0]
    point = np.random.default_rng(seed).normal(size=(4, 3))
    as_dual = np.concatenate([np.tile([1.0, 0.0, 0.0, 0.0, 0.0], (4, 1)), point], axis=1)
    other = dual.inverse(some)
    other[:, 4:] *= -1.0
    sandwich = dual.multiply(dual.multiply(some, as_dual), other)
    np.testing.assert_allclose(sandwich[:, 5:], dual.transform(some, point), atol=1e-12)
    np.testing.assert_allclose(sandwich[:, :5], [[1.0, 0.0, 0.0, 0.0, 0.0]] * 4, atol=1e-12)


def test_equation_16_written_out():
    angle, length = 0.7, 0.03
    axis, along = np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0])
    ours = dual.multiply(dual.rotation(quaternion.about_z(angle)), dual.translation(length * along))
    sine, cosine = np.sin(0.5 * angle), np.cos(0.5 * angle)
    vector = 0.5 * length * (cosine * along + sine * np.cross(axis, along))
    np.testing.assert_allclose(ours, [cosine, 0.0, 0.0, sine, 0.0, *vector], atol=1e-15)
