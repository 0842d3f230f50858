"""Linear systems under zero-order hold, advanced exactly by any whole number of nanoseconds.

A duration is split into decimal digits. The step over each digit at each place, such as 3 000 000 ns, is a
matrix exponential computed when its place is first needed; a duration is the product of its digits' steps,
applied to the state one after the other. The result is therefore a function of state and duration alone,
independent of earlier calls, bit for bit. Whole milliseconds take a product or two, durations with jitter a
few
more, and the table stays small: 10 matrices per place, 8 places up to 100 ms.

Sums have a fixed order, a row of the transposed matrix at a time, which vectorises and gives the same bits
for any alignment of the arrays in memory; a BLAS does not guarantee that.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from fesloop.compiled import compiled
from fesloop.loop.clock import NS_PER_S
from fesloop.models.linear_model import zero_order_hold

Array = NDArray[np.float64]
_DIGITS = 10
NEGLIGIBLE = 1e-100
"""Values below this become zero, as a system at rest would otherwise decay into denormal numbers, which are
slow."""


@compiled
def step_held(step_t: Array, z: Array) -> None:
    """Set z[:n] to [Phi Gamma] z; `step_t` (n + m, n) is the transpose of [Phi Gamma]."""
    states = step_t.shape[1]
    after = np.zeros(states)
    for j in range(z.size):
        for i in range(states):
            after[i] += step_t[j, i] * z[j]
    for i in range(states):
        z[i] = after[i] if abs(after[i]) > NEGLIGIBLE else 0.0


@compiled
def advance_digits(table: Array, z: Array, duration_ns: int, after: Array) -> None:
    """Apply the steps of the duration's digits, lowest place first, to z; `after` (n,) is scratch."""
    place = 0
    while duration_ns > 0:
        digit = duration_ns % 10
        if digit:
            for i in range(after.size):
                after[i] = 0.0
            for j in range(z.size):
                factor = z[j]
                for i in range(after.size):
                    after[i] += table[place, digit, j, i] * factor
            for i in range(after.size):
                z[i] = after[i] if abs(after[i]) > NEGLIGIBLE else 0.0
        duration_ns //= 10
        place += 1


@compiled
def advance_held(table: Array, z: Array, duration_ns: int) -> None:
    """Advance z by a duration, in place."""
    advance_digits(table, z, duration_ns, np.empty(table.shape[3]))


@compiled
def read_outputs(output_t: Array, z: Array, y: Array) -> None:
    """Set y to offset + [c d] z; `output_t` stacks offset, c' and d' (no d' if d is zero)."""
    for i in range(y.size):
        y[i] = output_t[0, i]
    for j in range(output_t.shape[0] - 1):
        factor = z[j]
        for i in range(y.size):
            y[i] += output_t[j + 1, i] * factor


@compiled
def read_first(output_t: Array, z: Array) -> float:
    """First output alone, as a float."""
    first = output_t[0, 0]
    for j in range(output_t.shape[0] - 1):
        first += output_t[j + 1, 0] * z[j]
    return float(first)


@compiled
def read_ahead(
    table: Array, output_t: Array, z: Array, start_ns: int, times_ns: NDArray[np.int64], rows: Array
) -> None:
    """Fill `rows` with the outputs at `times_ns`, from z at `start_ns`, which is not changed."""
    ahead, after = np.empty(z.size), np.empty(table.shape[3])
    for k in range(times_ns.size):
        for i in range(z.size):
            ahead[i] = z[i]
        advance_digits(table, ahead, times_ns[k] - start_ns, after)
        read_outputs(output_t, ahead, rows[k])


class HeldLinearSystem:
    """A linear system x' = a x + b u, y = c x + d u + offset under zero-order hold.

    Parameters
    ----------
    a, b, c, d: (n, n), (n, m), (p, n), (p, m); time in s.
    offset: (p,).

    The state z = [x; u] (n + m,), contiguous float64, belongs to the caller, who writes u into z[n:].
    """

    __slots__ = ("_output_t", "_outputs", "_reach_ns", "_table", "a", "b", "c", "d", "offset")

    def __init__(self, a: Array, b: Array, c: Array, d: Array, offset: Array) -> None:
        self.a, self.b, self.c, self.d, self.offset = a, b, c, d, offset
        rows = (offset[None], c.T, d.T) if d.any() else (offset[None], c.T)
        self._output_t = np.concatenate(rows).astype(np.float64, order="C")
        self._outputs = c.shape[0]
        self._table: Array = np.empty((0, _DIGITS, a.shape[0] + b.shape[1], a.shape[0]))
        self._reach_ns = 1

    def __reduce__(self) -> tuple[Any, ...]:
        return HeldLinearSystem, (self.a, self.b, self.c, self.d, self.offset)

    def step_matrix(self, duration_s: float) -> Array:
        """Transpose of [Phi Gamma] of one duration, (n + m, n), for `step_held`."""
        phi, gamma = zero_order_hold(self.a, self.b, duration_s)
        step_t = np.concatenate([phi.T, gamma.T])
        return np.where(np.abs(step_t) > NEGLIGIBLE, step_t, 0.0)

    def advance(self, z: Array, duration_ns: int) -> None:
        """Advance z by `duration_ns` (0 or more), in place."""
        if duration_ns >= self._reach_ns:
            self._extend(duration_ns)
        advance_held(self._table, z, duration_ns)

    def read(self, z: Array) -> Array:
        """Output y, (p,), in a new array."""
        outputs = np.empty(self._outputs)
        read_outputs(self._output_t, z, outputs)
        return outputs

    def read_first(self, z: Array) -> float:
        """First element of y, as a float."""
        first: float = read_first(self._output_t, z)
        return first

    def read_ahead(self, z: Array, start_ns: int, times_ns: NDArray[np.int64], rows: Array) -> None:
        """Fill `rows` (k, p) with y at `times_ns` (k,), ascending, from z at `start_ns`, not changed."""
        furthest = int(times_ns[-1]) - start_ns
        if furthest >= self._reach_ns:
            self._extend(furthest)
        read_ahead(self._table, self._output_t, z, start_ns, times_ns, rows)

    def _extend(self, duration_ns: int) -> None:
        """Extend the table to `duration_ns`."""
        places = len(str(duration_ns))
        first = self._table.shape[0]
        added = np.empty((places - first, *self._table.shape[1:]))
        for place in range(first, places):
            for digit in range(_DIGITS):
                added[place - first, digit] = self.step_matrix(digit * _DIGITS**place / NS_PER_S)
        self._table = np.concatenate([self._table, added])
        self._reach_ns = _DIGITS**places
