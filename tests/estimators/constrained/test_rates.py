"""Slow sensors: told from lost samples, interpolated, and no worse than the others."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tracker_parts import run_tracker

from estimators.constrained import ConstrainedTracker
from estimators.constrained.lateness import Lateness
from estimators.constrained.rates import Rates
from fesloop.experiment.metrics.orientation import score_recording
from fesloop.loop.signals import Sample
from fesloop.streams.files import open_recording


def counted(present):
    """`Rates.found` after ticks at which one sensor has a sample where `present`."""
    rates, rng = Rates.unknown(1), np.random.default_rng(0)
    for sample in present:
        values = rng.normal(size=(2, 1, 3)) if sample else np.full((2, 1, 3), np.nan)
        rates.note(*values, 1)
    return int(rates.found()[0])


@given(st.floats(1.5, 5.0), st.floats(0.0, 1.0))
@settings(deadline=None, max_examples=100)
def test_a_slow_rate_is_found_whatever_the_ratio(ratio, start):
    """A sensor with its own clock, whose newest sample each tick takes along if there is one."""
    samples = np.floor((np.arange(200) + start) / ratio)
    assert max(2, math.floor(ratio)) <= counted(np.diff(samples) > 0) <= math.ceil(ratio)


@pytest.mark.parametrize("lost", [0.05, 0.2])
@pytest.mark.parametrize("every", [2, 3, 5])
def test_a_slow_sensor_that_loses_samples_is_slow_and_stays_so(every, lost):
    rng, rates, found = np.random.default_rng(1), Rates.unknown(1), []
    for k in range(4000):
        present = k % every == 0 and rng.random() >= lost
        rates.note(*(rng.normal(size=(2, 1, 3)) if present else np.full((2, 1, 3), np.nan)), 1)
        if k % 40 == 0:
            rates.every[:] = rates.found()
            found.append(int(rates.every[0]))
    assert found == sorted(found), "it is never taken for a quick one again"
    assert found[-1] == every
    for _ in range(60):
        rates.note(*rng.normal(size=(2, 1, 3)), 1)
    assert rates.found()[0] == 1


@pytest.mark.parametrize("lost", [0.0, 0.05, 0.2, 0.5])
def test_losses_at_random_are_no_slow_rate(lost):
    rng = np.random.default_rng(1)
    assert max(counted(rng.random(200) >= lost) for _ in range(100)) == 1


@given(st.lists(st.integers(1, 5), min_size=3, max_size=3), st.booleans(), st.integers(0, 2**32 - 1))
@settings(deadline=None, max_examples=50)
def test_linear_signals_of_slow_sensors_are_those_of_fast_ones(every, held, seed):
    rng = np.random.default_rng(seed)
    slope, start = rng.normal(size=(2, 3, 3))
    lateness = Lateness.unknown(3, 2, 0.01)
    lateness.rates.every[:], lateness.watched, lateness.known = every, True, max(every) > 1
    for k in range(60):
        values = start + 0.01 * k * slope
        for i, each in enumerate(every):
            if k % each:
                values[i] = start[i] + 0.01 * (k - k % each) * slope[i] if held else np.nan
        sample = Sample(values, k, k, k)
        gyr, acc = (each.value for each in lateness.align([sample, sample], 1))
    instant = 59 - (max(every) - 1)
    np.testing.assert_allclose(gyr, start + 0.01 * instant * slope, atol=1e-9)
    np.testing.assert_allclose(acc, gyr, atol=1e-12)
    newest = np.array([59 - 59 % each for each in every])[:, np.newaxis]
    # From there to the newest sample by trapezoids, then by that sample as it is held.
    whole = [sum(0.5 * (at(k) + at(k + 1)) for k in range(instant, 59))
             for at in (lambda k, i=i: (start + 0.01 * np.minimum(k, newest) * slope)[i] for i in range(3))]
    np.testing.assert_allclose(lateness.turns(), 0.01 * np.array(whole) if max(every) > 1 else 0.0, atol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("held", [False, True], ids=["missing", "held"])
@pytest.mark.parametrize("sensor_set", ["rigid", "nonrigid"])
def test_two_sensors_of_half_the_rate_cost_hinges_little(sensor_set, held, recordings):
    recording = open_recording(recordings / "chain5" / "trial1.npz", sensor_set)
    rms_deg = []
    for slow in (False, True):
        kinds = recording.gyr.copy(), recording.acc.copy()
        for values in kinds if slow else ():
            for i in (2, 4):
                values[1::2, i] = values[:-1:2, i][:len(values[1::2])] if held else np.nan
        outputs, reports, _ = run_tracker(ConstrainedTracker(sensors=5), *kinds, rate=40)
        score = score_recording(recording, recording.stamps_ns, outputs[0], "relative")
        rms_deg.append(np.mean([score["orientation_rmse_deg"][f"seg{i}-seg{i + 1}"]["total"]
                                for i in (2, 3, 4)]))
        told = [detail for status, detail in reports if status == "slow_sensor"]
        assert told == (["samples come at different rates: sensor 2 each 2. tick, sensor 4 each 2. tick"]
                        if slow else [])
        assert not [each for each in reports if each[0] == "late_sensor"]
        assert sum(status == "lost_sample" for status, _ in reports) < 100
    assert rms_deg[1] < 1.1 * rms_deg[0]
