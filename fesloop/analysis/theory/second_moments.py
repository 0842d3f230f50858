"""Second moments of a loop at rest: the exact recursion of a Markov jump linear system, and where it stands.

With z the state and j the state of the chain, X_j = E[z z' 1(chain in j)] becomes M X_j M' + p_j W over a
flow, and T_j (sum of p_ij X_i) T_j' over a draw, where T_j takes rows: a linear operator on the X_j and a
constant. At rest they solve a linear equation, and they are bounded if the operator's spectral radius is
below 1 (Costa, Fragoso and Marques 2005, Discrete-Time Markov Jump Linear Systems, ch. 3, doi
10.1007/b138575, for a chain in one step; here a period is a product of such steps). Nothing is sampled or
approximated. Control loops with random delays were treated so by Nilsson 1998, Real-Time Control Systems with
Delays, thesis, Lund Institute of Technology, for delays below a period.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.linalg import ArpackError, LinearOperator, eigs, gmres

from fesloop.analysis.theory.linear_loop import within_floats
from fesloop.analysis.theory.period_map import PeriodMap
from fesloop.analysis.theory.steps import Draw, Flow
from fesloop.errors import RunError

Array = NDArray[np.float64]
_ACCURACY = 1e-10
"""Of solutions and eigenvalues, relative: far below what a simulation tells apart (chosen)."""
_PERIODS = 4
"""At a time, for GMRES and Arnoldi: as many products, but a quarter of the vectors to keep orthogonal, which
takes longer (chosen, measured)."""
_MOST_SQUARINGS = 64
_MOST_NUMBERS = 2**25
"""Of the vectors that GMRES keeps between restarts (chosen: 256 MB)."""


class SecondMoments:
    """The recursion over one period.

    Parameters
    ----------
    period: of the loop.

    Moments are (states of the chain, n, n) arrays as the period begins.
    """

    def __init__(self, period: PeriodMap) -> None:
        self._period = period
        last = period.steps[-1]
        size = len(last.matrix) if isinstance(last, Flow) else last.takes.shape[1]
        self.shape = (period.chain.size, size, size)

    @property
    def numbers(self) -> int:
        """How many numbers the moments are."""
        return int(np.prod(self.shape))

    def after(self, moments: Array, noise: bool) -> Array:
        """A period later; the homogeneous operator alone where not `noise`."""
        chances = self._period.chain
        for step in self._period.steps:
            if isinstance(step, Draw):
                moments, chances = _drawn(step, moments, chances)
            else:
                moments = step.matrix @ moments @ step.matrix.T
                if noise:
                    moments = moments + chances[:, None, None] * step.covariance
        return moments

    @within_floats("the second moments at rest")
    def at_rest(self) -> Array:
        """The stationary moments of a loop that is mean-square stable; others have none."""
        matrix = self._period.matrix
        noise = self.after(np.zeros(self.shape), noise=True)
        if matrix is not None:
            return _summed(matrix, noise[0])[np.newaxis]
        for _ in range(_PERIODS - 1):
            noise = self.after(noise, noise=True)
        return self._solved(noise)

    def _solved(self, noise: Array) -> Array:
        """X = operator X + noise by GMRES, over `_PERIODS` of them."""
        size = noise.size
        operator = LinearOperator((size, size), matvec=lambda x: x - self._flat(x), dtype=np.float64)
        restart = int(np.clip(_MOST_NUMBERS // size, 20, 200))
        found, trouble = gmres(operator, noise.ravel(), rtol=_ACCURACY, restart=restart, maxiter=20)
        if trouble:
            raise RunError("the stationary second moments were not found: the loop hardly comes to rest")
        return np.asarray(found).reshape(self.shape)

    def _flat(self, numbers: Array) -> Array:
        """The operator of `_PERIODS` periods."""
        moments = numbers.reshape(self.shape)
        for _ in range(_PERIODS):
            moments = self.after(moments, noise=False)
        return moments.ravel()

    @within_floats("the growth of second moments")
    def spectral_radius(self) -> float:
        """Of the operator: the factor by which second moments grow in a period, in the long run."""
        matrix = self._period.matrix
        if not all(np.isfinite(step.matrix).all() for step in self._period.steps if isinstance(step, Flow)):
            raise RunError("the growth of second moments was not found: within a period it is beyond floats")
        if matrix is not None:
            return float(np.abs(np.linalg.eigvals(matrix)).max(initial=0.0) ** 2)
        size = self.numbers
        if size < 20:
            columns = [self._flat(row) for row in np.eye(size)]
            return float(np.abs(np.linalg.eigvals(np.array(columns))).max() ** (1.0 / _PERIODS))
        operator = LinearOperator((size, size), matvec=self._flat, dtype=np.float64)
        start = (self._period.chain[:, None, None] * np.eye(self.shape[1])).ravel()
        try:
            # It keeps positive matrices positive, so its radius is an eigenvalue (Krein and Rutman), the
            # rightmost; others of the same modulus may turn.
            found = eigs(operator, k=1, which="LR", v0=start, tol=_ACCURACY, return_eigenvectors=False,
                         ncv=min(size - 1, 40), maxiter=1000)
        except ArpackError as fault:
            raise RunError(f"the growth of second moments was not found: {fault}") from None
        return float(found[0].real ** (1.0 / _PERIODS))

    @within_floats("the variance at rest")
    def variance(self, moments: Array) -> Array:
        """Of each output, (outputs,): its mean over the recorder's instants, given the moments at rest."""
        total, readings, chances = 0.0, 0, self._period.chain
        for step in self._period.steps:
            if isinstance(step, Draw):
                moments, chances = _drawn(step, moments, chances)
                continue
            seen = step.readings
            by_state = np.einsum("rpi,rpi->p", seen @ moments.sum(axis=0), seen)
            total = total + by_state + step.reading_variance.sum(axis=0)
            readings += len(seen)
            moments = step.matrix @ moments @ step.matrix.T + chances[:, None, None] * step.covariance
        return np.asarray(total / readings)


def _drawn(draw: Draw, moments: Array, chances: Array) -> tuple[Array, Array]:
    """Moments and probabilities of the chain's states after a draw."""
    if not draw.independent:
        mixed = np.tensordot(draw.chances.T, moments, axes=1)
        taken = np.stack([each[np.ix_(take, take)] for each, take in zip(mixed, draw.takes, strict=True)])
        return taken, chances @ draw.chances
    rows = draw.takes.shape[1]
    after = np.zeros((len(moments), rows, rows))
    for chance, take in zip(draw.chances, draw.takes, strict=True):
        after += chance * moments[:, take[:, None], take]
    return after, chances


def _summed(matrix: Array, noise: Array) -> Array:
    """The sum of matrix^k noise matrix'^k, by doubling (Smith 1968, doi 10.1137/0116017)."""
    total = noise
    for _ in range(_MOST_SQUARINGS):
        added = matrix @ total @ matrix.T
        total = total + added
        if np.abs(added).max() <= 1e-16 * np.abs(total).max():
            break
        matrix = matrix @ matrix
    return total
