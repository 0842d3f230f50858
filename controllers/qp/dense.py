"""One way to solve a quadratic programme, that never hands back a silently wrong answer.

    min 1/2 x'Hx + q'x   subject to   lower <= [x; A x] <= upper

H and A are fixed when a `Qp` is made; q and the bounds come with each solve. Where the minimum without
constraints is known, c = -H^-1 q, a `centred` programme takes c in place of q and has daqp find

    min 1/2 z'Hz   subject to   lower - [c; A c] <= [z; A z] <= upper - [c; A c],   x = c + z

which spares it half of its work. OSQP, whose tolerances are relative to the size of the bounds, is given q.
"""

from __future__ import annotations

from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from controllers.qp.solvers import (
    MISSHAPEN,
    NOT_FINITE,
    SOUND,
    DaqpSolver,
    OsqpSolver,
    Solver,
    Start,
    around,
    check_vectors,
    minus_product,
    settle,
)
from fesloop.errors import InputError

Array = NDArray[np.float64]
SolverName = Literal["daqp", "osqp"]
SOLVERS: dict[str, type[Solver]] = {"daqp": DaqpSolver, "osqp": OsqpSolver}
_EMPTY = np.empty(0)
_SLACK = 10.0
"""Accepted constraint violation in units of the tolerance: solvers bound it in scaled norms of their own."""


class QpResult(NamedTuple):
    """What came of a solve.

    Attributes
    ----------
    status: "solved"; else "infeasible", "iteration_limit", "non_finite", "inaccurate" (the answer breaks
        a constraint), "unbounded", or what else the solver said.
    x: (n,), inside the boxes exactly and inside the rows within 10 x tolerance x (1 + |bound|); of size 0
        unless solved.
    multipliers: (n + m,), boxes first, positive at upper bounds; of size 0 unless solved.
    iterations: of the solver.
    """

    status: str
    x: Array
    multipliers: Array
    iterations: int

    @property
    def solved(self) -> bool:
        """Whether `x` is an answer."""
        return self.status == "solved"


