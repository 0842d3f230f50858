"""The finger filter's kernels: Jacobians by finite differences, consistency on chains with known truth."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import chi2

from estimators.kortier import chain as kortier_finger
from estimators.kortier.work import (
    add_accelerations,
    add_constraints,
    add_field,
    error_size,
    fill_rotations,
    new_work,
)
from fesloop.hand import quaternion

JOINTS, DT = 3, 0.005
SIZE, TURNS = error_size(JOINTS), 3 * JOINTS
FREEDOMS = np.array([2, 1, 1])
AXES = np.tile([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], (JOINTS, 1, 1))
STEP = 1e-6


def turned(vectors):
    """Quaternions of rotation vectors (..., 3), by their closed form."""
    angle = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.concatenate([np.cos(0.5 * angle), 0.5 * np.sinc(0.5 * angle / np.pi) * vectors], axis=-1)


def rotation_vector(q):
    """Rotation vectors (..., 3) of quaternions."""
    q = np.where(q[..., :1] < 0.0, -q, q)
    length = np.linalg.norm(q[..., 1:], axis=-1, keepdims=True)
    ratio = np.divide(2.0 * np.arctan2(length, q[..., :1]), length, out=np.full_like(length, 2.0),
                      where=length > 0.0)
    return ratio * q[..., 1:]


def displaced(q, bias, error):
    """The state that lies `error` away from an estimate."""
    return (quaternion.multiply(q, turned(error[:TURNS].reshape(-1, 3))), bias + error[TURNS:].reshape(-1, 3))


def error_of(q, bias, true_q, true_bias):
    """How far the truth lies from an estimate, (size,)."""
    turns = rotation_vector(quaternion.relative(q, true_q))
    return np.concatenate([turns.ravel(), (true_bias - bias).ravel()])


def carried(q, bias, rates, dt):
    """The motion itself: attitudes of segments in a frame of their own, each turned by its rate."""
    steps = turned((rates - bias) * dt)
    return quaternion.multiply(quaternion.multiply(quaternion.conjugate(steps[:-1]), q), steps[1:])


def differences(function, size, out):
    """Central differences of a function of a vector that is about zero, (out, size)."""
    columns = [(function(STEP * unit) - function(-STEP * unit)) / (2 * STEP) for unit in np.eye(size)]
    return np.stack(columns, axis=1).reshape(out, size)


def random_chain(seed):
    rng = np.random.default_rng(seed)
    q = quaternion.normalized(rng.normal(size=(JOINTS, 4)))
    bias = 0.1 * rng.normal(size=(JOINTS + 1, 3))
    root = rng.normal(size=(SIZE, SIZE))
    return rng, q, bias, root @ root.T


@given(st.integers(0, 2**32 - 1), st.sampled_from([0.005, 0.05]))
@settings(deadline=None, max_examples=20)
def test_prediction_against_finite_differences_cross_terms_included(seed, dt):
    rng, q, bias, covariance = random_chain(seed)
    rates = rng.normal(scale=8.0, size=(JOINTS + 1, 3))
    gyr_variance = rng.uniform(0.1, 2.0, JOINTS + 1)
    after = carried(q, bias, rates, dt)

    def from_state(error):
        moved_q, moved_bias = displaced(q, bias, error)
        return error_of(after, bias, carried(moved_q, moved_bias, rates, dt), moved_bias)

    def from_noise(noise):
        return error_of(after, bias, carried(q, bias, rates - noise.reshape(-1, 3), dt), bias)

    transition = differences(from_state, SIZE, SIZE)
    noise = differences(from_noise, SIZE - TURNS, SIZE)
    expected = (transition @ covariance @ transition.T
                + noise @ np.diag(np.repeat(gyr_variance, 3)) @ noise.T)
    expected[TURNS:, TURNS:] += 0.3 * np.eye(SIZE - TURNS)
    given_q, given_covariance = q.copy(), covariance.copy()
    kortier_finger.predict(given_q, bias, given_covariance, rates, gyr_variance, 0.3, dt,
                           new_work(JOINTS))
    np.testing.assert_allclose(quaternion.rotation_angle(quaternion.relative(given_q, after)), 0.0, atol=1e-7)
    np.testing.assert_allclose(given_covariance, expected, atol=1e-6 * np.abs(expected).max())


def stacked(matrices, vectors):
    return np.einsum("kij,kj->ki", matrices, vectors)


@pytest.mark.slow
@given(st.integers(0, 2**32 - 1), st.integers(0, 7))
@settings(deadline=None, max_examples=20)
def test_accelerometer_rows_against_finite_differences_and_their_noise(seed, chosen):
    rng, q, bias, covariance = random_chain(seed)
    acc, variance = rng.normal(size=(JOINTS + 1, 3)), rng.uniform(0.1, 2.0, JOINTS + 1)
    used = np.array([bool(chosen & bit) for bit in (1, 2, 4)])

    def predicted(error):
        return stacked(quaternion.to_matrix(displaced(q, bias, error)[0]), acc[1:])[used].ravel()

    rotation = quaternion.to_matrix(q)
    design = differences(predicted, SIZE, 3 * used.sum())
    from_noise = np.zeros((3 * JOINTS, 3 * (JOINTS + 1)))
    for k in range(JOINTS):
        from_noise[3 * k:3 * k + 3, 3 * k:3 * k + 3] = np.eye(3)
        from_noise[3 * k:3 * k + 3, 3 * k + 3:3 * k + 6] = -rotation[k]
    noise = (from_noise @ np.diag(np.repeat(variance, 3)) @ from_noise.T)[np.ix_(*[np.repeat(used, 3)] * 2)]
    residual = (acc[:-1] - stacked(rotation, acc[1:]))[used].ravel()
    work = new_work(JOINTS)
    fill_rotations(q, work)
    count = add_accelerations(acc, acc, variance, used, 0, work)
    assert_absorbed_as_textbook(q, bias, covariance, design, residual, noise, count, work)


@given(st.integers(0, 2**32 - 1))
@settings(deadline=None, max_examples=10)
def test_magnetometer_rows_against_finite_differences(seed):
    rng, q, bias, covariance = random_chain(seed)
    base, tip = rng.normal(size=(2, 3))

    def predicted(error):
        a, b, c = quaternion.to_matrix(displaced(q, bias, error)[0])
        return a @ b @ c @ tip

    work = new_work(JOINTS)
    fill_rotations(q, work)
    count = add_field(base, tip, JOINTS, 0.7, 0, work)
    assert_absorbed_as_textbook(q, bias, covariance, differences(predicted, SIZE, 3),
                                base - predicted(np.zeros(SIZE)), 0.7 * np.eye(3), count, work)


@given(st.integers(0, 2**32 - 1), st.tuples(*[st.integers(0, 3)] * JOINTS))
@settings(deadline=None, max_examples=20)
def test_constraint_rows_of_tilted_axes_against_finite_differences(seed, freedoms):
    rng, q, bias, covariance = random_chain(seed)
    axes = np.ascontiguousarray(quaternion.to_matrix(quaternion.normalized(rng.normal(size=(JOINTS, 4)))))

    def forbidden(error):
        """Entries of each rotation in its joint's frame of abduction, pronation and flexion."""
        turn = quaternion.to_matrix(displaced(q, bias, error)[0])
        in_joint = axes[:, [1, 2, 0]] @ turn @ np.swapaxes(axes[:, [1, 2, 0]], 1, 2)
        return np.array([m[at] for m, free in zip(in_joint, freedoms, strict=True)
                         for at in ((2, 0), (2, 1), (0, 1))[:3 - free]])

    work = new_work(JOINTS)
    fill_rotations(q, work)
    count = add_constraints(np.array(freedoms), axes, 0.2, 0, work)
    rows = 3 * JOINTS - sum(freedoms)
    assert_absorbed_as_textbook(q, bias, covariance, differences(forbidden, SIZE, rows),
                                -forbidden(np.zeros(SIZE)), 0.2 * np.eye(rows), count, work)


