import itertools
import pickle

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.optimize import linprog

from controllers.quadratic_programme import Qp
from fesloop.errors import InputError

BOTH = pytest.mark.parametrize("solver", ["daqp", "osqp"])
BOUNDED = st.floats(-3.0, 3.0).map(lambda value: round(value, 3))


def programme(solver, n=6, **options):
    """The six-variable problem on which OSQP's update goes wrong silently: boxes 0 to 1, x = -q inside."""
    tolerance = {"daqp": 1e-6, "osqp": 1e-7}[solver]
    return Qp(np.eye(n), np.empty((0, n)), solver=solver, tolerance=tolerance, **options)


def best_by_enumeration(hessian, rows, q, lower, upper):
    """The minimiser among the stationary points of every choice of active bounds; None if infeasible."""
    n, every = q.size, np.vstack([np.eye(q.size), rows])
    best, least = None, np.inf
    for choice in itertools.product((None, 0, 1), repeat=every.shape[0]):
        active = [i for i, side in enumerate(choice) if side is not None]
        if len(active) > n:
            continue
        level = np.array([(lower, upper)[choice[i]][i] for i in active])
        kkt = np.block([[hessian, every[active].T], [every[active], np.zeros((len(active),) * 2)]])
        if np.linalg.matrix_rank(kkt) < kkt.shape[0]:
            continue
        x = np.linalg.solve(kkt, np.concatenate([-q, level]))[:n]
        value = every @ x
        if (value >= lower - 1e-9).all() and (value <= upper + 1e-9).all():
            cost = 0.5 * x @ hessian @ x + q @ x
            if cost < least:
                best, least = x, cost
    return best


@st.composite
def programmes(draw):
    root = draw(arrays(float, (3, 3), elements=BOUNDED))
    rows = draw(arrays(float, (2, 3), elements=BOUNDED))
    centre = draw(arrays(float, 5, elements=BOUNDED))
    width = draw(arrays(float, 5, elements=st.sampled_from([0.0, 0.1, 0.5, 2.0])))
    q = draw(arrays(float, 3, elements=BOUNDED))
    return root @ root.T + 0.1 * np.eye(3), rows, q, centre - width, centre + width


@BOTH
@settings(deadline=None, max_examples=60)
@given(problem=programmes())
def test_equals_the_best_of_all_active_sets(solver, problem):
    hessian, rows, q, lower, upper = problem
    best = best_by_enumeration(*problem)
    feasible = linprog(np.zeros(3), np.vstack([rows, -rows]), np.concatenate([upper[3:], -lower[3:]]),
                       bounds=list(zip(lower[:3], upper[:3], strict=True))).status == 0
    assume((best is not None) == feasible)
    qp = Qp(hessian, rows, solver=solver, tolerance=1e-8, max_iterations=20000)
    result = qp.solve(q, lower, upper)
    if best is None:
        assert not result.solved
        assert result.x.size == 0
    elif solver == "daqp" or result.solved:
        assert result.solved
        np.testing.assert_allclose(result.x, best, atol=1e-5)


@BOTH
@settings(deadline=None, max_examples=40)
@given(problem=programmes(), sizes=st.sampled_from([0.1, 1.0, 10.0]))
def test_centred_is_the_same_programme_told_by_its_free_minimum(solver, problem, sizes):
    hessian, rows, q, lower, upper = problem
    q = sizes * q
    options = {"solver": solver, "tolerance": 1e-8, "max_iterations": 20000}
    plain = Qp(hessian, rows, **options).solve(q, lower, upper)
    centre = -np.linalg.solve(hessian, q)
    centred = Qp(hessian, rows, centred=True, **options).solve(centre, lower, upper)
    if plain.solved or solver == "daqp":
        assert centred.status == plain.status
        np.testing.assert_allclose(centred.x, plain.x, atol=2e-5)


@BOTH
def test_centred_refuses_and_tells_what_the_plain_one_does(solver):
    qp = programme(solver, centred=True)
    with pytest.raises(InputError, match="qp"):
        qp.solve(np.full(6, 0.9), np.zeros(6), np.ones(7))
    assert qp.solve(np.full(6, np.nan), np.zeros(6), np.ones(6)).status == "non_finite"
    assert qp.solve(np.full(6, 0.3), np.full(6, 0.8), np.full(6, 0.2)).status == "infeasible"
    np.testing.assert_allclose(qp.solve(np.full(6, 0.6), np.zeros(6), np.ones(6)).x, 0.6, atol=1e-5)


@BOTH
def test_multipliers_are_positive_at_upper_and_negative_at_lower_bounds(solver):
    result = programme(solver, 2).solve(np.array([-3.0, 2.0]), np.zeros(2), np.ones(2))
    np.testing.assert_allclose(result.multipliers, [2.0, -2.0], atol=1e-5)


@BOTH
def test_short_vectors_are_refused(solver):
    with pytest.raises(InputError, match="qp q"):
        programme(solver).solve(np.full(2, -0.9), np.zeros(6), np.ones(6))
    with pytest.raises(InputError, match="qp upper"):
        programme(solver).solve(np.full(6, -0.9), np.zeros(6), np.ones(7))


