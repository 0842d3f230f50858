from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from ilc_parts import MODEL, everywhere, free, learning, scalar
from scipy.optimize import LinearConstraint, lsq_linear, minimize

from controllers.ilc import laws as ilc_programme
from controllers.ilc.convergence import condition
from controllers.ilc.laws import LawName, Limits, led
from controllers.trajectories import response, strongest
from fesloop.errors import InputError
from fesloop.models.linear_model import SampledModel

SAMPLES, PERIOD_NS = 12, 25_000_000
WEIGHT = np.array([1.0, 2.0])
LAWS = LawName.__args__
EVERYWHERE = np.ones((SAMPLES, 2), dtype=bool)
SOME_POINTS = EVERYWHERE & np.isin(np.arange(SAMPLES), (4, 9))[:, None]


def limits(reach=np.inf, slew=np.inf):
    return Limits(reach=np.broadcast_to(reach, 3).astype(float), slew=slew)


def trial(seed=0):
    rng = np.random.default_rng(seed)
    return rng.uniform(0.2, 0.6, (SAMPLES, 3)), 0.5 * rng.standard_normal((SAMPLES, 2))


def stacked_least_squares(drives, errors, heeded=EVERYWHERE):
    """(matrix, right side) whose least squares in the new drives is the norm-optimal cost."""
    root = np.sqrt(heeded * WEIGHT).ravel()
    lifted = MODEL.lifted(SAMPLES)
    goal = np.where(heeded, errors, 0.0).ravel() + lifted @ drives.ravel()
    matrix = np.vstack([root[:, None] * lifted, np.sqrt(0.05) * np.eye(drives.size)])
    return matrix, np.concatenate([root * goal, np.sqrt(0.05) * drives.ravel()])


@pytest.mark.parametrize("law", ["noilc", "newton"])
def test_norm_optimal_equals_stacked_least_squares(law):
    drives, errors = trial()
    errors *= 0.1  # neither a limit nor, for Newton, the longest pulse is reached
    learnt, status = learning(law, output_weight=WEIGHT).learn(drives, errors, EVERYWHERE)
    best = np.linalg.lstsq(*stacked_least_squares(drives, errors), rcond=None)[0]
    assert status == ""
    np.testing.assert_allclose(learnt.ravel(), best, atol=1e-10)


def test_the_gradient_steps_against_the_gradient_of_the_squared_error():
    drives, errors = trial()
    drives += 1.0
    law = learning("gradient", output_weight=WEIGHT, step=0.7)
    lifted, weights = MODEL.lifted(SAMPLES), np.tile(WEIGHT, SAMPLES)
    greatest = np.linalg.norm(np.sqrt(weights)[:, None] * lifted, 2) ** 2
    step = 0.7 / greatest * lifted.T @ (weights * errors.ravel())
    learnt, _ = law.learn(drives, errors, EVERYWHERE)
    np.testing.assert_allclose((learnt - drives).ravel(), step, rtol=1e-5, atol=1e-9)


@pytest.mark.parametrize("solver", ["daqp", "osqp"])
def test_limits_inside_the_programme_give_the_bounded_least_squares(solver):
    drives, errors = trial(1)
    law = learning("noilc_constrained", limits=limits(0.7), output_weight=WEIGHT, solver=solver)
    learnt, status = law.learn(drives, errors, EVERYWHERE)
    best = lsq_linear(*stacked_least_squares(drives, errors), bounds=(0.0, 0.7), tol=1e-14).x
    assert status == ""
    np.testing.assert_allclose(learnt.ravel(), best, atol={"daqp": 1e-6, "osqp": 2e-3}[solver])


@pytest.mark.parametrize("solver", ["daqp", "osqp"])
def test_slew_inside_the_programme_equals_a_general_solver(solver):
    drives, errors = trial(2)
    law = learning("noilc_constrained", limits=limits(0.7, 0.08), output_weight=WEIGHT, solver=solver)
    start = law.limits.within(drives)
    learnt, _ = law.learn(start, errors, EVERYWHERE)
    matrix, goal = stacked_least_squares(start, errors)
    rows = np.eye(drives.size) - np.eye(drives.size, k=-3)
    found = minimize(
        lambda v: 0.5 * np.sum((matrix @ v - goal) ** 2), np.zeros(drives.size), method="SLSQP",
        jac=lambda v: matrix.T @ (matrix @ v - goal), bounds=[(0.0, 0.7)] * drives.size,
        constraints=LinearConstraint(rows, -0.08, 0.08), options={"ftol": 1e-14, "maxiter": 2000})
    np.testing.assert_allclose(learnt.ravel(), found.x, atol={"daqp": 2e-4, "osqp": 4e-3}[solver])


