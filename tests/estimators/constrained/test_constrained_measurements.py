"""Rows of the joint filters' measurements against finite differences of what they measure."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import chi2

from estimators.body.joint_constraints import Joint, joint_table
from estimators.constrained.agreement import COLUMNS, TURNED, forget_contradicted
from estimators.constrained.filter import SOUND, _spread, _turn, advance
from estimators.constrained.measurements import (
    BIAS,
    BIAS_WALK,
    LEVERS,
    PERIOD,
    SPACING,
    TILTS,
    TURN,
    N,
    axes_agree,
    shared_acceleration,
)
from fesloop.hand import quaternion

SEEDS = st.integers(0, 2**32 - 1)
STEP = 1e-6
SETTINGS = np.array([0.01, 0.01, 1e-4, 0.3, 0.03, 0.1, 0.07, 0.2, 0.1, 2.0, 0.01, 0.02, 9.0])
X, Z = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)
KINDS = {"hinge": Joint(parent=0, child=1, kind="hinge", parent_axis=(1.0, 2.0, 3.0), child_axis=Z),
         "saddle": Joint(parent=0, child=1, kind="saddle", parent_axis=Z, child_axis=X)}


def moved(q, s, i, step):
    """q and s with component i of the error state changed by `step`."""
    q, s = q.copy(), s.copy()
    if i < 3:
        q = quaternion.multiply(q, quaternion.from_axis_angle(np.eye(3)[i], step))
    else:
        s[i - 3 if i < TILTS else 13 + i - TILTS] += step
    return q, s


def differences(residual, q, s):
    """Derivative of a scalar of (q, s) by each component of the error state, (16,)."""
    return np.array([(residual(*moved(q, s, i, STEP)) - residual(*moved(q, s, i, -STEP))) / (2 * STEP)
                     for i in range(N)])


def state(seed):
    rng = np.random.default_rng(seed)
    s = np.zeros(17)
    s[:9], s[13:] = 0.1 * rng.normal(size=9), 0.1 * rng.normal(size=4)
    return rng, quaternion.normalized(rng.normal(size=4)), s


def row_of(measurement):
    """The last row that a measurement leaves in its array."""
    h = np.zeros(N)
    measurement(1e-6 * np.eye(N), np.zeros(N), h, np.empty(N))
    return h


@given(SEEDS, st.sampled_from(sorted(KINDS)))
@settings(deadline=None, max_examples=30)
def test_rows_of_the_axes(seed, kind):
    _, q, s = state(seed)
    table = joint_table((KINDS[kind],), 2)
    of = (table.kinds[0], table.axes[0], table.zero[0])
    h = row_of(lambda cov, x, h, gain: axes_agree(q, s, *of, cov, SETTINGS, x, h, gain))
    h[3:TILTS] = 0.0
    p, a = table.axes[0]

    def residual(q, s):
        if kind == "saddle":
            e, g = p, a
            f = k = np.cross(p, a)
        else:
            # The child's axis is z: x and y are equally far from it, and y is taken.
            e = np.cross(a, [0.0, 1.0, 0.0])
            f = np.cross(a, e)
            g, k = quaternion.rotate(table.zero[0], e), quaternion.rotate(table.zero[0], f)
        own = a + s[15] * e + s[16] * f
        v = quaternion.rotate(quaternion.conjugate(q), p + s[13] * g + s[14] * k)
        return own @ v if kind == "saddle" else f @ (v - own)

    np.testing.assert_allclose(h, differences(residual, q, s), atol=1e-7)


@given(SEEDS)
@settings(deadline=None, max_examples=30)
def test_rows_of_the_shared_acceleration(seed):
    rng, q, s = state(seed)
    gyr = rng.normal(size=(2, 2, 3))
    gyr[1] = gyr[0] + 0.05 * rng.normal(size=(2, 3))
    acc = np.array([0.0, 0.0, 9.81]) + rng.normal(size=(2, 2, 3))
    acc[1] = acc[0]
    w, change = gyr.mean(axis=0), (gyr[1] - gyr[0]) / SETTINGS[0]

    def at_centre(i, lever):
        return acc[0, i] - np.cross(change[i], lever) - np.cross(w[i], np.cross(w[i], lever))

    def residual(q, s):
        seen = quaternion.rotate(quaternion.conjugate(q), at_centre(0, s[3:6]))
        return -(seen - at_centre(1, s[6:9]))[2]

    # The force's mean is what is measured now, so that nothing of it is taken for noise.
    turn = SETTINGS[SPACING] * w[1]
    ahead = quaternion.from_axis_angle(turn, np.linalg.norm(turn))
    s[9:12] = quaternion.rotate(ahead, quaternion.rotate(quaternion.conjugate(q), at_centre(0, s[3:6])))
    h = row_of(lambda cov, x, h, gain: shared_acceleration(
        q, s.copy(), cov, gyr, acc, 0, 1, SETTINGS, x, h, gain, np.empty((2, 3, 3))))
    h[3:LEVERS] = 0.0
    h[TILTS:] = 0.0
    found = differences(residual, q, s)
    assert found[3:LEVERS] == pytest.approx(np.zeros(3))
    np.testing.assert_allclose(h, found, atol=1e-6)


@pytest.mark.slow
@given(SEEDS)
@settings(deadline=None, max_examples=20)
def test_the_covariance_moves_as_the_error_does(seed):
    """An error of q and b after a period, by moving a disturbed state beside the undisturbed one."""
    rng, q, s = state(seed)
    wp, wc, dt = rng.normal(size=3), rng.normal(size=3), 0.01
    transition = np.eye(N)
    after = q.copy()
    _turn(after, s, wp, wc, dt)
    for i in range(6):
        disturbed, biased = q.copy(), s.copy()
        if i < 3:
            disturbed = quaternion.multiply(q, quaternion.from_axis_angle(np.eye(3)[i], STEP))
        else:
            biased[i - 3] += STEP
        _turn(disturbed, biased, wp, wc, dt)
        error = quaternion.relative(after, disturbed)
        transition[:3, i] = 2.0 * error[1:] * np.sign(error[0]) / STEP
    root = rng.normal(size=(N, N))
    cov = root @ root.T
    expected = transition @ cov @ transition.T
    _spread(cov, s, wc, dt, 0.0, 0.0)
    np.testing.assert_allclose(cov, expected, atol=1e-3 * np.abs(expected).max())
    np.testing.assert_allclose(cov, cov.T, atol=1e-12 * np.abs(cov).max())


def test_the_covariance_of_what_is_not_measured_is_that_of_noise_drawn():
    """Two gyroscopes that stand still a joint, 1500 joints: both have white noise and a bias that walks."""
    rng, joints, steps, dt = np.random.default_rng(11), 1500, 200, 0.01
    balls = tuple(Joint(parent=2 * j, child=2 * j + 1, kind="ball") for j in range(joints))
    table, settings = joint_table(balls, 2 * joints), SETTINGS.copy()
    settings[[PERIOD, SPACING, TURN, BIAS_WALK, BIAS]] = dt, 1e6, 2e-3, 1e-3, 0.0
    true = quaternion.normalized(rng.normal(size=(joints, 4)))
    q, rest, covariance = true.copy(), np.zeros((joints, 17)), np.zeros((joints, N, N))
    seen, (gyr, acc) = np.full((2, 2 * joints), SOUND), np.zeros((2, 2, 2 * joints, 3))
    bias = np.zeros((2 * joints, 3))
    for k in range(1, steps + 1):
        bias += settings[BIAS_WALK] * np.sqrt(dt) * rng.normal(size=bias.shape)
        gyr = np.stack([gyr[1], bias + settings[TURN] / np.sqrt(dt) * rng.normal(size=bias.shape)])
        begun = advance(
            q[np.newaxis], rest[np.newaxis], covariance[np.newaxis], np.zeros((1, joints)), np.zeros(joints),
            table.ends, table.kinds, table.axes, table.zero, table.ranges, gyr, acc, seen,
            0.5 * (gyr[0] + gyr[1]), np.zeros(2 * joints), np.zeros((2 * joints, 2)), settings, k, False)
        assert begun
    turn = quaternion.relative(q, true)
    parents = quaternion.rotate(quaternion.conjugate(true), bias[::2])
    error = np.concatenate([2.0 * np.sign(turn[:, :1]) * turn[:, 1:], bias[1::2] - parents], axis=1)
    for part in (slice(0, 3), slice(3, 6), slice(0, 6)):
        freedoms = joints * (part.stop - part.start)
        squares = error[:, part, None] * np.linalg.solve(covariance[:, part, part], error[:, part, None])
        low, high = chi2.interval(0.9999, freedoms)
        assert low < squares.sum() < high


def test_a_joint_that_becomes_unknown_is_told_in_the_same_tick():
    """It begins anew at once, and is never reported as untracked."""
    table = joint_table((Joint(parent=0, child=1, kind="ball"),), 2)
    rest, doubt = np.zeros((1, COLUMNS)), np.zeros(1)
    q = np.array([[[1.0, 0.0, 0.0, 0.0]]])
    assert not forget_contradicted(q, rest, doubt, table.kinds)
    rest[0, TURNED] = 10.0
    assert forget_contradicted(q, rest, doubt, table.kinds)
    assert np.isnan(q).all()
    still, seen = np.zeros((2, 2, 3)), np.full((2, 2), SOUND)
    for silent_s, known in ((0.0, True), (1e3, False)):
        begun = advance(
            np.array([[[1.0, 0.0, 0.0, 0.0]]]), np.zeros((1, 1, COLUMNS)), np.zeros((1, 1, N, N)),
            np.zeros((1, 1)), doubt, table.ends, table.kinds, table.axes, table.zero, table.ranges, still,
            still, seen, np.zeros((2, 3)), np.zeros(2), np.full((2, 2), silent_s), SETTINGS, 1, False)
        assert begun == known
