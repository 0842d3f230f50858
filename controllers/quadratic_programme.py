"""Solver of quadratic programmes that reports every failure and never returns a silently wrong solution.

    min 1/2 x'Hx + q'x   subject to   lower <= [x; A x] <= upper

H and A are fixed when a `Qp` is made; q and the bounds come with each solve. Where the minimum without
constraints is known, c = -H^-1 q, a `centred` programme takes c in place of q and has daqp find

    min 1/2 z'Hz   subject to   lower - [c; A c] <= [z; A z] <= upper - [c; A c],   x = c + z

which halves its work. OSQP, whose tolerances are relative to the size of the bounds, always takes q.
"""

from __future__ import annotations

import math
from typing import Any, Literal, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from fesloop.compiled import compiled
from fesloop.errors import InputError

Array = NDArray[np.float64]
_DAQP = {1: "", -1: "infeasible", -2: "infeasible", -3: "unbounded", -4: "iteration_limit"}
_OSQP = {1: "", 2: "inaccurate", 3: "infeasible", 4: "infeasible", 5: "unbounded", 6: "unbounded",
         7: "iteration_limit", 8: "iteration_limit", 9: "not_convex"}
_OSQP_INTERRUPTED = 10


class Start(NamedTuple):
    """Start of a solver: x (n,) and multipliers (n + m,), boxes first, positive at upper bounds."""

    x: Array
    multipliers: Array


class Answer(NamedTuple):
    """Unchecked result of a solver: outcome ("" for solved), x, multipliers, iterations."""

    outcome: str
    x: Array
    multipliers: Array
    iterations: int


class Solver(Protocol):
    """Solver of min 1/2 x'Hx + q'x, lower <= [I; A] x <= upper; without `linear` there is no q."""

    def __init__(
        self, hessian: Array, rows: Array, tolerance: float, max_iterations: int, linear: bool
    ) -> None:
        """Set up for H (n, n) and A (m, n)."""

    def restart(self, start: Start) -> None:
        """Discard all memory and continue from `start`."""

    def solve(self, q: Array | None, lower: Array, upper: Array) -> Answer:
        """Solve; q may be None. The arrays must never be written to afterwards."""


class DaqpSolver:
    """Dense dual active set (Arnstrom, Bemporad and Axehill 2022, doi 10.1109/TAC.2022.3176430).

    Parameters
    ----------
    hessian, rows: H (n, n), positive definite, and A (m, n).
    tolerance: primal tolerance.
    max_iterations: limit on the iterations of the active set.
    linear: whether there is a q. Without one, its product with every constraint is not recomputed at each
        update, which is half of the work of a warm solve.
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
        """Solve from the working set of the last solve, or of the start."""
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

    Parameters are as in `DaqpSolver`; `tolerance` is both eps_abs and eps_rel.
    """

    def __init__(self, hessian: Array | sparse.csc_matrix, rows: Array | sparse.csc_matrix, tolerance: float,
                 max_iterations: int, linear: bool = True) -> None:
        n = hessian.shape[0]
        self._upper_half = sparse.triu(sparse.csc_matrix(hessian), format="csc")
        self._rows = sparse.vstack([sparse.eye(n), sparse.csc_matrix(rows)], format="csc")
        self._settings = {"eps_abs": tolerance, "eps_rel": tolerance, "max_iter": max_iterations,
                          "verbose": False, "polishing": False, "check_termination": 25,
                          # The limit is a count, not a time: equal problems take equal steps on any machine.
                          "adaptive_rho": 1, "adaptive_rho_interval": 50}
        self._start: Start | None = Start(np.zeros(n), np.zeros(self._rows.shape[0]))
        self._size = n

    def restart(self, start: Start) -> None:
        """Start from x and multipliers, with the step size as given at set-up."""
        self._start = start

    def solve(self, q: Array | None, lower: Array, upper: Array) -> Answer:
        """Solve from the iterates of the last solve, or of the start."""
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
"""Fault codes of the vectors of a programme."""


