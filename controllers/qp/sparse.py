"""A large sparse quadratic programme, solved once, that never hands back a silently wrong answer.

    min 1/2 x'Hx + q'x   subject to   lower <= [x; A x] <= upper

What `qp.Qp` is for small programmes that are solved again and again, this is for those of a whole trial.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from controllers.qp.dense import QpResult
from controllers.qp.solvers import OsqpSolver, Start, check_vectors, settle
from fesloop.errors import InputError

Array = NDArray[np.float64]
_EMPTY = np.empty(0)
_SLACK = 10.0
"""Accepted constraint violation in units of the tolerance, as in `qp`."""
_SOUND, _NOT_FINITE = 0, 1


def solve_sparse(
    hessian: sparse.csc_matrix, rows: sparse.csc_matrix, q: Array, lower: Array, upper: Array, *,
    tolerance: float = 1e-6, max_iterations: int = 20000, start: QpResult | None = None,
) -> QpResult:
    """Solve by OSQP; every failure is a status of the result.

    Parameters
    ----------
    hessian: H (n, n), symmetric, positive semidefinite.
    rows: A (m, n).
    q: (n,).
    lower, upper: (n + m,), boxes first; infinite bounds are allowed.
    start: answer of a programme like this one, to start from; zero if not given.

    Raises InputError for shapes that do not fit and for a matrix that is not finite.
    """
    size, constraints = hessian.shape[0], hessian.shape[0] + rows.shape[0]
    if hessian.shape != (size, size) or rows.shape[1] != size:
        raise InputError("qp", f"a Hessian {hessian.shape} with rows {rows.shape}", "(n, n) with (m, n)")
    for name, vector, wanted in (("q", q, size), ("lower", lower, constraints),
                                 ("upper", upper, constraints)):
        if vector.shape != (wanted,):
            raise InputError(f"qp {name}", f"shape {vector.shape}", f"({wanted},)")
    if not (np.isfinite(hessian.data).all() and np.isfinite(rows.data).all()):
        raise InputError("qp", "a matrix that is not finite", "finite values")
    q, lower, upper = (np.ascontiguousarray(each, dtype=np.float64) for each in (q, lower, upper))
    fault = check_vectors(q, lower, upper)
    if fault != _SOUND:
        return QpResult("non_finite" if fault == _NOT_FINITE else "infeasible", _EMPTY, _EMPTY, 0)
    solver = OsqpSolver(hessian, rows, tolerance, max_iterations)
    if start is not None:
        solver.restart(Start(start.x, start.multipliers))
    outcome, x, multipliers, iterations = solver.solve(q, lower, upper)
    if outcome == "":
        compressed = sparse.csr_matrix(rows)
        finite, broken = settle(x, lower, upper, compressed.indptr.astype(np.int64),
                                compressed.indices.astype(np.int64), compressed.data.astype(np.float64))
        outcome = "non_finite" if not finite else "inaccurate" if broken > _SLACK * tolerance else ""
    if outcome:
        return QpResult(outcome, _EMPTY, _EMPTY, iterations)
    return QpResult("solved", x, multipliers, iterations)
