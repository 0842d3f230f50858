"""Fits of made-up errors whose process is known: about 30 s."""

import numpy as np
import pytest

from fesloop.analysis.tracker_error.error_record import ErrorRecord
from fesloop.analysis.tracker_error.series_fit import MotionColumns, fit_series, quick_time_s
from fesloop.errors import InputError
from fesloop.models.error_process import ErrorSeries
from fesloop.models.error_steps import DRAWS, ensemble, random_variance

RATE, SECONDS = 30.0, 60.0
TIMES = np.arange(int(RATE * SECONDS)) / RATE


def moving(seed=0):
    """A joint that goes to and fro in one to three seconds: angle and rate."""
    rng = np.random.default_rng(seed)
    phase = 2.0 * np.pi * np.cumsum(rng.uniform(0.3, 1.0, TIMES.size)) / RATE
    angle = 0.6 * np.sin(phase)
    return angle, np.gradient(angle, TIMES)


def made(series, seed, lost=0.1, motion=None):
    """A record of a process."""
    angle, rate = moving(seed) if motion is None else motion
    rng = np.random.default_rng(1000 + seed)
    draws = rng.standard_normal((1, DRAWS, TIMES.size))
    error = ensemble(series.row(), angle, rate, np.full(TIMES.size, 1.0 / RATE), draws)[0]
    error[rng.random(TIMES.size) < lost] = np.nan
    return ErrorRecord(name=series.name, moved=True, times_s=TIMES, error=error, angle=angle, rate=rate)


@pytest.mark.slow
def test_time_constant_and_size_of_one_part_are_found():
    """Over ten records: means within three standard errors of the truth."""
    series = ErrorSeries(name="a", bias_deg=1.0, fast_deg=1.5, fast_s=0.4)
    fits = [fit_series(made(series, seed)).series for seed in range(5)]
    for told, true in (("bias_deg", 1.0), ("fast_deg", 1.5), ("fast_s", 0.4)):
        values = np.array([getattr(fit, told) for fit in fits if not fit.slow_deg])
        assert values.size >= 4
        assert abs(values.mean() - true) < 3.0 * values.std(ddof=1) / np.sqrt(values.size) + 0.05 * true


def test_an_error_of_one_part_is_fitted_by_one():
    """More parts always fit better; the criterion weighs that against their parameters."""
    fit = fit_series(made(ErrorSeries(name="a", fast_deg=1.5, fast_s=0.4), 1)).series
    assert (fit.slow_deg, fit.speed_s, fit.smooth, fit.quick_hz) == (0.0, 0.0, False, 0.0)


@pytest.mark.slow
def test_two_parts_make_the_autocorrelation_that_they_have():
    """At each lag from a tenth of a second to three; a minute holds but ten values of the slow part."""
    series = ErrorSeries(name="a", slow_deg=2.0, slow_s=3.0, fast_deg=1.5, fast_s=0.3)
    fits = [fit_series(made(series, seed)).series for seed in range(4)]
    for lag_s in (0.1, 0.5, 1.0, 3.0):
        found = np.mean([correlated(fit, lag_s) for fit in fits])
        assert found == pytest.approx(correlated(series, lag_s), abs=0.2)
    assert np.mean([size(fit) for fit in fits]) == pytest.approx(size(series), rel=0.15)


def size(series):
    return np.sqrt(series.slow_deg**2 + series.fast_deg**2 + series.quick_deg**2)


def correlated(series, lag_s):
    """Autocorrelation of the random part at rest."""
    x = lag_s / max(series.slow_s, 1e-9)
    slow = series.slow_deg**2 * np.exp(-x) * (1.0 + x if series.smooth else 1.0)
    return (slow + series.fast_deg**2 * np.exp(-lag_s / series.fast_s)) / size(series)**2


@pytest.mark.slow
def test_a_part_with_a_derivative_is_known_for_one():
    series = ErrorSeries(name="a", slow_deg=2.0, slow_s=0.6, smooth=True, quick_deg=0.1)
    fits = [fit_series(made(series, seed)).series for seed in range(2)]
    assert sum(fit.smooth for fit in fits) == 2
    assert np.median([fit.slow_s for fit in fits if fit.smooth]) == pytest.approx(0.6, rel=0.25)


