"""Steps of the error process against matrix exponentials, stationarity and analytic autocovariance."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.linalg import expm

from fesloop.models.error_process import ErrorSeries
from fesloop.models.error_steps import (
    DRAWS,
    PARTS,
    along,
    ensemble,
    errors_now,
    random_variance,
    rows_of,
    smooth_steps,
)


@given(st.floats(0.01, 100.0), st.floats(1e-3, 1.0), st.floats(1e-4, 10.0))
@example(1.0, 1.0 - 1e-10, 0.5)
@settings(max_examples=100, deadline=None)
def test_a_smooth_process_goes_on_exactly_and_stays_as_it_is(time_s, share, elapsed_s):
    """With equal time constants, too, of which the analytic solution has a limit."""
    for rise_s in (share * time_s, time_s):
        p, q = 1.0 / time_s, 1.0 / rise_s
        steps, root = smooth_steps(time_s, rise_s, elapsed_s)
        exact = expm(np.array([[0.0, 1.0], [-p * q, -p - q]]) * elapsed_s)
        pace = np.sqrt(p * q)
        scale = np.array([[1.0, 1.0 / pace], [pace, 1.0]])
        np.testing.assert_allclose(steps / scale, exact / scale, atol=1e-9)
        rest = np.diag([1.0, p * q])
        after = steps @ rest @ steps.T + root @ root.T
        units = np.outer([1.0, pace], [1.0, pace])
        np.testing.assert_allclose(after / units, rest / units, atol=1e-6)
        np.testing.assert_array_equal(smooth_steps(rise_s, time_s, elapsed_s)[0], steps)


def covariance(series, t):
    """Autocovariance at rest, deg^2."""
    x = t / series.slow_s
    slow = np.exp(-x) * (1.0 + x if series.smooth else 1.0)
    if series.rise_s:
        slow = (series.slow_s * np.exp(-x) - series.rise_s * np.exp(-t / series.rise_s)) / (
            series.slow_s - series.rise_s)
    return (series.slow_deg**2 * slow + series.fast_deg**2 * np.exp(-t / series.fast_s)
            + series.quick_deg**2 * np.exp(-t / series.quick_s) * np.cos(2.0 * np.pi * series.quick_hz * t))


@pytest.mark.parametrize("kind", [{}, {"smooth": True}, {"smooth": True, "rise_s": 0.1}, {"quick_hz": 8.0}])
def test_an_ensemble_has_the_covariance_of_its_parts(kind):
    series = ErrorSeries(name="a", slow_deg=2.0, slow_s=0.8, fast_deg=1.0, fast_s=0.1, quick_deg=0.8,
                         quick_s=0.2 if kind.get("quick_hz") else 0.02, **kind)
    samples, step = 60, 0.05
    draws = np.random.default_rng(3).standard_normal((20_000, DRAWS, samples))
    still = np.zeros(samples)
    runs = np.degrees(ensemble(series.row(), still, still, np.full(samples, step), draws))
    for lag in (0, 1, 2, 3, 8, 40):
        found = np.mean(runs[:, 10] * runs[:, 10 + lag])
        wanted = covariance(series, lag * step)
        assert found == pytest.approx(wanted, abs=4.0 * covariance(series, 0.0) / np.sqrt(20_000))


def test_what_follows_from_the_motion_is_held_where_nothing_is_known():
    series = ErrorSeries(name="a", bias_deg=1.0, slope=0.1, curve_deg=2.0, lead_s=0.02,
                         angle_deg=(-30.0, 40.0), rate_deg_s=100.0)
    angles, rates = np.radians([0.0, 20.0, 90.0]), np.radians([0.0, 50.0, -500.0])
    wanted = [1.0, 1.0 + 2.0 + 2.0 * np.radians(20.0) ** 2 + 1.0,
              1.0 + 4.0 + 2.0 * np.radians(40.0) ** 2 - 2.0]
    np.testing.assert_allclose(np.degrees(along(series.row(), angles, rates)), wanted)


@pytest.mark.parametrize("quick_hz", [0.0, 5.0])
def test_variance_along_a_motion_is_that_of_many_runs(quick_hz):
    """Of a quick part that oscillates, too, which is driven by the motion."""
    series = ErrorSeries(name="a", slow_deg=1.0, slow_s=2.0, fast_deg=1.0, fast_s=0.3, quick_deg=0.6,
                         quick_s=0.2, quick_hz=quick_hz, speed_s=2.0)
    times = np.arange(80) * 0.05
    rates = 2.0 * np.sin(2.0 * times)
    draws = np.random.default_rng(4).standard_normal((20_000, DRAWS, 80))
    runs = ensemble(series.row(), np.zeros(80), rates, np.full(80, 0.05), draws)
    exact = random_variance(series.row(), rates, np.full(80, 0.05))
    np.testing.assert_allclose(runs.var(axis=0), exact, rtol=0.06)
    assert exact.max() > 3.0 * exact.min()


def test_the_loops_kernel_and_the_ensembles_are_one_process():
    series = [ErrorSeries(name="a", bias_deg=1.0, lead_s=0.1, slow_deg=1.0, slow_s=2.0, smooth=True,
                          rise_s=0.5, fast_deg=0.5, fast_s=0.1, quick_deg=0.2, quick_s=0.1, quick_hz=7.0,
                          speed_s=1.0),
              ErrorSeries(name="b", fast_deg=1.0, fast_s=0.3)]
    draws = np.random.default_rng(5).standard_normal((2, DRAWS, 30))
    angles, rates = np.linspace(0.0, 1.0, 30), np.linspace(-1.0, 1.0, 30)
    parts = np.zeros((2, PARTS))
    stepped = [errors_now(rows_of(series), parts, np.full(2, angles[k]), np.full(2, rates[k]), 0.01, k == 0,
                          np.ascontiguousarray(draws[:, :, k].T)) for k in range(30)]
    for i, each in enumerate(series):
        run = ensemble(each.row(), angles, rates, np.full(30, 0.01), draws[i:i + 1])[0]
        np.testing.assert_allclose(np.array(stepped)[:, i], run)