@BOTH
def test_strided_and_single_precision_vectors_are_read_right(solver):
    qp = programme(solver)
    qp.solve(np.zeros(6), np.zeros(6), np.ones(6))
    strided = np.stack([np.full(6, -0.5), np.full(6, 9.0)], axis=1)[:, 0]
    np.testing.assert_allclose(qp.solve(strided, np.zeros(6), np.ones(6)).x, np.full(6, 0.5), atol=1e-5)
    single = np.full(6, -0.25, dtype=np.float32)
    np.testing.assert_allclose(qp.solve(single, np.zeros(6), np.ones(6)).x, np.full(6, 0.25), atol=1e-5)


@BOTH
def test_crossed_bounds_are_infeasible_and_the_next_solve_is_right(solver):
    qp = programme(solver)
    assert qp.solve(np.full(6, -0.3), np.zeros(6), np.ones(6)).solved
    crossed = qp.solve(np.full(6, -0.3), np.full(6, 0.8), np.full(6, 0.2))
    assert crossed.status == "infeasible"
    assert crossed.x.size == 0
    after = qp.solve(np.full(6, -0.6), np.zeros(6), np.ones(6))
    np.testing.assert_allclose(after.x, np.full(6, 0.6), atol=1e-5)


@BOTH
def test_rows_that_cannot_be_met_are_infeasible(solver):
    qp = Qp(np.eye(2), np.array([[1.0, 1.0]]), solver=solver)
    result = qp.solve(np.zeros(2), np.array([0.0, 0.0, 3.0]), np.array([1.0, 1.0, 4.0]))
    assert result.status == "infeasible"


@BOTH
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_non_finite_vectors_are_told(solver, bad):
    q, lower, upper = np.zeros(6), np.zeros(6), np.ones(6)
    q[3] = bad
    assert programme(solver).solve(q, lower, upper).status == "non_finite"
    lower[2] = np.nan
    assert programme(solver).solve(np.zeros(6), lower, upper).status == "non_finite"


@BOTH
def test_infinite_bounds_leave_free(solver):
    result = programme(solver).solve(np.full(6, -7.0), np.full(6, -np.inf), np.full(6, np.inf))
    np.testing.assert_allclose(result.x, np.full(6, 7.0), atol=1e-4)


@BOTH
def test_iteration_limit_is_told(solver):
    rng = np.random.default_rng(0)
    root, rows = rng.standard_normal((20, 20)), rng.standard_normal((20, 20))
    qp = Qp(root @ root.T + 1e-3 * np.eye(20), rows, solver=solver, tolerance=1e-9, max_iterations=1)
    result = qp.solve(rng.standard_normal(20), np.full(40, -0.1), np.full(40, 0.1))
    assert result.status == "iteration_limit"
    assert result.x.size == 0


@BOTH
def test_answer_stays_inside_its_boxes_exactly(solver):
    rng = np.random.default_rng(3)
    qp = Qp(np.eye(8), rng.standard_normal((4, 8)), solver=solver, tolerance=1e-3)
    for _ in range(20):
        lower, upper = np.full(12, -0.3), np.full(12, 0.3)
        result = qp.solve(3.0 * rng.standard_normal(8), lower, upper)
        assert result.solved
        assert (result.x >= lower[:8]).all()
        assert (result.x <= upper[:8]).all()


@BOTH
@pytest.mark.parametrize("centred", [False, True])
@pytest.mark.parametrize("at", [3, 7, 8, 13])
def test_restored_programme_goes_on_bit_for_bit(solver, at, centred):
    rng = np.random.default_rng(5)
    root = rng.standard_normal((12, 12))
    qp = Qp(root @ root.T + 0.1 * np.eye(12), np.eye(12) - np.eye(12, k=-1), solver=solver, refresh=8,
            centred=centred)
    bounds = np.full(24, 0.4)
    twin = None
    for k in range(20):
        q = rng.standard_normal(12)
        if k == 5:
            assert not qp.solve(q, bounds, -bounds).solved
        result = qp.solve(q, -bounds, bounds)
        assert result.solved
        if twin is not None:
            np.testing.assert_array_equal(twin.solve(q, -bounds, bounds).x, result.x)
        if k == at:
            twin = pickle.loads(pickle.dumps(qp))


@pytest.mark.parametrize(("hessian", "rows", "message"), [
    (np.ones((2, 3)), np.empty((0, 2)), "square"),
    (np.array([[1.0, 1.0], [0.0, 1.0]]), np.empty((0, 2)), "not symmetric"),
    (np.diag([1.0, 0.0]), np.empty((0, 2)), "not positive definite"),
    (np.diag([1.0, np.nan]), np.empty((0, 2)), "not finite"),
    (np.eye(2), np.empty((1, 3)), "qp rows"),
])
def test_refuses_unfit_matrices(hessian, rows, message):
    with pytest.raises(InputError, match=message):
        Qp(hessian, rows)
