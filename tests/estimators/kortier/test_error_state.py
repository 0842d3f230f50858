"""One scalar absorbed: against Joseph's form in long double, down to the tightest noise that is promised."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from estimators.kortier.error_state import absorb

SIZE = 21


@given(st.integers(0, 2**32 - 1), st.floats(-13.0, 1.0))
@settings(deadline=None, max_examples=50)
def test_absorbing_is_josephs_form(seed, decades):
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(SIZE, SIZE))
    covariance = root @ root.T / SIZE
    covariance = 0.5 * (covariance + covariance.T)
    error, row, variance = rng.normal(size=SIZE), np.zeros(SIZE), 10.0 ** decades
    row[3:9] = rng.normal(size=6)
    exact, h = covariance.astype(np.longdouble), row.astype(np.longdouble)
    spread = h @ exact @ h + variance
    gain = exact @ h / spread
    rest = np.eye(SIZE) - np.outer(gain, h)
    expected = rest @ exact @ rest.T + variance * np.outer(gain, gain)
    innovation = 0.7 - h @ error
    moved, after = error.copy(), covariance.copy()
    nis = absorb(after, moved, row, 3, 9, 0.7, variance, np.empty(SIZE), np.empty(SIZE + 2))
    assert nis == pytest.approx(float(innovation**2 / spread), rel=1e-11)
    np.testing.assert_array_equal(after, after.T)
    np.testing.assert_allclose(after, expected.astype(float), atol=1e-14 * np.abs(covariance).max())
    np.testing.assert_allclose(moved, (error + gain * innovation).astype(float), rtol=1e-11, atol=1e-12)


def test_a_tight_measurement_leaves_what_it_says():
    """Noise of 1e-6 of what it measures, twenty times over: the variance goes on falling as it should."""
    rng = np.random.default_rng(0)
    root = rng.normal(size=(SIZE, SIZE))
    covariance = root @ root.T / SIZE
    row = np.zeros(SIZE)
    row[:3] = 1.0
    for _ in range(20):
        absorb(covariance, np.zeros(SIZE), row, 0, 3, 0.0, 1e-12, np.empty(SIZE), np.empty(SIZE))
    assert row @ covariance @ row == pytest.approx(1e-12 / 20, rel=0.02)
    assert np.linalg.eigvalsh(covariance).min() > 0.0