@given(st.integers(0, 2**32 - 1))
@settings(deadline=None, max_examples=20)
def test_sparse_steps_are_the_dense_ones_to_round_off(seed):
    """F P F' + Q, and all rows at once in Joseph's form, written out in full."""
    rng, q, bias, covariance = random_chain(seed)
    work, variance = new_work(JOINTS), rng.uniform(0.1, 2.0, JOINTS + 1)
    after = 0.5 * (covariance + covariance.T)
    before = after.copy()
    kortier_finger.predict(q, bias, after, rng.normal(size=(JOINTS + 1, 3)), variance, 0.3, DT, work)
    transition, noise = np.eye(SIZE), np.zeros((SIZE, SIZE - TURNS))
    for k in range(JOINTS):
        at = slice(3 * k, 3 * k + 3)
        transition[at, at] = work.step[k + 1]
        noise[at, 3 * k:3 * k + 3], noise[at, 3 * k + 3:3 * k + 6] = work.of_parent[k], work.of_child[k]
    transition[:, TURNS:] += noise
    walk = np.diag([0.0] * TURNS + [0.3] * (SIZE - TURNS))
    expected = transition @ before @ transition.T + noise @ np.diag(np.repeat(variance, 3)) @ noise.T + walk
    np.testing.assert_allclose(after, expected, atol=1e-12 * np.abs(expected).max())
    np.testing.assert_array_equal(after, after.T)
    count = add_accelerations(*rng.normal(size=(2, JOINTS + 1, 3)), variance, np.ones(JOINTS, bool), 0, work)
    count = add_constraints(FREEDOMS, AXES, 0.2, count, work)
    design = np.hstack([np.where((np.arange(TURNS) >= work.span[:count, :1])
                                 & (np.arange(TURNS) < work.span[:count, 1:]), work.design[:count], 0.0),
                        np.zeros((count, SIZE - TURNS))])
    spread = design @ after @ design.T + np.diag(work.variance[:count])
    gain = np.linalg.solve(spread, design @ after).T
    rest = np.eye(SIZE) - gain @ design
    expected = rest @ after @ rest.T + gain @ np.diag(work.variance[:count]) @ gain.T
    kortier_finger.correct(q, bias, after, count, work)
    np.testing.assert_allclose(after, expected, atol=1e-12 * np.abs(before).max())
    np.testing.assert_array_equal(after, after.T)
    np.testing.assert_allclose(work.error, gain @ work.residual[:count], atol=1e-10)


