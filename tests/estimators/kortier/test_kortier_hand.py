"""The hand filter's kernels: Jacobians by finite differences, consistency on known truth, standing still."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import chi2

from estimators.kortier import navigation as kortier_hand
from fesloop.hand import quaternion
from fesloop.hand.motion import UPWARDS

SIZE, DT, STEP = kortier_hand.SIZE, 0.005, 1e-6
UP, DOWN = np.array(UPWARDS), -np.array(UPWARDS)


def turned(vectors):
    """Quaternions of rotation vectors (..., 3)."""
    angle = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.concatenate([np.cos(0.5 * angle), 0.5 * np.sinc(0.5 * angle / np.pi) * vectors], axis=-1)


def displaced(state, error):
    """The state (q, bias, velocity, position) that lies `error` (..., 12) away from an estimate."""
    q, *rest = state
    return (quaternion.multiply(q, turned(error[..., :3])),
            *(part + error[..., 3 * i + 3:3 * i + 6] for i, part in enumerate(rest)))


def error_of(state, truth):
    """How far the truth lies from an estimate, (..., 12)."""
    q = quaternion.relative(state[0], truth[0])
    q = np.where(q[..., :1] < 0.0, -q, q)
    length = np.linalg.norm(q[..., 1:], axis=-1, keepdims=True)
    ratio = np.divide(2.0 * np.arctan2(length, q[..., :1]), length, out=np.full_like(length, 2.0),
                      where=length > 0.0)
    rest = (true - part for part, true in zip(state[1:], truth[1:], strict=True))
    return np.concatenate([ratio * q[..., 1:], *rest], axis=-1)


def carried(state, rate, acc):
    """One step of the motion under constant rate, and a constant acceleration in the earth's frame."""
    q, bias, velocity, position = state
    earth = quaternion.rotate(q, acc) + DOWN
    return (quaternion.multiply(q, turned((rate - bias) * DT)), bias, velocity + DT * earth,
            position + DT * velocity + 0.5 * DT**2 * earth)


def differences(function, size):
    """Central differences of a function of a vector that is about zero."""
    columns = [(function(STEP * unit) - function(-STEP * unit)) / (2 * STEP) for unit in np.eye(size)]
    return np.stack(columns, axis=1)


def random_hand(seed):
    rng = np.random.default_rng(seed)
    state = (quaternion.normalized(rng.normal(size=4)), *rng.normal(size=(3, 3)))
    root = rng.normal(size=(SIZE + 3, SIZE + 3))
    return rng, state, root @ root.T


def arrays(state):
    """What the kernels take for a state: copies."""
    return state[0].copy(), state[1].copy(), np.array(state[2:])


@given(st.integers(0, 2**32 - 1))
@settings(deadline=None, max_examples=20)
def test_prediction_against_finite_differences_shared_noise_included(seed):
    rng, state, joint = random_hand(seed)
    rate, acc = rng.normal(scale=8.0, size=(2, 3))
    after = carried(state, rate, acc)
    moved = differences(lambda e: error_of(after, carried(displaced(state, e), rate, acc)), SIZE)
    by_rate = differences(lambda n: error_of(after, carried(state, rate - n, acc)), 3)
    by_acc = differences(lambda n: error_of(after, carried(state, rate, acc - n)), 3)
    acc_variance = 0.9
    joint[SIZE:, SIZE:] = acc_variance * np.eye(3)
    both = np.hstack([moved, by_acc])
    expected = both @ joint @ both.T + 0.4 * by_rate @ by_rate.T
    expected[3:6, 3:6] += 0.2 * np.eye(3)
    q, bias, motion = arrays(state)
    covariance, shared = joint[:SIZE, :SIZE].copy(), joint[:SIZE, SIZE:].copy()
    kortier_hand.predict_hand(q, bias, motion, covariance, shared, rate, acc, 0.4, acc_variance, 0.2, DT,
                              kortier_hand.new_hand_work())
    np.testing.assert_allclose(error_of((q, bias, *motion), after), 0.0, atol=1e-9)
    np.testing.assert_allclose(covariance, expected, atol=1e-6 * np.abs(expected).max())
    np.testing.assert_allclose(shared, both @ joint[:, SIZE:], atol=1e-6 * np.abs(expected).max())


