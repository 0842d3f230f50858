"""Correlation across angles."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from fesloop.models.correlation import correlation_of, root_of, without_negative


def test_a_known_correlation_is_found_through_gaps():
    rng = np.random.default_rng(0)
    true = np.array([[1.0, 0.7, 0.0], [0.7, 1.0, -0.3], [0.0, -0.3, 1.0]])
    rows = np.linalg.cholesky(true) @ rng.standard_normal((3, 4000))
    rows[rng.random(rows.shape) < 0.2] = np.nan
    np.testing.assert_allclose(correlation_of(list(rows)), true, atol=0.06)


def test_what_is_never_known_together_is_independent():
    rows = np.full((2, 200), np.nan)
    rows[0, :100] = rows[1, 100:] = np.random.default_rng(0).standard_normal(100)
    np.testing.assert_array_equal(correlation_of(list(rows)), np.eye(2))


@given(st.integers(2, 6), st.integers(0, 10_000))
@settings(max_examples=40, deadline=None)
def test_it_is_made_a_correlation_and_its_root_makes_it_again(size, seed):
    guess = np.random.default_rng(seed).uniform(-1.0, 1.0, (size, size))
    guess = 0.5 * (guess + guess.T)
    np.fill_diagonal(guess, 1.0)
    made = without_negative(guess)
    assert np.linalg.eigvalsh(made).min() > -1e-9
    np.testing.assert_allclose(np.diag(made), 1.0)
    root = root_of(made)
    np.testing.assert_allclose(root @ root.T, made, atol=1e-7)
