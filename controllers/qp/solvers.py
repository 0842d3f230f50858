"""daqp and OSQP behind one face: problems with fixed matrices and changing vectors.

Both solvers carry hidden state from solve to solve (working set and its factors; iterates and step size).
`restart` replaces all of it by a declared start, so that what follows is a function of the start and of
the problems since: that is what makes a restored solver go on bit for bit.
"""

from __future__ import annotations

import math
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from fesloop.compiled import compiled

Array = NDArray[np.float64]
_DAQP = {1: "", -1: "infeasible", -2: "infeasible", -3: "unbounded", -4: "iteration_limit"}
_OSQP = {1: "", 2: "inaccurate", 3: "infeasible", 4: "infeasible", 5: "unbounded", 6: "unbounded",
         7: "iteration_limit", 8: "iteration_limit", 9: "not_convex"}
_OSQP_INTERRUPTED = 10


class Start(NamedTuple):
    """Where a solver starts from: x (n,) and multipliers (n + m,), boxes first, positive at upper bounds."""

    x: Array
    multipliers: Array


class Answer(NamedTuple):
    """What a solver claims: outcome ("" for solved), x, multipliers, iterations."""

    outcome: str
    x: Array
    multipliers: Array
    iterations: int


class Solver(Protocol):
    """min 1/2 x'Hx + q'x, lower <= [I; A] x <= upper; without `linear` there is no q."""

    def __init__(
        self, hessian: Array, rows: Array, tolerance: float, max_iterations: int, linear: bool
    ) -> None:
        """For H (n, n) and A (m, n)."""

    def restart(self, start: Start) -> None:
        """Forget everything; go on from `start`."""

    def solve(self, q: Array | None, lower: Array, upper: Array) -> Answer:
        """Solve, q None if there is none; the arrays are never written to again by anyone."""


class DaqpSolver:
    """Dense dual active set (Arnstrom, Bemporad and Axehill 2022, doi 10.1109/TAC.2022.3176430).

    Parameters
    ----------
    hessian, rows: H (n, n), positive definite, and A (m, n).
    tolerance: primal tolerance.
    max_iterations: of the active set.
    linear: whether there is a q. Without one, its product with every constraint need not be made anew at
        each update, which is half of the work of a warm solve.
    """

    def __init__(
        self, hessian: Array, rows: Array, tolerance: float, max_iterations: int, linear: bool = True
    ) -> None:
        import daqp

        n, constraints = hessian.shape[0], hessian.shape[0] + rows.shape[0]
        self._sense = np.zeros(constraints, dtype=np.int32)
        self._restarted = True
        self._model = daqp.Model()
        flag, _ = self._model.setup(
            np.ascontiguousarray(hessian), np.zeros(n) if linear else None, np.ascontiguousarray(rows),
            np.ones(constraints), np.zeros(constraints), self._sense)
        if flag < 0:
            raise ValueError(f"daqp refuses the matrices with flag {flag}")
        self._model.settings = {"primal_tol": tolerance, "iter_limit": max_iterations}

    def restart(self, start: Start) -> None:
        """Start from the constraints whose multiplier is not zero."""
        active = np.where(start.multipliers > 0.0, 1, np.where(start.multipliers < 0.0, 3, 0))
        self._sense = active.astype(np.int32)
        self._restarted = True

    def solve(self, q: Array | None, lower: Array, upper: Array) -> Answer:
        """By the working set of the last solve, or that of the start."""
        if self._restarted:
            flag = self._model.update(f=q, bupper=upper, blower=lower, sense=self._sense)
            self._restarted = False
        else:
            flag = self._model.update(f=q, bupper=upper, blower=lower)
        if flag < 0:
            return Answer("infeasible", lower, upper, 0)
        x, _, flag, told = self._model.solve()
        return Answer(_DAQP.get(flag, f"daqp flag {flag}"), x, told["lam"], told["iterations"])