@given(st.integers(0, 2**32 - 1), st.booleans())
@settings(deadline=None, max_examples=20)
def test_corrections_against_finite_differences_and_the_textbook(seed, still):
    rng, state, joint = random_hand(seed)
    known, read = rng.normal(size=(2, 3))
    work = kortier_hand.new_hand_work()
    q, bias, motion = arrays(state)

    def predicted(error):
        moved = displaced(state, error)
        return moved[2] if still else quaternion.rotate(quaternion.conjugate(moved[0]), known)

    own = 0.0 if still else 0.3
    if still:
        read = np.zeros(3)
        kortier_hand.fill_still_rows(motion, work)
    else:
        kortier_hand.fill_vector_rows(q, known, read, work)
    design, residual = differences(predicted, SIZE), read - predicted(np.zeros(SIZE))
    covariance, shared = joint[:SIZE, :SIZE].copy(), np.zeros((SIZE, 3))
    if still:
        shared[:] = joint[:SIZE, SIZE:]
    spread = design @ covariance @ design.T + 0.7 * np.eye(3)
    gain = np.linalg.solve(spread, design @ covariance).T
    rest = np.eye(SIZE) - gain @ design
    expected, told = rest @ covariance @ rest.T + 0.7 * gain @ gain.T, rest @ shared - own * gain
    nis = kortier_hand.correct_hand(q, bias, motion, covariance, shared, 0.7, own, work)
    np.testing.assert_allclose(covariance, expected, atol=1e-6 * np.abs(expected).max())
    np.testing.assert_allclose(shared, told, atol=1e-6)
    moved = displaced(state, gain @ residual)
    np.testing.assert_allclose(error_of((q, bias, *motion), moved), 0.0, atol=1e-5)
    assert nis == pytest.approx(residual @ np.linalg.solve(spread, residual), rel=1e-5)


GYR_SD, WALK_SD, ACC_SD, MAG_SD, MOVING_SD, STILL_SD = 5e-4, 1e-4, 4e-2, 3e-7, 0.3, 0.003
START_SD = np.repeat([0.05, 0.01, 0.02, 0.01], 3)
FIELD, TICKS, RUNS = np.array([0.0, 20e-6, -44e-6]), 600, 50


def simulated_hands(rng, still):
    """RUNS hands at once: true states at each step and what gyroscope, accelerometer and magnetometer read.

    One accelerometer sample serves two steps of the gyroscope. `still`: the velocity is STILL_SD at each of
    them, anew each time, as the zero-velocity update supposes; else accelerations are white, MOVING_SD.
    """
    phase, hertz = rng.uniform(0.0, 6.0, (RUNS, 3)), rng.uniform(0.2, 1.0, (RUNS, 3))
    state = (quaternion.normalized(rng.normal(size=(RUNS, 4))), START_SD[3:6] * rng.normal(size=(RUNS, 3)),
             np.zeros((RUNS, 3)), np.zeros((RUNS, 3)))
    states, read, force = [], [], np.zeros((RUNS, 3))
    for k in range(TICKS):
        rate = 1.5 * np.sin(2 * np.pi * hertz * DT * k + phase)
        if k % 2 == 0 and still:
            both = quaternion.to_matrix(state[0]) + quaternion.to_matrix(
                quaternion.multiply(state[0], turned(rate * DT)))
            wanted = (STILL_SD * rng.normal(size=(RUNS, 3)) - state[2]) / DT + 2 * UP
            force = np.linalg.solve(both, wanted[..., None])[..., 0]
        elif k % 2 == 0:
            moving = UP + MOVING_SD * rng.normal(size=(RUNS, 3))
            force = quaternion.rotate(quaternion.conjugate(state[0]), moving)
        mag = quaternion.rotate(quaternion.conjugate(state[0]), FIELD)
        sds = np.array([GYR_SD, ACC_SD, MAG_SD])[:, None, None]
        exact = np.stack([rate + state[1], force, mag])
        states.append(state)
        read.append(exact + sds * rng.normal(size=(3, RUNS, 3)))
        state = carried(state, rate + state[1], force)
        state = (state[0], state[1] + WALK_SD * np.sqrt(DT) * rng.normal(size=(RUNS, 3)), *state[2:])
    return states, np.array(read)


