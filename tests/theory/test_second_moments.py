"""Second moments against scalar cases from the literature, scipy's Lyapunov solver and Kronecker products."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import solve_discrete_lyapunov

from fesloop.analysis.theory.period_map import Draw, Flow, PeriodMap
from fesloop.analysis.theory.second_moments import SecondMoments


def flow(matrix, noise=None, readings=1):
    size = len(matrix)
    covariance = np.zeros((size, size)) if noise is None else noise
    return Flow(np.asarray(matrix), covariance, np.eye(size)[None, :1][:readings], np.zeros((readings, 1)))


def period(*steps, ages=(1.0,)):
    return SecondMoments(PeriodMap(1.0, steps, np.array(ages)))


def lossy(growth, gain, loss, noise=0.0):
    """x' = growth x + u + w with u = -gain x where it arrives, else 0; the state is (x, u, 0)."""
    closing = flow([[1.0, 0.0, 0.0], [-gain, 0.0, 0.0], [0.0, 0.0, 0.0]], readings=0)
    moving = flow([[growth, 1.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]], np.diag([noise, 0.0, 0.0]))
    return period(closing, Draw(np.array([1.0 - loss, loss]), np.array([[0, 1, 2], [0, 2, 2]])), moving)


@pytest.mark.parametrize("growth", [1.1, 1.5, 3.0])
def test_deadbeat_control_over_a_lossy_wire_fails_at_the_critical_loss(growth):
    # Mean-square stable if and only if loss < 1 / growth^2 (Schenato, Sinopoli, Franceschetti, Poolla, Sastry
    # 2007, doi 10.1109/JPROC.2006.887306, for a scalar plant).
    for loss in (0.99 / growth**2, 1.01 / growth**2):
        assert lossy(growth, growth, loss).spectral_radius() == pytest.approx(loss * growth**2, rel=1e-9)


@given(growth=st.floats(-1.5, 1.5), gain=st.floats(-1.0, 1.0), loss=st.floats(0.0, 0.99))
@settings(max_examples=60, deadline=None)
def test_a_scalar_plant_that_is_controlled_now_and_then(growth, gain, loss):
    factor = loss * growth**2 + (1.0 - loss) * (growth - gain) ** 2
    recursion = lossy(growth, gain, loss, noise=0.5)
    assert recursion.spectral_radius() == pytest.approx(factor, abs=1e-9)
    if factor < 0.99:
        # a reading before the flow sees the state at the tick
        assert recursion.variance(recursion.at_rest()) == pytest.approx(0.5 / (1.0 - factor), rel=1e-8)


@given(st.integers(1, 8), st.integers(0, 2**31), st.floats(0.1, 0.97))
@settings(max_examples=40, deadline=None)
def test_without_draws_they_solve_the_lyapunov_equation(size, seed, radius):
    rng = np.random.default_rng(seed)
    matrix = rng.normal(size=(size, size))
    matrix *= radius / max(np.abs(np.linalg.eigvals(matrix)).max(), 1e-6)
    root = rng.normal(size=(size, size))
    recursion = period(flow(matrix, root @ root.T))
    assert recursion.spectral_radius() == pytest.approx(radius**2)
    wanted = solve_discrete_lyapunov(matrix, root @ root.T)
    assert np.allclose(recursion.at_rest()[0], wanted, rtol=1e-7, atol=1e-9 * np.abs(wanted).max())


def chain(seed, size, ages, scale):
    """A flow, and a draw of which rows go on, by a Markov chain."""
    rng = np.random.default_rng(seed)
    chances = rng.dirichlet(np.ones(ages), ages)
    takes = rng.integers(0, size, (ages, size))
    vectors = np.linalg.matrix_power(chances, 2000)[0]
    matrix, root = scale * rng.normal(size=(size, size)), rng.normal(size=(size, size))
    return chances, takes, vectors, matrix, root @ root.T


@given(st.integers(0, 2**31), st.integers(2, 4), st.integers(2, 4), st.floats(0.1, 0.6))
@settings(max_examples=40, deadline=None)
def test_the_recursion_of_a_chain_is_its_kronecker_matrix(seed, size, ages, scale):
    # Costa, Fragoso and Marques 2005, eq. 3.12d: (P' x I) diag(A_j x A_j), here with A of the state entered.
    chances, takes, odds, matrix, noise = chain(seed, size, ages, scale)
    recursion = period(Draw(chances, takes), flow(matrix, noise), ages=odds)
    entered = [matrix @ np.eye(size)[take] for take in takes]
    operator = np.block([[chances[i, j] * np.kron(entered[j], entered[j]) for i in range(ages)]
                         for j in range(ages)])
    radius = np.abs(np.linalg.eigvals(operator)).max()
    assert recursion.spectral_radius() == pytest.approx(radius, rel=1e-6, abs=1e-9)
    if radius < 0.98:
        constant = np.concatenate([odds[j] * noise.ravel() for j in range(ages)])
        wanted = np.linalg.solve(np.eye(operator.shape[0]) - operator, constant).reshape(ages, size, size)
        assert np.allclose(recursion.at_rest(), wanted, rtol=1e-6, atol=1e-8 * np.abs(wanted).max())


@given(st.integers(0, 2**31))
@settings(max_examples=20, deadline=None)
def test_a_chain_that_is_drawn_twice_a_period_weights_noise_by_its_odds_of_then(seed):
    early, takes, _, matrix, noise = chain(seed, 3, 2, 0.3)
    late, other, _, step, more = chain(seed + 1, 3, 2, 0.3)
    before = np.linalg.matrix_power(early @ late, 2000)[0]
    recursion = period(Draw(early, takes), flow(matrix, noise), Draw(late, other), flow(step, more),
                       ages=before)
    found = recursion.after(np.zeros((2, 3, 3)), noise=True)
    between = before @ early
    wanted = []
    for j in range(2):
        moved = step @ np.eye(3)[other[j]]
        wanted.append(before[j] * more + (between @ late[:, j]) * moved @ noise @ moved.T)
    assert np.allclose(found, wanted)


def test_moments_at_rest_stay_and_are_positive():
    chances, takes, odds, matrix, noise = chain(5, 4, 3, 0.4)
    recursion = period(Draw(chances, takes), flow(matrix, noise), ages=odds)
    rest = recursion.at_rest()
    assert np.allclose(recursion.after(rest, noise=True), rest, rtol=1e-8)
    assert all(np.linalg.eigvalsh(each).min() > 0.0 for each in rest)
