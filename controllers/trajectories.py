"""Whole trials of a linear model: its response, the adjoint, and the norm-optimal change of drives.

All take time in one pass over the samples, without lifted matrices. With G the lifted model and W, R
diagonal weights: `response` is G v, `adjoint` is G' w, `optimal_change` is (G'WG + R)^-1 G'W e.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag
from scipy.sparse.linalg import LinearOperator, eigsh

from fesloop.errors import InputError
from fesloop.loop.signals import NEVER
from fesloop.models.linear_model import SampledModel

Array = NDArray[np.float64]


def response(model: SampledModel, drives: Array) -> Array:
    """Outputs (samples, outputs) under drives (samples, muscles) from rest, without the offset."""
    states = np.zeros(model.a.shape[0])
    outputs = np.empty((drives.shape[0], model.c.shape[0]))
    for k, drive in enumerate(drives):
        outputs[k] = model.c @ states
        states = model.a @ states + model.b @ drive
    return outputs


def adjoint(model: SampledModel, outputs: Array) -> Array:
    """Transposed response G'w, (samples, muscles), to outputs (samples, outputs)."""
    costates = np.zeros(model.a.shape[0])
    drives = np.empty((outputs.shape[0], model.b.shape[1]))
    for k in range(outputs.shape[0] - 1, -1, -1):
        drives[k] = model.b.T @ costates
        costates = model.a.T @ costates + model.c.T @ outputs[k]
    return drives


def strongest(model: SampledModel, weights: Array) -> float:
    """Greatest eigenvalue of G'WG: effect of the strongest pattern of drives on weighted outputs.

    `weights` are (samples, outputs). Lanczos starts from a fixed vector, so that equal problems give
    equal bits. Raises InputError where no drive has an effect, and for a model that grows beyond floats.
    """
    samples, outputs = weights.shape
    root = np.sqrt(weights)

    def apply(errors: Array) -> Array:
        back = adjoint(model, root * errors.reshape(samples, outputs))
        return (root * response(model, back)).ravel()

    size = samples * outputs
    with np.errstate(over="ignore", invalid="ignore"):
        start = apply(np.ones(size) + np.arange(size) / size)
    if not np.isfinite(start).all():
        raise InputError("model", "its response leaves the range of floats within a trial", "a stable model",
                         "check model.a: an eigenvalue has a large positive real part")
    if not start.any():
        raise InputError("model", "no drive changes an output with a weight", "a model that responds",
                         "check output_weight and points: the first sample precedes every response")
    if size < 3:
        return float(np.linalg.norm(np.column_stack([apply(unit) for unit in np.eye(size)]), 2))
    operator = LinearOperator((size, size), matvec=apply, dtype=np.float64)
    value = eigsh(operator, k=1, which="LA", v0=start, tol=1e-6, return_eigenvectors=False)
    return float(value[0])


def optimal_change(model: SampledModel, errors: Array, weights: Array, change_weights: Array) -> Array:
    """Drives d (samples, muscles) that minimise |e - G d|^2_W + |d|^2_R.

    The linear-quadratic tracking recursion, backward for gains and feedforward and then forward (Amann,
    Owens and Rogers 1996, doi 10.1049/ip-cta:19960244).

    Parameters
    ----------
    errors, weights: e and W, (samples, outputs).
    change_weights: R, (samples, muscles), above 0.
    """
    a, b, c = model.a, model.b, model.c
    samples, muscles = change_weights.shape
    gains = np.empty((samples, muscles, a.shape[0]))
    forward = np.empty((samples, muscles))
    ahead, pull = np.zeros_like(a), np.zeros(a.shape[0])
    for k in range(samples - 1, -1, -1):
        seen = b.T @ ahead
        solved = np.linalg.solve(seen @ b + np.diag(change_weights[k]),
                                 np.column_stack([seen @ a, b.T @ pull]))
        gains[k], forward[k] = solved[:, :-1], solved[:, -1]
        closed = a - b @ gains[k]
        ahead = (c.T * weights[k]) @ c + a.T @ ahead @ closed
        ahead = 0.5 * (ahead + ahead.T)
        pull = c.T @ (weights[k] * errors[k]) + closed.T @ pull
    states, change = np.zeros(a.shape[0]), np.empty((samples, muscles))
    for k in range(samples):
        change[k] = forward[k] - gains[k] @ states
        states = a @ states + b @ change[k]
    return change


