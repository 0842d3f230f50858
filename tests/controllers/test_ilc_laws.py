import sys

import numpy as np
import pytest
from scipy.optimize import LinearConstraint, lsq_linear, minimize

from controllers.ilc_laws import Learning
from fesloop.models.linear_model import SampledModel

SAMPLES = 12
MODEL = SampledModel(
    a=np.array([[0.7, 0.1, 0.0], [0.0, 0.6, 0.2], [0.0, 0.0, 0.5]]),
    b=np.array([[0.2, -0.1, 0.05], [0.1, 0.1, 0.0], [0.3, 0.0, -0.3]]),
    c=np.array([[1.0, 0.0, 0.0], [0.2, 0.0, 1.0]]), offset=np.zeros(2), delay_steps=0)
EVERYWHERE = np.ones(SAMPLES, dtype=bool)


def learning(law, **changes):
    return Learning(**{
        "law": law, "model": MODEL, "samples": SAMPLES, "reach": np.full(3, np.inf), "slew": np.inf,
        "output_weight": np.array([1.0, 2.0]), "change_weight": 0.05, "gain": 0.4, "lead": 1, "cutoff": 0.0,
        "solver": "daqp"} | changes)


def trial(seed=0):
    rng = np.random.default_rng(seed)
    return rng.uniform(0.2, 0.6, (SAMPLES, 3)), 0.5 * rng.standard_normal((SAMPLES, 2))


def stacked_least_squares(drives, errors, covered=EVERYWHERE):
    """(matrix, right side) whose least squares in the new drives is the norm-optimal cost."""
    root = np.sqrt(np.outer(covered, [1.0, 2.0])).ravel()
    lifted = MODEL.lifted(SAMPLES)
    goal = np.where(covered[:, None], errors, 0.0).ravel() + lifted @ drives.ravel()
    matrix = np.vstack([root[:, None] * lifted, np.sqrt(0.05) * np.eye(drives.size)])
    return matrix, np.concatenate([root * goal, np.sqrt(0.05) * drives.ravel()])


def test_norm_optimal_equals_stacked_least_squares():
    drives, errors = trial()
    wide = learning("noilc", reach=np.full(3, np.inf))
    step = wide.learning_operator(EVERYWHERE) @ errors.ravel()
    best = np.linalg.lstsq(*stacked_least_squares(drives, errors), rcond=None)[0]
    np.testing.assert_allclose(drives.ravel() + step, best, atol=1e-10)


@pytest.mark.parametrize("solver", ["daqp", "osqp"])
def test_limits_inside_the_programme_give_the_bounded_least_squares(solver):
    drives, errors = trial(1)
    law = learning("noilc_constrained", reach=np.full(3, 0.7), solver=solver)
    learnt, status = law.learn(drives, errors, EVERYWHERE)
    best = lsq_linear(*stacked_least_squares(drives, errors), bounds=(0.0, 0.7), tol=1e-14).x
    assert status == ""
    np.testing.assert_allclose(learnt.ravel(), best, atol={"daqp": 1e-6, "osqp": 2e-3}[solver])


def test_slew_inside_the_programme_equals_a_general_solver():
    drives, errors = trial(2)
    law = learning("noilc_constrained", reach=np.full(3, 0.7), slew=0.08)
    learnt, _ = law.learn(drives, errors, EVERYWHERE)
    matrix, goal = stacked_least_squares(drives, errors)
    rows = np.eye(drives.size) - np.eye(drives.size, k=-3)
    found = minimize(
        lambda v: 0.5 * np.sum((matrix @ v - goal) ** 2), np.zeros(drives.size), method="SLSQP",
        jac=lambda v: matrix.T @ (matrix @ v - goal), bounds=[(0.0, 0.7)] * drives.size,
        constraints=LinearConstraint(rows, -0.08, 0.08), options={"ftol": 1e-14, "maxiter": 2000})
    np.testing.assert_allclose(learnt.ravel(), found.x, atol=2e-4)


@pytest.mark.parametrize("law", ["phase_lead", "noilc", "noilc_constrained"])
def test_drives_keep_their_limits(law):
    drives, errors = trial(3)
    limited = learning(law, reach=np.array([0.7, 0.5, 0.3]), slew=0.1, gain=5.0)
    learnt, _ = limited.learn(drives, 20.0 * errors, EVERYWHERE)
    assert learnt.min() >= 0.0
    assert (learnt <= [0.7, 0.5, 0.3]).all()
    assert np.abs(np.diff(learnt, axis=0, prepend=np.zeros((1, 3)))).max() <= 0.1 + 1e-12