class OsqpSolver:
    """Sparse operator splitting (Stellato et al. 2020, doi 10.1007/s12532-020-00179-2).

    Parameters as of `DaqpSolver`; `tolerance` is both eps_abs and eps_rel.
    """

    def __init__(self, hessian: Array | sparse.csc_matrix, rows: Array | sparse.csc_matrix, tolerance: float,
                 max_iterations: int, linear: bool = True) -> None:
        n = hessian.shape[0]
        self._upper_half = sparse.triu(sparse.csc_matrix(hessian), format="csc")
        self._rows = sparse.vstack([sparse.eye(n), sparse.csc_matrix(rows)], format="csc")
        self._settings = {"eps_abs": tolerance, "eps_rel": tolerance, "max_iter": max_iterations,
                          "verbose": False, "polishing": False, "check_termination": 25,
                          # By count, never by time: equal problems take equal steps on any machine.
                          "adaptive_rho": 1, "adaptive_rho_interval": 50}
        self._start: Start | None = Start(np.zeros(n), np.zeros(self._rows.shape[0]))
        self._size = n

    def restart(self, start: Start) -> None:
        """Start from x and multipliers, with the step size as given at set-up."""
        self._start = start

    def solve(self, q: Array | None, lower: Array, upper: Array) -> Answer:
        """From the iterates of the last solve, or the start."""
        if self._start is not None:
            import osqp

            self._solver = osqp.OSQP()
            self._solver.setup(self._upper_half, np.zeros(self._size) if q is None else q, self._rows,
                               lower, upper, **self._settings)
            self._solver.warm_start(x=self._start.x, y=self._start.multipliers)
            self._start = None
        else:
            self._solver.update(q=q, l=lower, u=upper)
        result = self._solver.solve(raise_error=False)
        if result.info.status_val == _OSQP_INTERRUPTED:
            raise KeyboardInterrupt
        return Answer(_OSQP.get(result.info.status_val, result.info.status),
                      result.x.copy(), result.y.copy(), int(result.info.iter))


SOUND, NOT_FINITE, CROSSED, MISSHAPEN = 0, 1, 2, 3
"""Faults of the vectors of a programme."""


@compiled
def check_vectors(q: Array, lower: Array, upper: Array) -> int:
    """SOUND, NOT_FINITE (or infinity as a bound's wrong side), or CROSSED bounds."""
    for i in range(q.size):
        if not math.isfinite(q[i]):
            return NOT_FINITE
    fault = SOUND
    for i in range(lower.size):
        if math.isnan(lower[i]) or math.isnan(upper[i]) or lower[i] == math.inf or upper[i] == -math.inf:
            return NOT_FINITE
        if lower[i] > upper[i]:
            fault = CROSSED
    return fault


@compiled
def minus_product(matrix: Array, vector: Array) -> Array:
    """Minus a symmetric matrix times a vector, fresh, summed in a fixed order."""
    product = np.zeros(vector.size)
    for j in range(vector.size):
        for i in range(vector.size):
            product[i] -= matrix[j, i] * vector[j]
    return product


@compiled
def around(
    centre: Array, lower: Array, upper: Array, below: Array, above: Array, indptr: NDArray[np.int64],
    indices: NDArray[np.int64], values: Array,
) -> int:
    """Fill `below` and `above` with the bounds less the constrained quantities at the centre; the fault.

    `indptr`, `indices`, `values` are the rows, compressed.
    """
    size = centre.size
    if size != below.size - indptr.size + 1 or lower.size != below.size or upper.size != below.size:
        return MISSHAPEN
    fault: int = check_vectors(centre, lower, upper)
    for i in range(size):
        below[i], above[i] = lower[i] - centre[i], upper[i] - centre[i]
    for row in range(indptr.size - 1):
        total = 0.0
        for k in range(indptr[row], indptr[row + 1]):
            total += values[k] * centre[indices[k]]
        below[size + row], above[size + row] = lower[size + row] - total, upper[size + row] - total
    return fault


@compiled
def settle(
    x: Array, lower: Array, upper: Array, indptr: NDArray[np.int64], indices: NDArray[np.int64], values: Array
) -> tuple[bool, float]:
    """Clip x into its boxes, in place; (whether x is finite, worst violation relative to 1 + |bound|)."""
    worst = 0.0
    for i in range(x.size):
        if not math.isfinite(x[i]):
            return False, 0.0
        bound = min(max(x[i], lower[i]), upper[i])
        worst = max(worst, abs(x[i] - bound) / (1.0 + abs(bound)))
        x[i] = bound
    for row in range(indptr.size - 1):
        total = 0.0
        for k in range(indptr[row], indptr[row + 1]):
            total += values[k] * x[indices[k]]
        bound = min(max(total, lower[x.size + row]), upper[x.size + row])
        worst = max(worst, abs(total - bound) / (1.0 + abs(bound)))
    return True, worst
