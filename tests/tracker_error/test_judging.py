"""Judgements of processes that are right, and of ones that are wrong: about 15 s."""

from dataclasses import replace

import numpy as np
import pytest

from fesloop.analysis.tracker_error.error_record import ErrorRecord, autocorrelation, independent_values
from fesloop.analysis.tracker_error.judging import increment_steps, judge, rms_increments, whole_band
from fesloop.analysis.tracker_error.series_fit import SeriesFit
from fesloop.models.error_process import ErrorSeries
from fesloop.models.error_steps import DRAWS, ensemble

TIMES = np.arange(400) / 20.0
STEPS = np.full(400, 0.05)
TRUE = ErrorSeries(name="a", bias_deg=0.5, slow_deg=1.0, slow_s=0.8, fast_deg=0.5, fast_s=0.1)


def record(series, seed):
    draws = np.random.default_rng(seed).standard_normal((1, DRAWS, 400))
    error = ensemble(series.row(), np.zeros(400), np.zeros(400), STEPS, draws)[0]
    error[100:130] = np.nan
    still = np.zeros(400)
    return ErrorRecord(name="a", moved=True, times_s=TIMES, error=error, angle=still, rate=still)


def fit_of(series):
    return SeriesFit(series=series, innovations=np.zeros(400), criterion=0.0, weight_spread=np.zeros((4, 4)),
                     too_slow=False)


def judged(series, seed):
    return judge(fit_of(series), record(TRUE, seed), record(TRUE, seed))


@pytest.mark.slow
def test_the_band_holds_as_many_records_of_the_right_process_as_it_says():
    held = [judged(TRUE, seed).autocorrelation_holds for seed in range(40)]
    assert 0.85 <= np.mean(held) <= 1.0


def test_other_time_constants_fall_out_of_it():
    wrong = ErrorSeries(name="a", bias_deg=0.5, slow_deg=1.1, slow_s=0.08, fast_deg=0.2, fast_s=0.05)
    assert not any(judged(wrong, seed).autocorrelation_holds for seed in range(5))


def test_rmse_is_off_by_as_much_as_the_process_is():
    twice = ErrorSeries(name="a", bias_deg=1.0, slow_deg=2.0, slow_s=0.8, fast_deg=1.0, fast_s=0.1)
    for seed in range(3):
        right, wrong = judged(TRUE, seed), judged(twice, seed)
        assert wrong.process_deg == pytest.approx(2.0 * right.process_deg, rel=0.03)
        assert not wrong.rmse_holds
        assert right.halves_differ == 0.0
    assert right.process_deg == pytest.approx(np.sqrt(0.25 + 1.0 + 0.25), rel=0.02)
    assert right.process_low_deg < right.process_deg < right.process_high_deg


def test_increments_are_those_of_theory():
    """Over a time t an Ornstein-Uhlenbeck process changes by the root of 2 (1 - exp(-t / its time))."""
    found = judged(TRUE, 0)
    t = found.increment_times_s
    np.testing.assert_allclose(t, [0.05, 0.1, 0.2, 0.5])
    exact = np.sqrt(2.0 * (1.0 - np.exp(-t / 0.8)) + 0.5 * (1.0 - np.exp(-t / 0.1)))
    np.testing.assert_allclose(found.process_increments_deg, exact, rtol=0.02)
    np.testing.assert_allclose(found.increments_deg, exact, rtol=0.25)
    assert np.mean([judged(TRUE, seed).increments_hold for seed in range(5)]) >= 0.6


def test_a_process_that_is_too_smooth_has_too_small_increments():
    """Of the same size, with the same slow part."""
    smooth = ErrorSeries(name="a", bias_deg=0.5, slow_deg=np.sqrt(1.25), slow_s=0.8, smooth=True)
    for seed in range(3):
        wrong = judged(smooth, seed)
        assert not wrong.increments_hold
        assert (wrong.increments_off[:2] < -0.5).all()


def test_increments_skip_gaps_and_times_without_pairs():
    errors = np.arange(40.0)[np.newaxis] ** 2
    known = np.zeros(40, dtype=bool)
    known[[0, 1, 2, 30, 31]] = True
    wild = np.where(known, errors, 1e9)
    np.testing.assert_allclose(rms_increments(wild, known, np.array([1, 2])),
                               [[np.sqrt((1.0 + 9.0 + 61.0**2) / 3.0), 4.0]])
    gappy = ErrorRecord(name="a", moved=True, times_s=np.arange(40) / 20.0,
                        error=np.where(known, errors[0], np.nan), angle=np.zeros(40), rate=np.zeros(40))
    np.testing.assert_array_equal(increment_steps(gappy), [1, 2])


def test_constant_parts_of_other_recordings_widen_the_runs():
    alone, wide = judged(TRUE, 0), judged(replace(TRUE, bias_sd_deg=2.0), 0)
    assert wide.process_deg == pytest.approx(np.sqrt(1.5 + 4.0), rel=0.05)
    spreads = [each.process_high_deg - each.process_low_deg for each in (alone, wide)]
    assert spreads[1] > 3.0 * spreads[0]
    np.testing.assert_allclose(wide.process_increments_deg, alone.process_increments_deg)
    sized = judged(replace(TRUE, size_sd=0.5), 0)
    assert sized.process_deg == pytest.approx(alone.process_deg, rel=0.1)
    assert sized.process_high_deg - sized.process_low_deg > 2.0 * spreads[0]


def test_judgements_repeat():
    assert judged(TRUE, 1).as_table() == judged(TRUE, 1).as_table()


def test_a_band_holds_95_percent_of_curves_as_a_whole():
    curves = np.cumsum(np.random.default_rng(0).standard_normal((4000, 20)), axis=1)
    low, high = whole_band(curves[:2000])
    inside = ((curves[2000:] >= low) & (curves[2000:] <= high)).all(axis=1)
    assert np.mean(inside) == pytest.approx(0.95, abs=0.02)


def test_autocorrelation_without_gaps_is_numpys():
    values = np.random.default_rng(1).standard_normal(200)
    lags = np.array([1, 5, 20])
    off = values - values.mean()
    wanted = [np.mean(off[:-lag] * off[lag:]) / np.mean(off * off) for lag in lags]
    np.testing.assert_allclose(autocorrelation(values[None], np.ones(200, dtype=bool), lags)[0], wanted)


def test_gaps_are_no_values():
    values = np.random.default_rng(2).standard_normal(200)
    known = np.random.default_rng(3).random(200) < 0.7
    wild = np.where(known, values, 1e9)
    lags = np.arange(1, 10)
    np.testing.assert_allclose(autocorrelation(wild[None], known, lags), autocorrelation(
        np.where(known, values, -7.0)[None], known, lags))


def test_a_correlated_series_is_worth_as_many_values_as_theory_says():
    """Of an autoregressive one (1 - r) / (1 + r) of their number."""
    rng = np.random.default_rng(4)
    values = np.zeros(20_000)
    for k in range(1, values.size):
        values[k] = 0.8 * values[k - 1] + rng.standard_normal()
    found = independent_values(values[:6000], np.ones(6000, dtype=bool))
    assert found == pytest.approx(6000 * 0.2 / 1.8, rel=0.3)