@pytest.mark.slow
def test_an_oscillation_is_found_with_its_frequency():
    series = ErrorSeries(name="a", fast_deg=1.0, fast_s=0.5, quick_deg=0.5, quick_s=0.15, quick_hz=9.0)
    fits = [fit_series(made(series, seed)).series for seed in range(3)]
    assert np.median([fit.quick_hz for fit in fits]) == pytest.approx(9.0, abs=0.7)
    assert np.median([fit.quick_s for fit in fits]) == pytest.approx(0.15, rel=0.3)
    assert np.median([fit.quick_deg for fit in fits]) == pytest.approx(0.5, rel=0.15)


@pytest.mark.slow
def test_increments_of_a_fit_are_those_of_the_truth():
    """A smooth start of the increments, and a walk after that: two time constants."""
    series = ErrorSeries(name="a", slow_deg=1.5, slow_s=0.4, smooth=True, rise_s=0.05)
    angle, rate = moving(0)
    steps = np.full(TIMES.size, 1.0 / RATE)
    draws = np.random.default_rng(9).standard_normal((40, DRAWS, TIMES.size))
    for seed in range(2):
        fit = fit_series(made(series, seed)).series
        for lag in (1, 2, 4, 15):
            found, true = (np.std(runs[:, lag:] - runs[:, :-lag]) for runs in (
                ensemble(each.row(), angle, rate, steps, draws) for each in (fit, series)))
            assert found == pytest.approx(true, rel=0.12)


@pytest.mark.slow
def test_several_recordings_have_one_process_and_a_constant_each():
    """Means within three standard errors: a lead and the noise are common, constants are not."""
    common = {"lead_s": 0.03, "fast_deg": 0.8, "fast_s": 0.3}
    biases = (-2.0, 0.5, 3.0)
    records = [made(ErrorSeries(name="a", bias_deg=bias, **common), seed) for seed, bias in enumerate(biases)]
    fit = fit_series(*records)
    np.testing.assert_allclose(fit.biases_deg, biases, atol=0.3)
    assert fit.series.bias_deg == pytest.approx(np.mean(fit.biases_deg))
    assert fit.series.bias_sd_deg == pytest.approx(np.std(fit.biases_deg, ddof=1))
    assert fit.series.lead_s == pytest.approx(0.03, abs=0.004)
    assert size(fit.series) == pytest.approx(0.8, rel=0.1)
    assert fit.innovations.size == 3 * TIMES.size
    assert fit_series(records[0]).series.bias_sd_deg == 0.0


@pytest.mark.slow
def test_recordings_of_other_sizes_have_common_time_constants():
    records = [made(ErrorSeries(name="a", fast_deg=size, fast_s=0.3), seed)
               for seed, size in enumerate((0.5, 1.0, 2.0))]
    fit = fit_series(*records).series
    assert fit.size_sd == pytest.approx(np.log(2.0), rel=0.15)
    assert size(fit) == pytest.approx(np.sqrt((0.25 + 1.0 + 4.0) / 3.0), rel=0.15)
    assert correlated(fit, 0.3) == pytest.approx(np.exp(-1.0), abs=0.1)


@pytest.mark.slow
def test_recordings_of_other_rates_are_fitted_together():
    """Of the same process; the second one at four times the rate."""
    series = ErrorSeries(name="a", fast_deg=1.0, fast_s=0.4)
    times = np.arange(4 * TIMES.size) / (4.0 * RATE)
    still, steps = np.zeros(times.size), np.full(times.size, 1.0 / (4.0 * RATE))
    draws = np.random.default_rng(11).standard_normal((1, DRAWS, times.size))
    fine = ErrorRecord(name="a", moved=True, times_s=times, angle=still, rate=still,
                       error=ensemble(series.row(), still, still, steps, draws)[0])
    fit = fit_series(made(series, 3), fine).series
    assert size(fit) == pytest.approx(1.0, rel=0.2)
    assert correlated(fit, 0.4) == pytest.approx(np.exp(-1.0), abs=0.15)