def filtered_hand(start, read, still):
    """Estimates, covariances and NIS at each correction of one hand."""
    q, bias, motion = arrays(start)
    covariance, shared, work = np.diag(START_SD**2), np.zeros((SIZE, 3)), kortier_hand.new_hand_work()
    state = q, bias, motion, covariance, shared
    seen = []
    for k, (gyr, acc, mag) in enumerate(read):
        if k % 2 == 0:
            sampled = acc
            shared[:] = 0.0
            kortier_hand.fill_vector_rows(q, FIELD, mag, work)
            nis = kortier_hand.correct_hand(*state, MAG_SD**2, 0.0, work)
            if still:
                kortier_hand.fill_still_rows(motion, work)
                nis += kortier_hand.correct_hand(*state, STILL_SD**2, 0.0, work)
            else:
                kortier_hand.fill_vector_rows(q, UP, acc, work)
                nis += kortier_hand.correct_hand(*state, ACC_SD**2 + MOVING_SD**2, ACC_SD**2, work)
            seen.append((q.copy(), bias.copy(), motion[0].copy(), motion[1].copy(), covariance.copy(), nis))
        kortier_hand.predict_hand(*state, gyr, sampled, GYR_SD**2, ACC_SD**2, WALK_SD**2 * DT, DT, work)
    return seen


@pytest.mark.parametrize("still", [False, True])
def test_consistent_over_fifty_runs_when_all_is_as_modelled(still):
    """NEES and NIS averaged over runs inside 95 % bounds (Bar-Shalom et al. 2001, doi 10.1002/0471221279)."""
    rng = np.random.default_rng(7)
    states, read = simulated_hands(rng, still)
    # The first zero velocity is only reached with the second sample of the accelerometer.
    states, read = states[2:], read[2:]
    start = displaced(states[0], -START_SD * rng.normal(size=(RUNS, SIZE)))
    runs = [filtered_hand([part[run] for part in start], read[:, :, run], still) for run in range(RUNS)]
    *estimate, covariance, nis = (np.array(part) for part in zip(*(zip(*run, strict=True) for run in runs),
                                                                 strict=True))
    truth = [np.stack(part, axis=1) for part in zip(*states[::2], strict=True)]
    error = error_of(estimate, truth)
    nees = np.einsum("rki,rki->rk", error, np.linalg.solve(covariance, error[..., None])[..., 0])
    for series, degrees in ((nees, SIZE), (nis, 6)):
        low, high = chi2.ppf([0.025, 0.975], RUNS * degrees) / RUNS
        mean = series.mean(axis=0)
        assert low < mean.mean() < high
        assert np.mean((mean > low) & (mean < high)) > 0.9


def test_stillness_is_small_at_rest_and_large_in_motion():
    rng = np.random.default_rng(0)
    down = quaternion.rotate(quaternion.normalized(rng.normal(size=4)), UP)
    rates, accs = 5e-4 * rng.normal(size=(25, 3)) + 0.02, down + 4e-2 * rng.normal(size=(25, 3))
    bias = np.full(3, 0.02)
    assert kortier_hand.stillness(rates, accs, bias, 0.1, 0.2) < 0.3
    assert kortier_hand.stillness(rates + 0.3, accs, bias, 0.1, 0.2) > 1.0
    assert kortier_hand.stillness(rates, accs * np.linspace(0.9, 1.1, 25)[:, None], bias, 0.1, 0.2) > 1.0
    assert kortier_hand.stillness(rates, np.zeros((25, 3)), bias, 0.1, 0.2) == np.inf
