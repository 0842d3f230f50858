import numpy as np
import pytest
from ilc_parts import MODEL
from scipy.optimize import LinearConstraint, minimize

from controllers.allocation import Allocation
from controllers.ilc.laws import Limits, limited_change
from controllers.trajectories import optimal_change, response
from fesloop.models.linear_model import SampledModel

SAMPLES = 12
ALLOCATION = Allocation(recruitment=None, current_ma=(20.0, 40.0, 60.0), full_scale_us=500.0)
"""Without recruitment charge is linear in the drive: 10, 20 and 30 uC per unit and tick."""


@pytest.mark.parametrize("solver", ["daqp", "osqp"])
def test_charge_inside_the_programme_equals_a_general_solver(solver):
    rng = np.random.default_rng(0)
    drives, errors = np.full((SAMPLES, 3), 0.1), 1.0 + 0.3 * rng.standard_normal((SAMPLES, 2))
    limits = Limits(reach=np.ones(3), slew=0.2, allocation=ALLOCATION, charge_c=4e-5)
    change, status = limited_change(MODEL, errors, np.ones((SAMPLES, 2)), 0.05, drives, limits, solver)
    lifted, size = MODEL.lifted(SAMPLES), drives.size
    rows = np.vstack([np.eye(size) - np.eye(size, k=-3), np.tile(np.diag([10.0, 20.0, 30.0]), SAMPLES)])
    bounds = np.concatenate([np.full(size, 0.2), np.full(3, 40.0)])
    found = minimize(
        lambda v: 0.5 * np.sum((errors.ravel() - lifted @ (v - 0.1)) ** 2) + 0.025 * np.sum((v - 0.1) ** 2),
        drives.ravel(), method="SLSQP", bounds=[(0.0, 1.0)] * size,
        jac=lambda v: -lifted.T @ (errors.ravel() - lifted @ (v - 0.1)) + 0.05 * (v - 0.1),
        constraints=LinearConstraint(rows, np.concatenate([-bounds[:size], np.full(3, -np.inf)]), bounds),
        options={"ftol": 1e-14, "maxiter": 2000})
    assert status == ""
    np.testing.assert_allclose((drives + change).ravel(), found.x, atol=5e-3)
    spent = 1e6 * limits.charges(limits.within(drives + change))
    assert spent.max() == pytest.approx(40.0, rel=5e-3)


def test_a_trial_of_300_samples_with_8_channels_and_4_outputs_is_solved():
    rng = np.random.default_rng(1)
    a = np.diag(rng.uniform(0.6, 0.95, 24))
    model = SampledModel(a, 0.1 * rng.standard_normal((24, 8)), rng.standard_normal((4, 24)), np.zeros(4), 0)
    errors = 0.3 * np.sin(np.linspace(0.0, 9.0, 300))[:, None] * rng.standard_normal(4)
    weights, drives = np.ones((300, 4)), np.full((300, 8), 5.0)
    wide = Limits(reach=np.full(8, 10.0), slew=20.0)
    change, status = limited_change(model, errors, weights, 0.1, drives, wide, "osqp")
    assert status == ""
    best = optimal_change(model, errors, weights, np.full((300, 8), 0.1))
    np.testing.assert_allclose(change, best, atol=2e-3 * np.abs(best).max())


@pytest.mark.parametrize("solver", ["osqp", "daqp"])
def test_what_is_kept_does_not_change_and_the_rest_makes_up_for_it(solver):
    drives = np.full((SAMPLES, MODEL.b.shape[1]), 0.3)
    errors = np.full((SAMPLES, 2), 0.1)
    kept = np.zeros(drives.shape, dtype=bool)
    kept[:, 0] = True
    limits = Limits(reach=np.ones(drives.shape[1]), slew=1.0)

    def left(which):
        change, status = limited_change(
            MODEL, errors, np.ones((SAMPLES, 2)), 0.05, drives, limits, solver, which)
        assert status == ""
        return change, np.sum((errors - response(MODEL, change)) ** 2)

    free, _ = left(None)
    change, after = left(kept)
    np.testing.assert_allclose(change[:, 0], 0.0, atol=1e-3)
    cut = np.where(kept, 0.0, free)
    cost = after + 0.05 * np.sum(change**2)
    assert cost < np.sum((errors - response(MODEL, cut)) ** 2) + 0.05 * np.sum(cut**2)
