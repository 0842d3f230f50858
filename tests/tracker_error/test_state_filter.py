"""The filter's likelihood against the multivariate normal density of the same covariance."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import multivariate_normal

from fesloop.analysis.tracker_error.series_fit import Parts, Piece, likelihood, summed_variance, whiten
from fesloop.models.error_process import ErrorSeries
from fesloop.models.error_steps import random_variance

PARTS = Parts(slow=2.0, slow_s=1.5, rise_s=0.0, fast_s=0.2, quick=0.5, quick_s=0.3, quick_rate=25.0,
              white=0.1, speed_s=0.0)
RISES_S = (0.0, 0.1, 1.5)


def covariance(times, parts):
    apart = np.abs(times[:, None] - times)
    slow = np.exp(-apart / parts.slow_s)
    if parts.rise_s == parts.slow_s:
        slow *= 1.0 + apart / parts.slow_s
    elif parts.rise_s:
        slow = (parts.slow_s * slow - parts.rise_s * np.exp(-apart / parts.rise_s)) / (
            parts.slow_s - parts.rise_s)
    return (parts.slow * slow + np.exp(-apart / parts.fast_s) + parts.white * np.eye(times.size)
            + parts.quick * np.exp(-apart / parts.quick_s) * np.cos(parts.quick_rate * apart))


@pytest.mark.parametrize("rise_s", RISES_S)
@pytest.mark.parametrize("shift", [0.0, 0.02])
def test_it_is_that_of_the_multivariate_normal_also_with_gaps_and_uneven_steps(rise_s, shift):
    rng, parts = np.random.default_rng(1), PARTS._replace(rise_s=rise_s)
    times = np.arange(60) * 0.05 + shift * rng.random(60)
    error = rng.standard_normal(60)
    error[rng.random(60) < 0.3] = np.nan
    known = np.isfinite(error)
    found = likelihood([Piece(error, times, np.zeros(60))], parts)
    matrix = found.scale * covariance(times, parts)[np.ix_(known, known)]
    exact = multivariate_normal(cov=matrix).logpdf(error[known])
    assert found.log == pytest.approx(exact, rel=1e-9)
    assert np.mean(found.innovations[0][known] ** 2) == pytest.approx(1.0)
    assert np.isnan(found.innovations[0][~known]).all()


def test_the_scale_is_the_likeliest_or_the_given_one():
    rng = np.random.default_rng(2)
    times, error = np.arange(40) * 0.1, rng.standard_normal(40)
    piece = Piece(error, times, np.zeros(40))
    found = likelihood([piece], PARTS)
    matrix = covariance(times, PARTS)
    for factor in (0.9, 1.1):
        scale = factor * found.scale
        other = multivariate_normal(cov=scale * matrix).logpdf(error)
        assert other < found.log
        assert likelihood([piece], PARTS, scale=scale).log == pytest.approx(other)


def test_records_are_independent_of_each_other():
    rng = np.random.default_rng(4)
    pieces = [Piece(rng.standard_normal(n), np.arange(n) * 0.05, np.zeros(n)) for n in (30, 50)]
    both = likelihood(pieces, PARTS, scale=0.3)
    assert both.log == pytest.approx(sum(likelihood([piece], PARTS, scale=0.3).log for piece in pieces))
    assert [found.size for found in both.innovations] == [30, 50]


def test_motion_widens_what_is_expected():
    times = np.arange(50) * 0.1
    parts = PARTS._replace(slow=0.0, white=0.0, quick_rate=0.0, quick_s=0.2, speed_s=1.5)
    spread = whiten(np.zeros(50), times, np.full(50, 2.0), parts, np.empty(50))
    # All variance is that of parts that motion drives, ten times that at rest: 1 + (1.5 s * 2 rad/s)^2.
    still = whiten(np.zeros(50), times, np.zeros(50), parts, np.empty(50))
    assert spread - still == pytest.approx(50 * np.log(10.0))


def test_the_summed_variance_is_that_of_the_process():
    times = np.arange(80) * 0.05
    rates = 2.0 * np.sin(2.0 * times)
    errors = np.where(times < 3.0, 0.1, np.nan)
    parts = PARTS._replace(white=0.0, speed_s=0.7)
    series = ErrorSeries(name="a", slow_deg=np.degrees(np.sqrt(2.0)), slow_s=1.5, fast_deg=np.degrees(1.0),
                         fast_s=0.2, quick_deg=np.degrees(np.sqrt(0.5)), quick_s=0.3,
                         quick_hz=25.0 / (2.0 * np.pi), speed_s=0.7)
    exact = random_variance(series.row(), rates, np.full(80, 0.05))[times < 3.0].sum()
    assert summed_variance(errors, times, np.abs(rates), parts) == pytest.approx(exact)


def test_of_every_third_sample_it_is_the_mean_of_three():
    error, times = np.random.default_rng(3).standard_normal(90), np.arange(90) * 0.05
    found = likelihood([Piece(error, times, np.zeros(90), 3)], PARTS)
    matrix = found.scale * covariance(times[::3], PARTS)
    parts = [multivariate_normal(cov=matrix).logpdf(error[first::3]) for first in range(3)]
    assert found.log == pytest.approx(np.mean(parts))


@given(st.floats(1e-3, 1e3), st.floats(0.02, 50.0), st.floats(0.0, 1.0), st.floats(0.02, 5.0),
       st.floats(1e-4, 1e3), st.floats(0.02, 1.0), st.floats(0.0, 300.0))
@settings(max_examples=60, deadline=None)
def test_it_is_finite_for_any_process(slow, slow_s, share, fast_s, white, quick_s, quick_rate):
    error = np.sin(np.arange(300) * 0.02)
    parts = Parts(slow=slow, slow_s=slow_s, rise_s=share * slow_s if share > 1e-3 else 0.0, fast_s=fast_s,
                  quick=1.0, quick_s=quick_s, quick_rate=quick_rate, white=white, speed_s=0.5)
    found = likelihood([Piece(error, np.arange(300) * 0.01, np.ones(300))], parts)
    assert np.isfinite(found.log)
    assert found.scale > 0.0