@compiled
def check_vectors(q: Array, lower: Array, upper: Array) -> int:
    """Fault code: SOUND, NOT_FINITE (or infinity on a bound's wrong side), or CROSSED bounds."""
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
    """New vector: minus a symmetric matrix times a vector, summed in a fixed order."""
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
    """Fill `below` and `above` with the bounds relative to the centre; return the fault code.

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
    """Clip x to its boxes, in place; return whether it is finite, and its worst relative violation.

    Violations are relative to 1 + |bound|.
    """
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


SolverName = Literal["daqp", "osqp"]
SOLVERS: dict[str, type[Solver]] = {"daqp": DaqpSolver, "osqp": OsqpSolver}
_EMPTY = np.empty(0)
DEFAULT_TOLERANCE, DEFAULT_ITERATIONS, DEFAULT_REFRESH = 1e-6, 4000, 128
"""Tolerance, iterations and solves between restarts of a `Qp`, if not given."""
SLACK = 10.0
"""Accepted constraint violation in units of the tolerance: solvers bound it in scaled norms of their own."""


class QpResult(NamedTuple):
    """Result of a solve.

    Attributes
    ----------
    status: "solved"; else "infeasible", "iteration_limit", "non_finite", "inaccurate" (x violates a
        constraint), "unbounded", or another outcome of the solver.
    x: (n,), inside the boxes exactly and inside the rows within 10 x tolerance x (1 + |bound|); of size 0
        unless solved.
    multipliers: (n + m,), boxes first, positive at upper bounds; of size 0 unless solved.
    iterations: iterations of the solver.
    """

    status: str
    x: Array
    multipliers: Array
    iterations: int

    @property
    def solved(self) -> bool:
        """Whether `x` is a solution."""
        return self.status == "solved"


class Qp:
    """A quadratic programme with fixed matrices, warm-started from solve to solve.

    It can be pickled, and a restored one continues bit for bit: every `refresh` solves the solver restarts
    from its last solution, and the problems since then are stored and solved again on restoring.

    Parameters
    ----------
    hessian: H (n, n), symmetric positive definite.
    rows: A (m, n); m may be 0.
    solver: "daqp" (dense, exact: small problems) or "osqp" (sparse, iterative: large ones).
    tolerance: tolerance on constraints, and for osqp on optimality.
    max_iterations: iterations of the solver above which the result is "iteration_limit".
    refresh: number of solves between restarts.
    centred: whether `solve` takes c in place of q.

    Raises InputError for matrices of wrong shape, non-finite, not symmetric or not positive definite.
    """

    __slots__ = ("_centred", "_hessian", "_last", "_log", "_options", "_rows", "_shifts", "_size", "_solver",
                 "_sparse_rows", "_start")

    def __init__(self, hessian: Array, rows: Array, *, solver: SolverName = "daqp",
                 tolerance: float = DEFAULT_TOLERANCE, max_iterations: int = DEFAULT_ITERATIONS,
                 refresh: int = DEFAULT_REFRESH, centred: bool = False) -> None:
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

        A centred programme with daqp ignores x: the multipliers show which constraints are active.
        """
        given = _vector("x", x, self.size)
        duals = np.zeros(self.constraints) if multipliers is None else multipliers
        self._restart(Start(given, _vector("multipliers", duals, self.constraints)))

    def solve(self, q: Array, lower: Array, upper: Array) -> QpResult:
        """Solve for q (n,) and bounds (n + m,), boxes first; infinite bounds are allowed.

        A centred programme takes c (n,) in place of q, and may store the vectors without copying them: they
        must never be written to again. Raises InputError for a vector of the wrong shape; any other failure
        is a status of the result.
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
        """Solve a centred programme whose bounds the caller has computed as `around` does, to the bit.

        This saves compiled callers a call; OSQP does not use it.
        """
        if not self._shifts:
            return self.solve(centre, lower, upper)
        if fault == MISSHAPEN:
            raise InputError("qp", f"vectors of {centre.size}, {lower.size} and {upper.size}",
                             f"{self.size}, {self.constraints} and {self.constraints}")
        return self._solve(None, centre, lower, upper, below, above, fault)

    def _solve(self, linear: Array | None, q: Array, lower: Array, upper: Array, below: Array, above: Array,
               fault: int) -> QpResult:
        """Solve with `linear` and the bounds `below` and `above`; q, lower and upper are the caller's."""
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
            elif broken > SLACK * self._options[1]:
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
    """The matrices as contiguous float64; raises InputError for others."""
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
    """A contiguous float64 copy of (size,) values; raises InputError for another shape."""
    vector = np.array(values, dtype=np.float64, order="C")
    if vector.shape != (size,):
        raise InputError(f"qp {name}", f"shape {vector.shape}", f"({size},)")
    return vector


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
    start: solution of a similar programme to start from; zero if not given.

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
        outcome = "non_finite" if not finite else "inaccurate" if broken > SLACK * tolerance else ""
    if outcome:
        return QpResult(outcome, _EMPTY, _EMPTY, iterations)
    return QpResult("solved", x, multipliers, iterations)
