"""The filter's likelihood against the multivariate normal density of the same covariance."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import multivariate_normal

from fesloop.analysis.tracker_error.series_fit import likelihood, whiten

PROCESS = {"slow": 2.0, "slow_s": 1.5, "fast_s": 0.2, "white": 0.1}


def covariance(times, slow, slow_s, fast_s, white, smooth):
    apart = np.abs(times[:, None] - times)
    x = apart / slow_s
    return (slow * np.exp(-x) * (1.0 + x if smooth else 1.0) + np.exp(-apart / fast_s)
            + white * np.eye(times.size))


@pytest.mark.parametrize("smooth", [False, True])
@pytest.mark.parametrize("shift", [0.0, 0.02])
def test_it_is_that_of_the_multivariate_normal_also_with_gaps_and_uneven_steps(smooth, shift):
    rng = np.random.default_rng(1)
    times = np.arange(60) * 0.05 + shift * rng.random(60)
    error = rng.standard_normal(60)
    error[rng.random(60) < 0.3] = np.nan
    known = np.isfinite(error)
    found = likelihood(error, times, np.zeros(60), smooth=smooth, speed_s=0.0, **PROCESS)
    matrix = found.scale * covariance(times, smooth=smooth, **PROCESS)[np.ix_(known, known)]
    assert found.log == pytest.approx(multivariate_normal(cov=matrix).logpdf(error[known]), rel=1e-9)
    assert np.mean(found.innovations[known] ** 2) == pytest.approx(1.0)
    assert np.isnan(found.innovations[~known]).all()


def test_the_scale_is_the_likeliest():
    rng = np.random.default_rng(2)
    times, error = np.arange(40) * 0.1, rng.standard_normal(40)
    found = likelihood(error, times, np.zeros(40), smooth=True, speed_s=0.0, **PROCESS)
    matrix = covariance(times, smooth=True, **PROCESS)
    beside = [multivariate_normal(cov=factor * found.scale * matrix).logpdf(error) for factor in (0.9, 1.1)]
    assert max(beside) < found.log


def test_motion_widens_what_is_expected():
    times = np.arange(50) * 0.1
    process = (0.0, 1.0, False, 0.2, 0.0, 1.5, np.empty(50))
    spread = whiten(np.zeros(50), times, np.full(50, 2.0), *process)
    # All variance is the fast part's, ten times that at rest: 1 + (1.5 s * 2 rad/s)^2.
    still = whiten(np.zeros(50), times, np.zeros(50), *process)
    assert spread - still == pytest.approx(50 * np.log(10.0))


def test_of_every_third_sample_it_is_the_mean_of_three():
    error, times = np.random.default_rng(3).standard_normal(90), np.arange(90) * 0.05
    process = {"smooth": False, "speed_s": 0.0, **PROCESS}
    found = likelihood(error, times, np.zeros(90), 3, **process)
    matrix = found.scale * covariance(times[::3], smooth=False, **PROCESS)
    parts = [multivariate_normal(cov=matrix).logpdf(error[first::3]) for first in range(3)]
    assert found.log == pytest.approx(np.mean(parts))


@given(st.floats(1e-3, 1e3), st.floats(0.02, 50.0), st.floats(0.02, 5.0), st.floats(1e-4, 1e3), st.booleans())
@settings(max_examples=60, deadline=None)
def test_it_is_finite_for_any_process(slow, slow_s, fast_s, white, smooth):
    error = np.sin(np.arange(300) * 0.02)
    found = likelihood(error, np.arange(300) * 0.01, np.ones(300), slow=slow, slow_s=slow_s, smooth=smooth,
                       fast_s=fast_s, white=white, speed_s=0.5)
    assert np.isfinite(found.log)
    assert found.scale > 0.0