@pytest.mark.slow
def test_what_follows_from_the_motion_is_found_and_nothing_where_nothing_does():
    lagging = ErrorSeries(name="a", lead_s=-0.03, slope=0.05, fast_deg=0.5, fast_s=0.2)
    idle = ErrorSeries(name="a", fast_deg=0.5, fast_s=0.2)
    found = [fit_series(made(lagging, seed)).series for seed in range(2)]
    assert np.mean([fit.lead_s for fit in found]) == pytest.approx(-0.03, abs=0.004)
    assert np.mean([fit.slope for fit in found]) == pytest.approx(0.05, abs=0.02)
    nothing = [fit_series(made(idle, seed)).series for seed in range(2)]
    assert max(abs(fit.lead_s) for fit in nothing) < 0.005
    assert max(abs(fit.slope) for fit in nothing) < 0.03


@pytest.mark.slow
def test_motion_that_drives_the_fast_part_is_found():
    series = ErrorSeries(name="a", fast_deg=0.3, fast_s=0.2, speed_s=2.0)
    fits = [fit_series(made(series, seed)).series for seed in range(3)]
    shaken = [fit for fit in fits if fit.speed_s]
    assert len(shaken) >= 2
    assert np.median([fit.fast_deg * fit.speed_s for fit in shaken]) == pytest.approx(0.6, rel=0.4)


def test_of_one_or_two_movements_nothing_is_said_to_follow():
    angle = np.where(TIMES < 20.0, 0.0, np.sin(0.1 * (TIMES - 20.0)))
    motion = (angle, np.gradient(angle, TIMES))
    record = made(ErrorSeries(name="a", slope=0.1, fast_deg=0.1, fast_s=0.2), 0, motion=motion)
    assert MotionColumns(record).choices() == [(0,)]
    assert fit_series(record).series.slope == 0.0


@pytest.mark.slow
def test_the_process_has_the_mean_square_that_was_measured():
    series = ErrorSeries(name="a", bias_deg=-1.0, lead_s=0.02, slow_deg=1.0, slow_s=4.0, fast_deg=0.5,
                         fast_s=0.2)
    record = made(series, 3)
    fit = fit_series(record).series
    known, row = record.known, fit.row()
    follows = MotionColumns(record).values @ np.array([np.radians(fit.bias_deg), fit.slope,
                                                       np.radians(fit.curve_deg), fit.lead_s])
    whole = np.mean(follows[known] ** 2) + np.mean(random_variance(row, record.rate, record.steps_s)[known])
    assert whole == pytest.approx(np.mean(record.error[known] ** 2), rel=1e-9)


@pytest.mark.slow
def test_a_walk_is_called_too_slow_to_tell():
    rng = np.random.default_rng(7)
    record = made(ErrorSeries(name="a", fast_deg=0.1, fast_s=0.1), 0)
    walk = np.cumsum(rng.standard_normal(TIMES.size)) * 0.01
    drifting = ErrorRecord(name="a", moved=True, times_s=TIMES, error=record.error + walk + 0.004 * TIMES,
                           angle=record.angle, rate=record.rate)
    assert fit_series(drifting).too_slow
    assert not fit_series(record).too_slow


def test_the_quick_part_is_as_quick_as_the_samples_say():
    angle, rate = moving()
    steps = np.full(TIMES.size, 1.0 / RATE)
    for quick_s in (0.0, 0.03):
        series = ErrorSeries(name="a", fast_deg=1.0, fast_s=0.5, quick_deg=0.5, quick_s=quick_s)
        draws = np.random.default_rng(8).standard_normal((40, DRAWS, TIMES.size))
        runs = ensemble(series.row(), angle, rate, steps, draws)
        found = np.mean([quick_time_s(series, run, rate, steps) for run in runs])
        assert found == pytest.approx(quick_s, abs=0.008)


def test_too_little_is_refused():
    record = made(ErrorSeries(name="a", fast_deg=1.0, fast_s=0.2), 0, lost=0.99)
    with pytest.raises(InputError, match="errors are known; allowed: 100 or more"):
        fit_series(record)
    still = ErrorRecord(name="a", moved=True, times_s=TIMES, error=np.full(TIMES.size, 0.1),
                        angle=record.angle, rate=record.rate)
    with pytest.raises(InputError, match="never changes"):
        fit_series(still)
