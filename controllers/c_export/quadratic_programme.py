"""Settings, types and worst case of `quadratic_programme.c`, a dual active set method in C."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from controllers.quadratic_programme import DEFAULT_REFRESH, DEFAULT_TOLERANCE, SLACK
from fesloop.c_code.program import array, define

Array = NDArray[np.float64]
SOURCE = "quadratic_programme.c"
_PIVOT_LEAST, _MULTIPLIER, _DIRECTION = 3.7e-11, 1e-12, 1e-11
"""Tolerances of daqp 0.11, so that both solvers pass the same working sets."""
STATUSES = {"INFEASIBLE": "no drives within the limits",
            "ITERATION_LIMIT": "the programme was not solved in time",
            "INACCURATE": "the solution is not within the limits"}
TYPES = (
    "typedef struct {",
    "    int count, solves;                             /* of the working set; since it was factorised */",
    "    int set[BLOCK_UNKNOWNS + 1], side[BLOCK_BOUNDS]; /* rows in it; 1: upper bound, -1: lower */",
    "    double multiplier[BLOCK_UNKNOWNS + 1], target[BLOCK_UNKNOWNS + 1];",
    "    double lower[(BLOCK_UNKNOWNS + 1) * BLOCK_UNKNOWNS / 2], pivot[BLOCK_UNKNOWNS + 1]; /* L, D */",
    "    double u[BLOCK_UNKNOWNS], low[BLOCK_BOUNDS], high[BLOCK_BOUNDS], scratch[BLOCK_UNKNOWNS + 1];",
    "} block_qp;",
    "",
)


def settings(hessian: Array, rows: Array, iterations: int) -> tuple[str, ...]:
    """Constants of a programme with H (n, n) and rows A (m, n), solved in fewer than `iterations`."""
    constraint, length = normalised(hessian, rows)
    return (
        define("ITERATIONS_MAX", iterations, "working sets tried in a step"),
        define("REFRESH", DEFAULT_REFRESH, "solves from one factorisation to the next"),
        define("BOUND_TOLERANCE", DEFAULT_TOLERANCE, "tolerated violation of a bound"),
        define("ACCEPTED", SLACK * DEFAULT_TOLERANCE,
               "violation, relative to 1 + |bound|, of an accepted solution"),
        define("PIVOT_LEAST", _PIVOT_LEAST, "pivot below which a working set is dependent"),
        define("MULTIPLIER_TOLERANCE", _MULTIPLIER, "tolerated multiplier of the wrong sign"),
        define("DIRECTION_TOLERANCE", _DIRECTION, "the same in a direction of a dependent set"),
        "",
        array("LENGTH", length, "length of each row of the constraints in u"),
        array("CONSTRAINT", constraint, "unknowns, then rows, from u = R z; unit length"),
    )


def normalised(hessian: Array, rows: Array) -> tuple[Array, Array]:
    """Unknowns and rows as functions of u = R z, H = R'R: rows of unit length, and the lengths they had."""
    inverse = np.linalg.inv(np.linalg.cholesky(hessian).T)
    constraint = np.vstack([np.triu(inverse), rows @ np.triu(inverse)])
    length = np.linalg.norm(constraint, axis=1)
    return constraint / length[:, np.newaxis], length


class WorstCase(NamedTuple):
    """Upper bounds of operations: of the start, of a working set, and at the end of a solve."""

    start: int
    iteration: int
    last: int


def worst_case(unknowns: int, bounds: int) -> WorstCase:
    """Operations of `solve_qp`."""
    n, active = unknowns, unknowns + 1
    append = 2 * n * (active + 1) + active**2 + 4 * active
    iteration = (2 * active**2 + active + 8 * active + 2 * active * n + bounds * (2 * n + 8)
                 + max(append, 2 * active**2 + 10 * active))
    return WorstCase(active * append, iteration, n * (2 * n + 1) + active * (2 * active + 4 * n + 1))
