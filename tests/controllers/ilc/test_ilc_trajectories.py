import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from ilc_parts import MODEL, scalar

from controllers.trajectories import adjoint, optimal_change, response, strongest
from fesloop.errors import InputError

SAMPLES = 12
LIFTED = MODEL.lifted(SAMPLES)


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=20, deadline=None)
def test_passes_over_the_samples_equal_the_lifted_matrices(seed):
    rng = np.random.default_rng(seed)
    drives, outputs = rng.standard_normal((SAMPLES, 3)), rng.standard_normal((SAMPLES, 2))
    weights = rng.uniform(0.0, 2.0, (SAMPLES, 2)) * (rng.uniform(size=(SAMPLES, 2)) > 0.3)
    change_weights = rng.uniform(0.05, 1.0, (SAMPLES, 3))
    np.testing.assert_allclose(response(MODEL, drives).ravel(), LIFTED @ drives.ravel(), atol=1e-12)
    np.testing.assert_allclose(adjoint(MODEL, outputs).ravel(), LIFTED.T @ outputs.ravel(), atol=1e-12)
    weighted = LIFTED.T * weights.ravel()
    best = np.linalg.solve(weighted @ LIFTED + np.diag(change_weights.ravel()), weighted @ outputs.ravel())
    found = optimal_change(MODEL, outputs, weights, change_weights)
    np.testing.assert_allclose(found.ravel(), best, atol=1e-10)


def test_strongest_is_the_squared_norm_of_the_weighted_lifted_matrix():
    weights = np.tile([1.0, 3.0], (SAMPLES, 1))
    weights[:4] = 0.0
    norm = np.linalg.norm(np.sqrt(weights).ravel()[:, None] * LIFTED, 2)
    assert strongest(MODEL, weights) == pytest.approx(norm**2, rel=1e-5)
    assert strongest(scalar(0.5, 2.0), np.ones((2, 1))) == pytest.approx(4.0)


def test_a_model_of_which_nothing_shows_is_named():
    first = np.zeros((SAMPLES, 2))
    first[0] = 1.0
    for weights in (first, np.zeros((SAMPLES, 2))):
        with pytest.raises(InputError, match="no drive changes an output"):
            strongest(MODEL, weights)