Mask = NDArray[np.bool_]
BankRule = Literal["best", "mixture"]
_SUM_WEIGHT = 1e3
"""Weight, relative to the posture's size, of the equation that the shares of a mixture sum to 1."""


def shares_of(
    models: Sequence[SampledModel], drives: Sequence[Array], posture: Array, covered: Mask, rule: BankRule
) -> tuple[Array, Array]:
    """Shares (models,) that sum to 1, and the RMS error (models,), rad, of each model's prediction.

    "best" gives all to the model of least error, the first of equals; "mixture" is the convex combination of
    least error. The mean of each output over the covered samples is removed from both sides: a constant
    offset says nothing about the dynamics.

    Parameters
    ----------
    drives: (samples, muscles) of the trial, for each model as its recruitment curves have them.
    posture, covered: (samples, outputs), rad, and where it was observed, which some samples must be.
    """
    count = np.maximum(covered.sum(axis=0), 1)

    def centred(outputs: Array) -> Array:
        outputs = np.where(covered, outputs, 0.0)
        centre: Array = np.where(covered, outputs - outputs.sum(axis=0) / count, 0.0)
        return centre.ravel()

    from scipy.optimize import nnls  # which a run without a bank does without

    seen = centred(posture)
    told = np.column_stack([centred(response(model, own)) for model, own in zip(models, drives, strict=True)])
    miss = np.sqrt(np.sum((seen[:, None] - told) ** 2, axis=0) / covered.sum())
    if rule == "best" or np.ptp(told, axis=1).max() == 0.0:
        return np.eye(len(models))[int(np.argmin(miss))], miss
    size = _SUM_WEIGHT * max(float(np.abs(told).max()), float(np.abs(seen).max()))
    shares, _ = nnls(np.vstack([told, np.full(len(models), size)]), np.append(seen, size))
    return shares / shares.sum(), miss


def explained(models: Sequence[SampledModel], drives: Sequence[Array], posture: Array, covered: Mask,
              rule: BankRule) -> tuple[Array, tuple[str, str]]:
    """Shares of the models by `shares_of`, and a report of each model's share and error."""
    shares, miss = shares_of(models, drives, posture, covered, rule)
    told = (f"model {i}: share {share:.2f}, error {math.degrees(each):.2f} deg"
            for i, (share, each) in enumerate(zip(shares, miss, strict=True)))
    return shares, ("model_selected", "; ".join(told))


def rescaled(model: SampledModel, own: Array, drives: Array) -> SampledModel:
    """A model for other drives than its own, which are taken to be proportional to them, muscle by muscle.

    Parameters
    ----------
    own, drives: (samples, muscles), drives of the same pulses by the model's recruitment curves, and by the
        others; the factors are those of least squares over the samples.
    """
    factors = np.sum(own * drives, axis=0) / np.sum(drives ** 2, axis=0)
    return replace(model, b=model.b * factors)


def mixed(models: Sequence[SampledModel], shares: Array) -> SampledModel:
    """The model whose outputs are the mixture of the models' outputs, without models of share 0."""
    used = [(model, share) for model, share in zip(models, shares, strict=True) if share > 0.0]
    if len(used) == 1:
        return used[0][0]
    return SampledModel(
        block_diag(*(model.a for model, _ in used)), np.vstack([model.b for model, _ in used]),
        np.hstack([share * model.c for model, share in used]),
        np.sum([share * model.offset for model, share in used], axis=0),
        min(model.delay_steps for model, _ in used))


Stamps = NDArray[np.int64]