@pytest.mark.parametrize("law", ["phase_lead", "noilc", "noilc_constrained"])
def test_a_trial_that_ended_early_changes_only_what_it_covered(law):
    drives, errors = trial(4)
    covered = np.arange(SAMPLES) < 7
    errors[7:] = 1e6
    learnt, _ = learning(law, reach=np.full(3, 1.0)).learn(drives, errors, covered)
    np.testing.assert_allclose(learnt[7:], drives[7:], atol=1e-6)
    assert np.abs(learnt[:7] - drives[:7]).max() > 0.01


def test_nothing_seen_nothing_learnt():
    drives, errors = trial()
    learnt, status = learning("noilc").learn(drives, errors, ~EVERYWHERE)
    assert status == "unobserved"
    np.testing.assert_array_equal(learnt, drives)


def test_convergence_factor_of_norm_optimal_is_rho_over_rho_plus_the_least_seen_strength():
    law = learning("noilc", output_weight=np.ones(2))
    strength = np.linalg.svd(MODEL.lifted(SAMPLES), compute_uv=False)
    least = strength[strength >= 0.01 * strength[0]][-1]
    assert law.convergence_factor() == pytest.approx(0.05 / (0.05 + least**2), rel=1e-9)


@pytest.mark.parametrize("law", ["phase_lead", "noilc"])
def test_error_in_the_seen_drives_shrinks_by_the_factor_at_least(law):
    actual = SampledModel(1.02 * MODEL.a, 0.85 * MODEL.b, MODEL.c, MODEL.offset, 0)
    law = learning(law, change_weight=0.02, lead=0, cutoff=0.6)
    factor = law.convergence_factor(actual)
    _, strength, seen = np.linalg.svd(MODEL.lifted(SAMPLES), full_matrices=False)
    seen = seen[strength >= 0.01 * strength[0]].T
    operator, lifted = law.learning_operator(EVERYWHERE), actual.lifted(SAMPLES)
    worst = 0.0
    for seed in range(40):
        astray = seen @ np.random.default_rng(seed).standard_normal(seen.shape[1])
        left = law.smoothed((astray - operator @ (lifted @ astray)).reshape(SAMPLES, 3)).ravel()
        worst = max(worst, np.linalg.norm(seen.T @ left) / np.linalg.norm(astray))
    assert worst <= factor + 1e-12
    assert worst > 0.3 * factor


@pytest.fixture
def mismatched_hand(peers, monkeypatch):
    """The eight-law comparison's plant and its mismatched subjects."""
    monkeypatch.setattr(sys, "path", [str(peers / "ilc"), str(peers / "mpc"), *sys.path])
    return pytest.importorskip("ilc_bench")


def rmse_per_trial(hand, law, slew, subjects=8, trials=3):
    """Joint RMSE in deg, (subjects, trials), under one of our laws."""
    a, b, c = hand.plant(hand.NU, hand.NY)
    states = a.shape[0]
    delayed = SampledModel(
        np.block([[a, b], [np.zeros((hand.NU, states + hand.NU))]]),
        np.vstack([np.zeros((states, hand.NU)), np.eye(hand.NU)]),
        np.hstack([c, np.zeros((hand.NY, hand.NU))]), np.zeros(hand.NY), 1)
    ours = Learning(law=law, model=delayed, samples=hand.N, reach=np.ones(hand.NU), slew=slew,
                    output_weight=np.ones(hand.NY), change_weight=0.05, gain=0.5, lead=8, cutoff=0.24,
                    solver="osqp")
    every = np.ones(hand.N, dtype=bool)
    table = []
    for subject in range(subjects):
        rng = np.random.default_rng(subject)
        lifted = hand.lifted(*hand.plant_m(subject))
        curves = [(hand.P0[0] * (1 + 0.15 * rng.uniform(-1, 1)), hand.P0[1] * (1 + 0.2 * rng.uniform(-1, 1)))
                  for _ in range(hand.NU)]
        drives, row = np.zeros((hand.N, hand.NU)), []
        for _ in range(trials):
            widths = hand.rec_inv(drives, hand.P0)
            recruited = np.stack([hand.rec(widths[:, j], curves[j]) for j in range(hand.NU)], 1)
            errors = hand.R - (lifted @ recruited.ravel()).reshape(hand.R.shape)
            row.append(hand.DEG * np.sqrt(np.mean(errors**2)))
            drives, status = ours.learn(drives, errors, every)
            assert status == ""
        table.append(row)
    return np.array(table)


def test_limits_inside_the_programme_learn_in_two_trials_what_clipping_does_not(mismatched_hand):
    inside = np.median(rmse_per_trial(mismatched_hand, "noilc_constrained", 0.15), axis=0)
    clipped = np.median(rmse_per_trial(mismatched_hand, "noilc", np.inf), axis=0)
    assert inside[0] == pytest.approx(21.5, abs=0.5)
    assert inside[2] < 2.0
    assert clipped[2] == pytest.approx(7.0, abs=1.0)