def assert_absorbed_as_textbook(q, bias, covariance, design, residual, noise, count, work):
    """What `correct` makes of its rows is the Kalman update with the full noise covariance."""
    assert count == len(residual)
    spread = design @ covariance @ design.T + noise
    gain = np.linalg.solve(spread, design @ covariance).T if count else np.zeros((SIZE, 0))
    rest = np.eye(SIZE) - gain @ design
    expected = rest @ covariance @ rest.T + gain @ noise @ gain.T
    moved = displaced(q, bias, gain @ residual)
    given_q, given_bias, given_covariance = q.copy(), bias.copy(), covariance.copy()
    nis = kortier_finger.correct(given_q, given_bias, given_covariance, count, work)
    np.testing.assert_allclose(given_covariance, expected, atol=1e-6 * np.abs(covariance).max())
    np.testing.assert_allclose(error_of(given_q, given_bias, *moved), 0.0, atol=1e-5)
    assert nis == pytest.approx(residual @ np.linalg.solve(spread, residual) if count else 0.0, rel=1e-5)


def test_tight_constraints_leave_a_sound_covariance():
    """Table 1's constraint sd of 1e-5 deg, for ten thousand corrections."""
    q = np.tile([1.0, 0.0, 0.0, 0.0], (JOINTS, 1))
    bias, covariance = np.zeros((JOINTS + 1, 3)), np.diag([0.1] * TURNS + [1e-4] * (SIZE - TURNS))
    work = new_work(JOINTS)
    rates = np.array([[0.3, 0.1, 0.2], [0.3, 0.1, 1.2], [0.3, 0.1, 2.2], [0.3, 0.1, 3.2]])
    for _ in range(10_000):
        kortier_finger.predict(q, bias, covariance, rates, np.full(4, 2.5e-7), 5e-11, DT, work)
        count = add_constraints(FREEDOMS, AXES, np.radians(1e-5) ** 2, 0, work)
        kortier_finger.correct(q, bias, covariance, count, work)
    np.testing.assert_array_equal(covariance, covariance.T)
    assert np.linalg.eigvalsh(covariance).min() > 0.0
    assert np.abs(quaternion.to_matrix(q)[1:, 2, :2]).max() < 1e-6


GYR_SD, WALK_SD, ACC_SD, MAG_SD, LAXITY = 5e-4, 1e-4, 4e-2, 3e-7, np.radians(1.0)
ANGLE_SD, BIAS_SD = np.radians(3.0), 0.01
FIELD, TICKS, RUNS = np.array([0.0, 20e-6, -44e-6]), 1000, 50