class Qp:
    """A quadratic programme with fixed matrices, warm-started from solve to solve.

    It pickles, and a restored one goes on bit for bit: every `refresh` solves the solver is restarted from
    its last answer, and the problems since then are kept and solved again on restoring.

    Parameters
    ----------
    hessian: H (n, n), symmetric positive definite.
    rows: A (m, n); m may be 0.
    solver: "daqp" (dense, exact: small problems) or "osqp" (sparse, iterative: large ones).
    tolerance: on constraints, and for osqp on optimality.
    max_iterations: of the solver, above which the result is "iteration_limit".
    refresh: solves between restarts.
    centred: whether `solve` is given c in place of q.

    Raises InputError for matrices of wrong shape, non-finite, not symmetric or not positive definite.
    """

    __slots__ = ("_centred", "_hessian", "_last", "_log", "_options", "_rows", "_shifts", "_size", "_solver",
                 "_sparse_rows", "_start")

    def __init__(self, hessian: Array, rows: Array, *, solver: SolverName = "daqp", tolerance: float = 1e-6,
                 max_iterations: int = 4000, refresh: int = 128, centred: bool = False) -> None:
        hessian, rows = _checked_matrices(hessian, rows)
        if solver not in SOLVERS:
            raise InputError("solver", f"{solver!r}", ", ".join(SOLVERS))
        if not (0.0 < tolerance < 1.0) or max_iterations < 1 or refresh < 1:
            raise InputError("qp", f"tolerance {tolerance}, iterations {max_iterations}, refresh {refresh}",
                             "a tolerance inside 0 to 1, counts of 1 or more")
        self._hessian, self._rows, self._centred = hessian, rows, centred
        self._size = (hessian.shape[0], hessian.shape[0] + rows.shape[0])
        self._options: tuple[SolverName, float, int, int] = (solver, tolerance, max_iterations, refresh)
        compressed = sparse.csr_matrix(rows)
        self._sparse_rows = (compressed.indptr.astype(np.int64), compressed.indices.astype(np.int64),
                             compressed.data.astype(np.float64))
        self._shifts = centred and solver == "daqp"
        self._solver: Solver = SOLVERS[solver](hessian, rows, tolerance, max_iterations, not self._shifts)
        self._log: list[tuple[Array, Array, Array]] = []
        self._start = self._last = Start(np.zeros(self.size), np.zeros(self.constraints))

    @property
    def size(self) -> int:
        """Number n of unknowns."""
        return int(self._size[0])

    @property
    def constraints(self) -> int:
        """Number n + m of bounded quantities, boxes first."""
        return int(self._size[1])

    def start_from(self, x: Array, multipliers: Array | None = None) -> None:
        """Warm-start the next solve from x (n,) and multipliers (n + m,), zero if not given.

        A centred programme with daqp takes no notice of x: the multipliers say which constraints hold.
        """
        given = _vector("x", x, self.size)
        duals = np.zeros(self.constraints) if multipliers is None else multipliers
        self._restart(Start(given, _vector("multipliers", duals, self.constraints)))

    def solve(self, q: Array, lower: Array, upper: Array) -> QpResult:
        """Solve for q (n,) and bounds (n + m,), boxes first; infinite bounds are allowed.

        A centred programme takes c (n,) in place of q, and may keep the vectors without copying them: nobody
        may write to them again. Raises InputError for a vector of the wrong shape; everything else is a
        status of the result.
        """
        if self._shifts:
            below, above = np.empty(self._size[1]), np.empty(self._size[1])
            fault = around(q, lower, upper, below, above, *self._sparse_rows)
            return self.solve_around(q, lower, upper, below, above, fault)
        q = _vector("q", q, self.size)
        lower = _vector("lower", lower, self.constraints)
        upper = _vector("upper", upper, self.constraints)
        return self._solve(minus_product(self._hessian, q) if self._centred else q, q, lower, upper, lower,
                           upper, check_vectors(q, lower, upper))

    def solve_around(
        self, centre: Array, lower: Array, upper: Array, below: Array, above: Array, fault: int
    ) -> QpResult:
        """Solve a centred programme of which the caller has found what `qp.kernel.around` finds, to the bit.

        For compiled callers, whom it spares a call; OSQP has no use of it.
        """
        if not self._shifts:
            return self.solve(centre, lower, upper)
        if fault == MISSHAPEN:
            raise InputError("qp", f"vectors of {centre.size}, {lower.size} and {upper.size}",
                             f"{self.size}, {self.constraints} and {self.constraints}")
        return self._solve(None, centre, lower, upper, below, above, fault)

    def _solve(self, linear: Array | None, q: Array, lower: Array, upper: Array, below: Array, above: Array,
               fault: int) -> QpResult:
        """Solve with `linear` and the bounds `below` and `above`; q, lower and upper are as given."""
        if fault != SOUND:
            return QpResult("non_finite" if fault == NOT_FINITE else "infeasible", _EMPTY, _EMPTY, 0)
        if len(self._log) >= self._options[3]:
            self._restart(self._last)
        self._log.append((q, lower, upper))
        outcome, z, multipliers, iterations = self._solver.solve(linear, below, above)
        x = z
        if outcome == "":
            x = q + z if self._shifts else z
            finite, broken = settle(x, lower, upper, *self._sparse_rows)
            if not finite:
                outcome = "non_finite"
            elif broken > _SLACK * self._options[1]:
                outcome = "inaccurate"
        if outcome != "":
            self._restart(Start(np.zeros(self.size), np.zeros(self.constraints)))
            return QpResult(outcome, _EMPTY, _EMPTY, iterations)
        self._last = Start(z, multipliers)
        return QpResult("solved", x, multipliers, iterations)

    def _restart(self, start: Start) -> None:
        self._log.clear()
        self._start = self._last = start
        self._solver.restart(start)

    def __getstate__(self) -> dict[str, Any]:
        return {"hessian": self._hessian, "rows": self._rows, "options": self._options,
                "centred": self._centred, "start": self._start, "log": list(self._log)}

    def __setstate__(self, saved: dict[str, Any]) -> None:
        solver, tolerance, max_iterations, refresh = saved["options"]
        Qp.__init__(self, saved["hessian"], saved["rows"], solver=solver, tolerance=tolerance,
                    max_iterations=max_iterations, refresh=refresh, centred=saved["centred"])
        self._restart(saved["start"])
        for q, lower, upper in saved["log"]:
            self.solve(q, lower, upper)


def _checked_matrices(hessian: Array, rows: Array) -> tuple[Array, Array]:
    """The matrices as contiguous float64, or InputError."""
    hessian = np.ascontiguousarray(hessian, dtype=np.float64)
    rows = np.ascontiguousarray(rows, dtype=np.float64)
    if hessian.ndim != 2 or hessian.shape[0] != hessian.shape[1] or hessian.shape[0] == 0:
        raise InputError("qp hessian", f"shape {hessian.shape}", "square")
    if rows.ndim != 2 or rows.shape[1] != hessian.shape[0]:
        raise InputError("qp rows", f"shape {rows.shape}", f"(m, {hessian.shape[0]})")
    if not (np.isfinite(hessian).all() and np.isfinite(rows).all()):
        raise InputError("qp", "a matrix that is not finite", "finite values")
    if np.abs(hessian - hessian.T).max() > 1e-9 * np.abs(hessian).max():
        raise InputError("qp hessian", "not symmetric", "symmetric positive definite")
    try:
        np.linalg.cholesky(hessian)
    except np.linalg.LinAlgError:
        raise InputError("qp hessian", "not positive definite", "symmetric positive definite",
                         "give every unknown a positive weight") from None
    return hessian, rows


def _vector(name: str, values: Array, size: int) -> Array:
    """A contiguous float64 copy of (size,) values; InputError for another shape."""
    vector = np.array(values, dtype=np.float64, order="C")
    if vector.shape != (size,):
        raise InputError(f"qp {name}", f"shape {vector.shape}", f"({size},)")
    return vector
