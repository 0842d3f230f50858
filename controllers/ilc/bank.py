"""Several models of one plant: which of them, or what mixture, explains the last trial.

After multiple-model iterative learning control (Zhou, Freeman and Holderbaum 2025, doi
10.1016/j.conengprac.2024.106134): each model predicts what the trial's drives do, and the update is made with
what predicts best.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag
from scipy.optimize import nnls

from controllers.ilc.trajectories import response
from fesloop.models.linear_model import SampledModel

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
BankRule = Literal["best", "mixture"]
_SUM_WEIGHT = 1e3
"""Weight, against the posture's own size, by which the shares of a mixture are made to sum to 1."""


def shares_of(
    models: Sequence[SampledModel], drives: Array, posture: Array, covered: Mask, rule: BankRule
) -> tuple[Array, Array]:
    """(shares (models,) that sum to 1, miss (models,) RMS rad of each model's prediction).

    "best" gives all to the model that misses least, the first of equals; "mixture" is the convex combination
    that misses least. Each output's mean over what was covered is left out of both sides: a constant offset
    says nothing about the dynamics.

    Parameters
    ----------
    drives: (samples, muscles), of the trial.
    posture, covered: (samples, outputs), rad, and where it was observed; somewhere at least.
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
    """The model that explains a trial, as of `shares_of`, and a report of what each has to do with it."""
    shares, miss = shares_of(models, drives, posture, covered, rule)
    told = (f"model {i}: share {share:.2f}, misses {math.degrees(each):.2f} deg"
            for i, (share, each) in enumerate(zip(shares, miss, strict=True)))
    return mixed(models, shares), ("bank", "; ".join(told))


def mixed(models: Sequence[SampledModel], shares: Array) -> SampledModel:
    """The model whose outputs are the mixture of the models' outputs; models of no share are left out."""
    used = [(model, share) for model, share in zip(models, shares, strict=True) if share > 0.0]
    if len(used) == 1:
        return used[0][0]
    return SampledModel(
        block_diag(*(model.a for model, _ in used)), np.vstack([model.b for model, _ in used]),
        np.hstack([share * model.c for model, share in used]),
        np.sum([share * model.offset for model, share in used], axis=0),
        min(model.delay_steps for model, _ in used))
