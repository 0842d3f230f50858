"""daqp and OSQP behind one face: problems with fixed matrices and changing vectors.

Both solvers carry hidden state from solve to solve (working set and its factors; iterates and step size).
`restart` replaces all of it by a declared start, so that what follows is a function of the start and of
the problems since: that is what makes a restored solver go on bit for bit.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

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