def posture_at(
    ticks_ns: Stamps, captured_ns: Stamps, measured: Array, max_gap_ns: int
) -> tuple[Array, Mask]:
    """Posture (ticks, outputs) at the instants of the ticks, and whether each tick is covered, (ticks,).

    A cubic spline through the captures (its error is of fourth order in their distance; linear with fewer
    than four) removes the age of each sample. A tick is covered if it lies between two captures that are at
    most `max_gap_ns` apart, or on one; elsewhere the posture is 0.

    Parameters
    ----------
    ticks_ns: (ticks,), increasing.
    captured_ns: (ticks,), newest capture of the sample that is read at each tick; negative for none.
    measured: (ticks, outputs), samples.
    """
    from scipy.interpolate import make_interp_spline  # which predictive control does without

    stamps, first = np.unique(captured_ns[captured_ns >= 0], return_index=True)
    values = measured[captured_ns >= 0][first]
    posture = np.zeros((ticks_ns.size, measured.shape[1]))
    if stamps.size == 0:
        return posture, np.zeros(ticks_ns.size, dtype=bool)
    after = np.searchsorted(stamps, ticks_ns, side="left")
    inside = (ticks_ns >= stamps[0]) & (ticks_ns <= stamps[-1])
    later = np.minimum(after, stamps.size - 1)
    gaps = stamps[later] - stamps[np.maximum(later - 1, 0)]
    covered = inside & ((stamps[later] == ticks_ns) | (gaps <= max_gap_ns))
    if stamps.size == 1:
        posture[covered] = values
        return posture, covered
    spline = make_interp_spline(stamps.astype(np.float64), values, k=3 if stamps.size >= 4 else 1)
    posture[covered] = spline(ticks_ns[covered].astype(np.float64))
    return posture, covered


@dataclass(slots=True, eq=False)
class SeenTrial:
    """Measurements of a trial.

    Attributes
    ----------
    ticks_ns: (samples,), instants of the steps with a reference; NEVER for others.
    captured_ns: (samples,), newest capture of the sample that was read then; NEVER for none.
    measured, reference: (samples, outputs), rad.
    doubtful: (samples, outputs), samples that arrived but are excluded from learning.
    touched: tick of the first contact; the number of samples before it.
    """

    ticks_ns: Stamps
    captured_ns: Stamps
    measured: Array
    reference: Array
    doubtful: Mask
    touched: int

    @classmethod
    def empty(cls, samples: int, outputs: int) -> SeenTrial:
        """Empty record of a trial."""
        return cls(np.full(samples, NEVER, dtype=np.int64), np.full(samples, NEVER, dtype=np.int64),
                   np.zeros((samples, outputs)), np.zeros((samples, outputs)),
                   np.zeros((samples, outputs), dtype=bool), samples)

    @property
    def free(self) -> bool:
        """Whether there has been no contact."""
        return self.touched == self.ticks_ns.size

    def touch(self, k: int) -> None:
        """Record a contact at tick k."""
        self.touched = k

    def note(self, k: int, captured_ns: int, measured: Array, doubtful: Mask) -> None:
        """Record the sample of tick k without its doubtful outputs (outputs,)."""
        self.captured_ns[k] = captured_ns
        self.doubtful[k] = doubtful
        self.measured[k] = np.where(doubtful, 0.0, measured)

    def doubtful_share(self) -> float:
        """Share of the samples that is doubtful, 0 to 1; 0 without samples."""
        came = self.captured_ns >= 0
        return float(self.doubtful[came].mean()) if came.any() else 0.0

    def touching(self, numbers: Sequence[int], count: int) -> Mask:
        """Mask (samples, count): true from the first contact on in the columns `numbers`, all if empty."""
        columns = np.zeros(count, dtype=bool)
        columns[list(numbers) or slice(None)] = True
        return (np.arange(self.ticks_ns.size) >= self.touched)[:, None] & columns

    def posture(self, align: bool, max_gap_ns: int) -> tuple[Array, Mask]:
        """Posture and coverage, (samples, outputs), at the instants of the ticks if `align`, else as read.

        Doubtful samples are left out, output by output. `max_gap_ns` as in `posture_at`.
        """
        posture, covered = np.zeros_like(self.measured), np.zeros_like(self.doubtful)
        for j in range(posture.shape[1]):
            stamps = np.where(self.doubtful[:, j], NEVER, self.captured_ns)
            column = self.measured[:, j:j + 1]
            if align:
                column, covered[:, j] = posture_at(self.ticks_ns, stamps, column, max_gap_ns)
            else:
                covered[:, j] = stamps >= 0
            posture[:, j] = column[:, 0]
        return posture, covered & (self.ticks_ns >= 0)[:, None]
