import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import sparse

from controllers.quadratic_programme import Qp, solve_sparse
from fesloop.errors import InputError


def programme(seed, n=6, m=4):
    rng = np.random.default_rng(seed)
    root = rng.standard_normal((n, n))
    hessian, rows = root @ root.T + 0.1 * np.eye(n), rng.standard_normal((m, n))
    lower = -rng.uniform(0.1, 2.0, n + m)
    return hessian, rows, rng.standard_normal(n), lower, lower + rng.uniform(0.5, 3.0, n + m)


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=30, deadline=None)
def test_the_same_optimum_as_the_dense_active_set(seed):
    hessian, rows, *vectors = programme(seed)
    dense = Qp(hessian, rows, solver="daqp").solve(*vectors)
    found = solve_sparse(sparse.csc_matrix(hessian), sparse.csc_matrix(rows), *vectors, tolerance=1e-7)
    if dense.solved:
        assert found.solved
        np.testing.assert_allclose(found.x, dense.x, atol=1e-3)
    else:
        assert not found.solved


def solve(q=(0.0, 0.0), lower=(-1.0, -1.0, -1.0), upper=(1.0, 1.0, 1.0), rows=((1.0, 1.0),)):
    return solve_sparse(sparse.eye(2, format="csc"), sparse.csc_matrix(np.array(rows)),
                        *(np.array(each) for each in (q, lower, upper)))


def test_trouble_is_a_status():
    assert solve().status == "solved"
    assert solve(q=(np.nan, 0.0)).status == "non_finite"
    assert solve(lower=(2.0, -1.0, -1.0)).status == "infeasible"
    assert solve(lower=(-1.0, -1.0, 3.0), upper=(1.0, 1.0, 4.0)).status == "infeasible"


def test_misuse_is_named():
    with pytest.raises(InputError, match="qp q"):
        solve(q=(0.0,))
    with pytest.raises(InputError, match="qp lower"):
        solve(lower=(0.0,))
    with pytest.raises(InputError, match="not finite"):
        solve(rows=((np.inf, 1.0),))
    with pytest.raises(InputError, match="rows"):
        solve(rows=((1.0, 1.0, 1.0),))