def simulated_chain(rng):
    """A hand that turns and shakes with a finger that moves: true (q, bias) and what its sensors read.

    Joints give by LAXITY, anew at each accelerometer's sample, and gyroscopes see it: they read the mean
    rate over the step before. All segments share the hand's acceleration, as the filter takes for granted.
    """
    times = DT * np.arange(TICKS + 1)
    wave = np.sin(2 * np.pi * rng.uniform(0.2, 1.0, 9)[:, None] * times + rng.uniform(0, 6, 9)[:, None])
    hand = quaternion.multiply(quaternion.normalized(rng.normal(size=4)),
                               quaternion.from_euler_zxy(*(0.8 * wave[:3])))
    flexion = np.radians(40.0) * (1.0 + wave[3:6])
    joints = np.stack([quaternion.from_euler_zxy(f, a, 0.0) for f, a in
                       zip(flexion, (0.3 * wave[6], 0 * times, 0 * times), strict=True)], axis=1)
    slack = rng.normal(scale=(LAXITY, LAXITY, 0.0), size=(TICKS // 2 + 1, JOINTS, 3))
    q = quaternion.multiply(turned(np.repeat(slack, 2, axis=0)[1:]), joints)
    attitude = [hand]
    for k in range(JOINTS):
        attitude.append(quaternion.multiply(attitude[-1], q[:, k]))
    attitude = np.stack(attitude, axis=1)
    rates = rotation_vector(quaternion.relative(attitude[:-1], attitude[1:])) / DT
    bias = BIAS_SD * rng.normal(size=(JOINTS + 1, 3)) + np.cumsum(
        WALK_SD * np.sqrt(DT) * rng.normal(size=(TICKS + 1, JOINTS + 1, 3)), axis=0)
    force = np.array([0.0, 0.0, 9.81]) + 3.0 * np.stack([wave[7], wave[8], wave[6]], axis=1)
    inverse = quaternion.conjugate(attitude)
    acc = quaternion.rotate(inverse, force[:, None]) + ACC_SD * rng.normal(size=(*attitude.shape[:2], 3))
    mag = quaternion.rotate(inverse, FIELD) + MAG_SD * rng.normal(size=(*attitude.shape[:2], 3))
    gyr = rates + bias[:-1] + GYR_SD * rng.normal(size=rates.shape)
    return q, bias, gyr, acc, mag


def filtered(rng):
    """One run of the filter: (NEES, NIS, rows) at each correction."""
    true_q, true_bias, gyr, acc, mag = simulated_chain(rng)
    q = quaternion.multiply(true_q[0], turned(ANGLE_SD * rng.normal(size=(JOINTS, 3))))
    bias = np.zeros((JOINTS + 1, 3))
    covariance = np.diag([ANGLE_SD**2] * TURNS + [BIAS_SD**2] * (SIZE - TURNS))
    work = new_work(JOINTS)
    gyr_variance, acc_variance = np.full(JOINTS + 1, GYR_SD**2), np.full(JOINTS + 1, ACC_SD**2)
    every_pair = np.ones(JOINTS, dtype=np.bool_)
    seen = []
    for k in range(1, TICKS + 1):
        kortier_finger.predict(q, bias, covariance, gyr[k - 1], gyr_variance, WALK_SD**2 * DT, DT, work)
        if k % 2 == 0:
            count = add_accelerations(acc[k], acc[k], acc_variance, every_pair, 0, work)
            count = add_field(mag[k, 0], mag[k, -1], JOINTS, 2 * MAG_SD**2, count, work)
            count = add_constraints(FREEDOMS, AXES, LAXITY**2, count, work)
            nis = kortier_finger.correct(q, bias, covariance, count, work)
            error = error_of(q, bias, true_q[k], true_bias[k])
            seen.append((error @ np.linalg.solve(covariance, error), nis, count))
    return np.array(seen).T


def bounds(runs, degrees):
    """95 % bounds of a mean over runs (Bar-Shalom et al. 2001, doi 10.1002/0471221279, section 5.4.2)."""
    return chi2.ppf([0.025, 0.975], runs * degrees) / runs


@pytest.mark.slow
def test_consistent_over_fifty_runs_when_all_is_as_modelled():
    runs = np.stack([filtered(np.random.default_rng(seed)) for seed in range(RUNS)])
    rows = int(runs[0, 2, 0])
    assert rows == 3 * JOINTS + 3 + 5
    for series, degrees in ((runs[:, 0], SIZE), (runs[:, 1], rows)):
        low, high = bounds(RUNS, degrees)
        mean = series.mean(axis=0)
        assert low < mean.mean() < high
        assert np.mean((mean > low) & (mean < high)) > 0.9
