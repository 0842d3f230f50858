"""Small models and laws on them, for the tests of iterative learning control."""

import numpy as np

from controllers.ilc.laws import Learning, Limits
from fesloop.models.linear_model import SampledModel

MODEL = SampledModel(
    a=np.array([[0.7, 0.1, 0.0], [0.0, 0.6, 0.2], [0.0, 0.0, 0.5]]),
    b=np.array([[0.2, -0.1, 0.05], [0.1, 0.1, 0.0], [0.3, 0.0, -0.3]]),
    c=np.array([[1.0, 0.0, 0.0], [0.2, 0.0, 1.0]]), offset=np.zeros(2), delay_steps=0)


class Straight:
    """Widths that are drives."""

    def widths(self, drives):
        return drives

    def drives(self, widths):
        return widths


def free(muscles):
    """Limits that never bind from a drive of 0 or more upwards."""
    return Limits(reach=np.full(muscles, np.inf), slew=np.inf)


def learning(law, model=MODEL, samples=12, **changes):
    """A law on a model; without limits unless given."""
    muscles, outputs = model.b.shape[1], model.c.shape[0]
    return Learning(**{
        "law": law, "model": model, "samples": samples, "limits": free(muscles),
        "first": np.zeros((samples, muscles)), "output_weight": np.ones(outputs),
        "points": np.ones((samples, outputs), dtype=bool), "curves": Straight(), "change_weight": 0.05,
        "forgetting": 0.0, "step": 1.0, "gain": 0.4, "lead": 1, "cutoff": 0.0, "solver": "daqp"} | changes)


def everywhere(law):
    """Every output of every sample observed."""
    return np.ones_like(law.points)


def scalar(pole, gain):
    """y[k+1] = pole y[k] + gain v[k]."""
    return SampledModel(np.array([[pole]]), np.array([[gain]]), np.eye(1), np.zeros(1), 0)