@pytest.mark.parametrize("solver", ["daqp", "osqp"])
def test_point_to_point_is_norm_optimal_at_the_points_alone(solver):
    drives, errors = trial(5)
    drives += 2.0
    law = learning("point_to_point", points=SOME_POINTS, output_weight=WEIGHT, solver=solver)
    learnt, _ = law.learn(drives, errors, EVERYWHERE)
    best = np.linalg.lstsq(*stacked_least_squares(drives, errors, SOME_POINTS), rcond=None)[0]
    np.testing.assert_allclose(learnt.ravel(), best, atol=2e-3)
    for _ in range(60):
        learnt, _ = law.learn(learnt, errors - response(MODEL, learnt - drives), EVERYWHERE)
    left = errors - response(MODEL, learnt - drives)
    assert np.abs(left[SOME_POINTS]).max() < 0.02 * np.abs(errors).max()
    assert np.abs(left[~SOME_POINTS]).max() > 0.2 * np.abs(errors).max()


@pytest.mark.parametrize("law", LAWS)
def test_drives_keep_their_limits(law):
    drives, errors = trial(3)
    points = SOME_POINTS if law == "point_to_point" else EVERYWHERE
    limited = learning(law, limits=limits(np.array([0.7, 0.5, 0.3]), 0.1), gain=5.0, points=points)
    learnt, _ = limited.learn(limited.limits.within(drives), 20.0 * errors, EVERYWHERE)
    assert learnt.min() >= 0.0
    assert (learnt <= [0.7, 0.5, 0.3]).all()
    assert np.abs(np.diff(learnt, axis=0, prepend=np.zeros((1, 3)))).max() <= 0.1 + 1e-12


@pytest.mark.parametrize("law", LAWS)
def test_a_trial_that_ended_early_changes_only_what_it_covered(law):
    drives, errors = trial(4)
    covered = EVERYWHERE & (np.arange(SAMPLES) < 7)[:, None]
    errors[7:] = 1e6
    learnt, _ = learning(law, limits=limits(1.0)).learn(drives, errors, covered)
    np.testing.assert_allclose(learnt[7:], drives[7:], atol=1e-6)
    assert np.abs(learnt[:7] - drives[:7]).max() > 0.01


@settings(max_examples=25, deadline=None)
@given(st.sampled_from(["gradient", "noilc", "noilc_constrained"]),
       st.lists(st.integers(2, SAMPLES), min_size=5, max_size=5), st.integers(0, 99))
def test_with_any_lengths_the_covered_error_shrinks_in_every_trial(law, lengths, seed):
    drives, errors = trial(seed)
    law, target = learning(law, limits=limits(2.0)), errors + response(MODEL, drives)
    for length in lengths:
        covered = EVERYWHERE & (np.arange(SAMPLES) < length)[:, None]
        before = np.where(covered, target - response(MODEL, drives), 0.0)
        learnt, _ = law.learn(drives, before, covered)
        inside = law.limits.within(learnt)
        after = np.where(covered, target - response(MODEL, inside), 0.0)
        if law.law == "noilc_constrained" or (learnt.min() > 0.0 and learnt.max() < 2.0):
            assert np.linalg.norm(after) <= np.linalg.norm(before) * (1.0 + 1e-9) + 1e-9
        drives = inside


def test_nothing_seen_nothing_learnt():
    drives, errors = trial()
    learnt, status = learning("noilc").learn(drives, errors, ~EVERYWHERE)
    assert status == "no_valid_samples"
    np.testing.assert_array_equal(learnt, drives)


@pytest.mark.parametrize("solver", ["daqp", "osqp"])
def test_a_programme_without_an_answer_leaves_the_drives_alone_and_says_why(solver, monkeypatch):
    monkeypatch.setattr(ilc_programme, "_ITERATIONS", 1)
    drives, errors = trial()
    law = learning("noilc_constrained", limits=limits(0.7, 0.08), solver=solver)
    start = law.limits.within(drives)
    learnt, status = law.learn(start, errors, EVERYWHERE)
    assert status == "iteration_limit"
    np.testing.assert_array_equal(learnt, start)


