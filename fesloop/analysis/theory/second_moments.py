"""Second moments of a loop at rest: the exact recursion of a Markov jump linear system, and its fixed point.

With z the state and j the state of the chain, X_j = E[z z' 1(chain in j)] becomes M X_j M' + p_j W over a
flow, and T_j (sum of p_ij X_i) T_j' over a draw, where T_j takes rows: a linear operator on the X_j and a
constant. At rest the X_j solve a linear equation, and they are bounded if the operator's spectral radius is
below 1 (Costa, Fragoso and Marques 2005, Discrete-Time Markov Jump Linear Systems, ch. 3, doi
10.1007/b138575, for a chain in one step; here a period is a product of such steps). Nothing is sampled or
approximated. For control loops with random delays see Nilsson 1998, Real-Time Control Systems with
Delays, thesis, Lund Institute of Technology (delays below a period).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_discrete_lyapunov
from scipy.sparse.linalg import ArpackError, LinearOperator, eigs, gmres

from fesloop.analysis.theory.linear_loop import within_floats
from fesloop.analysis.theory.period_map import Draw, Flow, PeriodMap
from fesloop.errors import RunError

Array = NDArray[np.float64]
_ACCURACY = 1e-10
"""Relative accuracy of solutions and eigenvalues (chosen: far below the resolution of a simulation)."""
_PERIODS = 4
"""Periods per operator product in GMRES and Arnoldi: as many products, but a quarter of the vectors to
orthogonalise, which takes longer (chosen, measured)."""
_MOST_NUMBERS = 2**25
"""Most numbers in the vectors that GMRES keeps between restarts (chosen: 256 MB)."""


class SecondMoments:
    """The recursion of second moments over one period.

    Moments are (states of the chain, n, n) arrays at the beginning of the period.
    """

    def __init__(self, period: PeriodMap) -> None:
        self._period = period
        last = period.steps[-1]
        size = len(last.matrix) if isinstance(last, Flow) else last.takes.shape[1]
        self.shape = (period.chain.size, size, size)

    @property
    def numbers(self) -> int:
        """Number of entries of the moments."""
        return int(np.prod(self.shape))

    def after(self, moments: Array, noise: bool) -> Array:
        """The moments a period later; without `noise`, the homogeneous operator alone."""
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
        """Stationary moments of a mean-square stable loop; other loops have none."""
        matrix = self._period.matrix
        noise = self.after(np.zeros(self.shape), noise=True)
        if matrix is not None:
            return np.asarray(solve_discrete_lyapunov(matrix, noise[0], method="bilinear"))[np.newaxis]
        for _ in range(_PERIODS - 1):
            noise = self.after(noise, noise=True)
        return self._solved(noise)

    def _solved(self, noise: Array) -> Array:
        """Solve X = operator X + noise by GMRES, over `_PERIODS` periods."""
        size = noise.size
        operator = LinearOperator((size, size), matvec=lambda x: x - self._flat(x), dtype=np.float64)
        restart = int(np.clip(_MOST_NUMBERS // size, 20, 200))
        found, trouble = gmres(operator, noise.ravel(), rtol=_ACCURACY, restart=restart, maxiter=20)
        if trouble:
            raise RunError("the stationary second moments were not found: GMRES does not converge; the loop "
                           "is close to instability")
        return np.asarray(found).reshape(self.shape)

    def _flat(self, numbers: Array) -> Array:
        """The homogeneous operator of `_PERIODS` periods, on flat moments."""
        moments = numbers.reshape(self.shape)
        for _ in range(_PERIODS):
            moments = self.after(moments, noise=False)
        return moments.ravel()

    @within_floats("the growth of second moments")
    def spectral_radius(self) -> float:
        """The factor by which second moments grow per period in the long run."""
        matrix = self._period.matrix
        if not all(np.isfinite(step.matrix).all() for step in self._period.steps if isinstance(step, Flow)):
            raise RunError("the growth of second moments was not found: within a period numbers exceed the "
                           "range of floats")
        if matrix is not None:
            return float(np.abs(np.linalg.eigvals(matrix)).max(initial=0.0) ** 2)
        size = self.numbers
        if size < 20:
            columns = [self._flat(row) for row in np.eye(size)]
            return float(np.abs(np.linalg.eigvals(np.array(columns))).max() ** (1.0 / _PERIODS))
        operator = LinearOperator((size, size), matvec=self._flat, dtype=np.float64)
        start = (self._period.chain[:, None, None] * np.eye(self.shape[1])).ravel()
        try:
            # The operator keeps positive matrices positive, so its radius is an eigenvalue (Krein and
            # Rutman), the rightmost; others of the same modulus may be complex.
            found = eigs(operator, k=1, which="LR", v0=start, tol=_ACCURACY, return_eigenvectors=False,
                         ncv=min(size - 1, 40), maxiter=1000)
        except ArpackError as fault:
            raise RunError(f"the growth of second moments was not found: {fault}") from None
        return float(found[0].real ** (1.0 / _PERIODS))

    @within_floats("the variance at rest")
    def variance(self, moments: Array) -> Array:
        """Variance of each output, (outputs,), mean over the recorder's instants, from moments at rest."""
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
