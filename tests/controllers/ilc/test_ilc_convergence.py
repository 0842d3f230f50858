from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from ilc_parts import MODEL, everywhere, learning, scalar
from scipy import signal

from controllers.ilc.convergence import SEEN, condition, growth_on
from controllers.ilc.laws import low_pass
from controllers.trajectories import response
from fesloop.models.linear_model import SampledModel

PERIOD_NS = 40_000_000
ACTUAL = SampledModel(1.02 * MODEL.a, 0.85 * MODEL.b, MODEL.c, MODEL.offset, 0)


def test_norm_optimal_growth_is_rho_over_rho_plus_the_least_seen_strength():
    greatest = np.linalg.norm(MODEL.lifted(12), 2) ** 2
    told = condition(learning("noilc"), PERIOD_NS)
    assert told.growth == pytest.approx(0.05 / (0.05 + SEEN**2 * greatest), rel=1e-5)
    assert told.strength_margin == pytest.approx(2.0 * (1.0 + 0.05 / greatest), rel=1e-5)
    assert told.holds


@pytest.mark.parametrize(("step", "holds"), [(0.5, True), (1.9, True), (2.1, False)])
def test_the_gradient_holds_below_a_step_of_two(step, holds):
    told = condition(learning("gradient", step=step), PERIOD_NS)
    assert told.holds is holds
    assert told.strength_margin == pytest.approx(2.0 / step)


@pytest.mark.parametrize("law", ["noilc", "gradient"])
@pytest.mark.parametrize("excess", [0.98, 1.02])
def test_the_margin_is_where_the_lifted_system_starts_to_grow(law, excess):
    law = learning(law, step=1.3)
    strength = excess * condition(law, PERIOD_NS).strength_margin
    lifted = strength * MODEL.lifted(12)
    columns = [law.change(unit.reshape(12, 2), everywhere(law)).ravel() for unit in np.eye(24)]
    growth = np.linalg.norm(np.eye(24) - lifted @ np.array(columns).T, 2)
    assert (growth > 1.0 + 1e-9) == (excess > 1.0)


def test_phase_lead_growth_is_that_of_the_transfer_function():
    model, gain, lead = scalar(0.8, 0.5), 0.7, 2
    law = learning("phase_lead", model, gain=gain, lead=lead, cutoff=0.3)
    w, plant = signal.freqz([0.0, 0.5], [1.0, -0.8], worN=np.linspace(0.0, np.pi, 4001))
    _, low = signal.sosfreqz(low_pass(0.3), w)
    growth = np.abs(low) ** 2 * np.abs(1.0 - gain / 2.5 * np.exp(1j * lead * w) * plant)
    told = condition(law, PERIOD_NS)
    assert told.growth == pytest.approx(growth.max(), rel=1e-3)
    worst_hz = w[np.argmax(growth)] / (2.0 * np.pi) / 0.04
    assert told.where == f"at {worst_hz:.2f} Hz" or growth[0] == pytest.approx(growth.max(), rel=1e-3)
    for excess in (0.99, 1.01):
        strength = excess * told.strength_margin
        grown = np.abs(low) ** 2 * np.abs(1.0 - strength * gain / 2.5 * np.exp(1j * lead * w) * plant)
        assert (grown.max() > 1.0 + 1e-6) == (excess > 1.0)


def slow(lead, cutoff):
    """Phase-lead on a two-pole plant of a second's length."""
    poles = SampledModel(np.array([[0.85, 0.15], [0.0, 0.85]]), np.array([[0.0], [0.15]]),
                         np.array([[1.0, 0.0]]), np.zeros(1), 0)
    return learning("phase_lead", poles, 100, gain=0.9, lead=lead, cutoff=cutoff)


@pytest.mark.parametrize(("lead", "cutoff", "holds"), [(9, 0.15, True), (0, 0.9, False)])
def test_phase_lead_converges_where_its_condition_holds_and_grows_where_it_does_not(lead, cutoff, holds):
    law = slow(lead, cutoff)
    told = condition(law, PERIOD_NS)
    assert told.holds is holds
    target = np.sin(np.linspace(0.0, 3.0 * np.pi, 100))[:, None] ** 2
    target[-15:] = 0.0
    drives, norms = np.zeros((100, 1)), []
    for _ in range(60):
        errors = target - response(law.model, drives)
        norms.append(np.linalg.norm(errors))
        drives = law.smoothed(drives + law.change(errors, everywhere(law)))
    if holds:
        assert norms[-1] < 0.2 * norms[0]
        assert all(later < 1.001 * earlier for earlier, later in pairwise(norms))
    else:
        assert norms[-1] > 10.0 * norms[0]
        assert min(norms) < norms[0]  # it looks as if it learnt, at first


@pytest.mark.parametrize("name", ["phase_lead", "gradient", "noilc"])
def test_error_in_the_seen_drives_shrinks_by_the_factor_at_least(name):
    law = learning(name, change_weight=0.02, lead=0, cutoff=0.6 if name == "phase_lead" else 0.0)
    factor = growth_on(law, ACTUAL)
    _, strength, seen = np.linalg.svd(MODEL.lifted(12), full_matrices=False)
    seen = seen[strength >= SEEN * strength[0]].T
    worst = 0.0
    for seed in range(40):
        astray = seen @ np.random.default_rng(seed).standard_normal(seen.shape[1])
        change = law.change((ACTUAL.lifted(12) @ astray).reshape(12, 2), everywhere(law))
        left = law.smoothed(astray.reshape(12, 3) - change).ravel()
        worst = max(worst, np.linalg.norm(seen.T @ left) / np.linalg.norm(astray))
    assert worst <= factor + 1e-12
    assert worst > 0.3 * factor


def test_points_and_forgetting_count():
    points = np.zeros((12, 2), dtype=bool)
    points[5] = True
    full, few = (condition(learning("point_to_point", points=mask), PERIOD_NS)
                 for mask in (np.ones_like(points), points))
    assert few.strength_margin > full.strength_margin
    law = learning("gradient")
    assert condition(replace(law, forgetting=0.1), PERIOD_NS).strength_margin == pytest.approx(1.9)
