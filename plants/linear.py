"""Linear systems under held inputs, taken exactly over any whole number of nanoseconds.

A duration is split into hexadecimal digits. The step over each digit at each place, such as 0x30000 ns,
is one matrix exponential made when it is first wanted; a duration is the product of its digits' steps,
applied to the state one after the other. So the result is a function of the state and the duration alone
(no memory of what was asked before can change a bit of it), arbitrary durations cost no more than regular
ones, and the table stays small: 15 matrices a place.

The sums run in a fixed order, element by element, and so give the same bits wherever the arrays lie in
memory, which a BLAS does not promise.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.linalg import expm

from fesloop.loop.clock import NS_PER_S

Array = NDArray[np.float64]
_DIGIT_BITS = 4
_DIGITS = 1 << _DIGIT_BITS


@njit(cache=True)
def transposed_product(matrix_t: Array, vector: Array, out: Array) -> None:
    """Add `matrix_t`' times `vector` to `out`, a whole row at a time so that it vectorises."""
    for j in range(vector.size):
        factor = vector[j]
        for i in range(out.size):
            out[i] += matrix_t[j, i] * factor


@njit(cache=True)
def step_held(step_t: Array, x: Array, u: Array) -> None:
    """x := [Phi Gamma] [x; u] for `step_t` (n + m, n), the transpose of [Phi Gamma]."""
    states = x.size
    after = np.zeros(states)
    transposed_product(step_t, x, after)
    transposed_product(step_t[states:], u, after)
    x[:] = after


@njit(cache=True)
def advance_held(table: Array, x: Array, u: Array, duration_ns: int) -> None:
    """Apply the steps of the duration's digits, lowest place first, to x."""
    place = 0
    while duration_ns > 0:
        digit = duration_ns & 15
        if digit:
            step_held(table[place, digit], x, u)
        duration_ns >>= 4
        place += 1


@njit(cache=True)
def read_outputs(c_t: Array, d_t: Array, offset: Array, x: Array, u: Array) -> Array:
    """y = c x + d u + offset."""
    y = offset.copy()
    transposed_product(c_t, x, y)
    transposed_product(d_t, u, y)
    return y


@njit(cache=True)
def read_ahead(
    table: Array, c_t: Array, d_t: Array, offset: Array, x: Array, u: Array, later_ns: NDArray[np.int64]
) -> Array:
    """Rows of outputs after each of the durations `later_ns`, x untouched."""
    rows = np.empty((later_ns.size, offset.size))
    for k in range(later_ns.size):
        ahead = x.copy()
        advance_held(table, ahead, u, later_ns[k])
        rows[k] = read_outputs(c_t, d_t, offset, ahead, u)
    return rows


class HeldLinearSystem:
    """x' = a x + b u, y = c x + d u + offset, with u held.

    Parameters
    ----------
    a, b, c, d: (n, n), (n, m), (p, n), (p, m); time in s.
    offset: (p,).

    Holds no state: x (n,) and u (m,) are the caller's, contiguous float64.
    """

    __slots__ = ("_reach_ns", "_table", "a", "b", "c", "c_t", "d", "d_t", "offset")

    def __init__(self, a: Array, b: Array, c: Array, d: Array, offset: Array) -> None:
        self.a, self.b, self.c, self.d = a, b, c, d
        self.offset = np.array(offset, dtype=np.float64)
        self.c_t = np.ascontiguousarray(c.T, dtype=np.float64)
        self.d_t = np.ascontiguousarray(d.T, dtype=np.float64)
        self._table: Array = np.empty((0, _DIGITS, a.shape[0] + b.shape[1], a.shape[0]))
        self._reach_ns = 1

    def __reduce__(self) -> tuple[Any, ...]:
        return HeldLinearSystem, (self.a, self.b, self.c, self.d, self.offset)

    def step_matrix(self, duration_s: float) -> Array:
        """Transpose of [Phi Gamma] of one duration, (n + m, n), for `step_held`."""
        return self._exponentials(np.array([duration_s]))[0]

    def advance(self, x: Array, u: Array, duration_ns: int) -> None:
        """Take x over `duration_ns`, in place."""
        if duration_ns >= self._reach_ns:
            self._extend(duration_ns)
        advance_held(self._table, x, u, duration_ns)

    def read(self, x: Array, u: Array) -> Array:
        """y, (p,), fresh."""
        outputs: Array = read_outputs(self.c_t, self.d_t, self.offset, x, u)
        return outputs

    def read_ahead(self, x: Array, u: Array, later_ns: NDArray[np.int64]) -> Array:
        """y after each duration in `later_ns` (k,), (k, p), fresh; x is left alone."""
        furthest = int(later_ns[-1])
        if furthest >= self._reach_ns:
            self._extend(furthest)
        rows: Array = read_ahead(self._table, self.c_t, self.d_t, self.offset, x, u, later_ns)
        return rows

    def _extend(self, duration_ns: int) -> None:
        """Make the table reach `duration_ns`."""
        places = -(-duration_ns.bit_length() // _DIGIT_BITS)
        first = self._table.shape[0]
        added = np.empty((places - first, *self._table.shape[1:]))
        for place in range(first, places):
            added[place - first] = self._exponentials(np.arange(_DIGITS) * (_DIGITS**place / NS_PER_S))
        self._table = np.concatenate([self._table, added])
        self._reach_ns = 1 << (places * _DIGIT_BITS)

    def _exponentials(self, durations_s: Array) -> Array:
        """Transposes of [Phi Gamma], (k, n + m, n): Van Loan 1978, doi 10.1109/TAC.1978.1101743."""
        states, inputs = self.b.shape
        stacked = np.zeros((states + inputs, states + inputs))
        stacked[:states, :states], stacked[:states, states:] = self.a, self.b
        exponentials = expm(stacked * durations_s[:, None, None])
        return np.ascontiguousarray(exponentials[:, :states].transpose(0, 2, 1))
