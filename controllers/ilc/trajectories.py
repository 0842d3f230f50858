"""Whole trials of a linear model: its response, the adjoint, and the norm-optimal change of drives.

All take time in one pass over the samples, without lifted matrices. With G the lifted model and W, R
diagonal weights: `response` is G v, `adjoint` is G' w, `optimal_change` is (G'WG + R)^-1 G'W e.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag
from scipy.optimize import nnls
from scipy.sparse.linalg import LinearOperator, eigsh

from fesloop.errors import InputError
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
    models: Sequence[SampledModel], drives: Array, posture: Array, covered: Mask, rule: BankRule
) -> tuple[Array, Array]:
    """Shares (models,) that sum to 1, and the RMS error (models,), rad, of each model's prediction.

    "best" gives all to the model of least error, the first of equals; "mixture" is the convex combination of
    least error. The mean of each output over the covered samples is removed from both sides: a constant
    offset says nothing about the dynamics.

    Parameters
    ----------
    drives: (samples, muscles), of the trial.
    posture, covered: (samples, outputs), rad, and where it was observed, which some samples must be.
    """
    count = np.maximum(covered.sum(axis=0), 1)

    def centred(outputs: Array) -> Array:
        outputs = np.where(covered, outputs, 0.0)
        centre: Array = np.where(covered, outputs - outputs.sum(axis=0) / count, 0.0)
        return centre.ravel()

    seen = centred(posture)
    told = np.column_stack([centred(response(model, drives)) for model in models])
    miss = np.sqrt(np.sum((seen[:, None] - told) ** 2, axis=0) / covered.sum())
    if rule == "best" or np.ptp(told, axis=1).max() == 0.0:
        return np.eye(len(models))[int(np.argmin(miss))], miss
    size = _SUM_WEIGHT * max(float(np.abs(told).max()), float(np.abs(seen).max()))
    shares, _ = nnls(np.vstack([told, np.full(len(models), size)]), np.append(seen, size))
    return shares / shares.sum(), miss


def explained(models: Sequence[SampledModel], drives: Array, posture: Array, covered: Mask,
              rule: BankRule) -> tuple[SampledModel, tuple[str, str]]:
    """The model that explains a trial by `shares_of`, and a text with each model's share and error."""
    shares, miss = shares_of(models, drives, posture, covered, rule)
    told = (f"model {i}: share {share:.2f}, error {math.degrees(each):.2f} deg"
            for i, (share, each) in enumerate(zip(shares, miss, strict=True)))
    return mixed(models, shares), ("model_selected", "; ".join(told))


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