def test_the_lead_stops_at_the_last_sample_seen_of_each_output():
    errors = np.column_stack([np.arange(6.0), 10.0 * np.arange(6.0)])
    covered = np.array([[True, True]] * 4 + [[True, False]] * 2)
    np.testing.assert_array_equal(led(errors, covered, 2), np.column_stack(
        [[2, 3, 4, 5, 5, 5], [20, 30, 30, 30, 0, 0]]))


def test_phase_lead_refuses_a_model_that_comes_to_no_rest():
    with pytest.raises(InputError, match="static gain"):
        learning("phase_lead", scalar(1.0, 0.1)).learn(np.zeros((12, 1)), np.ones((12, 1)),
                                                       np.ones((12, 1), dtype=bool))


def static(gain):
    """y[k+1] = gain v[k]: one sample later, nothing else."""
    return scalar(0.0, gain)


@pytest.mark.parametrize(("law", "changes", "factor"), [
    ("phase_lead", {"gain": 0.3, "lead": 1}, 0.7), ("phase_lead", {"gain": 1.6, "lead": 1}, 0.6),
    ("gradient", {"step": 0.25}, 0.75), ("gradient", {"step": 1.5}, 0.5),
    ("noilc", {"change_weight": 0.08}, 0.08 / (0.08 + 0.16)),
    ("noilc_constrained", {"change_weight": 0.08}, 0.08 / (0.08 + 0.16)),
    ("noilc", {"change_weight": 0.08, "forgetting": 0.1}, 0.9 - 0.16 / (0.08 + 0.16))])
def test_a_pure_gain_converges_by_its_known_factor(law, changes, factor):
    law, start = learning(law, static(0.4), **changes), 3.0
    optimum = np.full((SAMPLES, 1), 2.0)
    optimum[-1] = start  # the last drive acts after the end
    drives, seen = np.full((SAMPLES, 1), start), []
    for _ in range(6):
        errors = 0.4 * np.vstack([[0.0], (optimum - drives)[:-1]])
        drives, status = law.learn(drives, errors, everywhere(law))
        assert status == ""
        seen.append(drives[5, 0])
    for earlier, later in pairwise(np.diff([start, *seen])):
        assert abs(later / earlier) == pytest.approx(abs(factor), rel=2e-3, abs=2e-3)


@st.composite
def stable_models(draw):
    """Stable models of 1 to 3 muscles and 1 to 3 outputs."""
    states, muscles, outputs = draw(st.integers(1, 4)), draw(st.integers(1, 3)), draw(st.integers(1, 3))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    a = rng.standard_normal((states, states))
    a *= draw(st.floats(0.0, 0.95)) / max(np.abs(np.linalg.eigvals(a)).max(), 1e-9)
    return SampledModel(a, rng.standard_normal((states, muscles)), rng.standard_normal((outputs, states)),
                        np.zeros(outputs), 0)


@settings(max_examples=30, deadline=None)
@given(stable_models(), st.sampled_from(["gradient", "noilc"]), st.floats(0.05, 3.0), st.floats(0.3, 2.5),
       st.integers(0, 99))
def test_where_the_condition_holds_the_error_shrinks_in_every_trial(model, law, tuning, strength, seed):
    samples = 15
    law = learning(law, model, samples, step=tuning, change_weight=tuning * strongest(
        model, np.ones((samples, model.c.shape[0]))))
    told = condition(law, PERIOD_NS)
    drives = np.zeros((samples, model.b.shape[1]))
    target = np.random.default_rng(seed).standard_normal((samples, model.c.shape[0]))
    norms = []
    for _ in range(6):
        errors = target - strength * response(model, drives)
        norms.append(np.linalg.norm(errors))
        drives = drives + law.change(errors, everywhere(law))
    if strength <= 0.999 * told.strength_margin:
        assert all(later <= earlier * (1.0 + 1e-9) for earlier, later in pairwise(norms))
    pattern = np.linalg.svd(model.lifted(samples))[0][:, 0].reshape(target.shape)
    if strength >= 1.01 * told.strength_margin:
        left = pattern - strength * response(model, law.change(pattern, everywhere(law)))
        assert np.linalg.norm(left) > 1.0


def test_forgetting_bounds_what_is_learnt_in_the_long_run():
    law = learning("gradient", static(0.4), step=0.5, forgetting=0.1, limits=free(1))
    drives = np.zeros((SAMPLES, 1))
    for _ in range(200):
        drives, _ = law.learn(drives, 1.0 - response(law.model, drives), everywhere(law))
    assert drives[5, 0] == pytest.approx(0.5 / 0.4 / (0.5 + 0.1), rel=1e-6)
