"""Force sensors on the hand: each error against its parameter."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fesloop.errors import InputError
from fesloop.hand.anthropometry import FINGERTIPS, PARTS
from fesloop.loop.block import Context, Tick
from fesloop.loop.clock import NS_PER_MS
from fesloop.loop.signals import Sample
from plants.force_sensors import ForceSensors

IDEAL = {"gain_sd": 0.0, "offset_sd": 0.0, "drift": 0.0, "noise_sd": 0.0, "resolution": 0.0}
MANY = len(PARTS)


def read(sensors, forces, ticks, seed=0, trial=0, period_ms=10):
    """(samples (ticks, k), reports) of held or given forces."""
    context = Context("force", seed=seed, trial=trial)
    state, tick, rows, reports = sensors.init(context), Tick(), [], []
    for k in range(ticks):
        tick.index, tick.time_ns = k, k * period_ms * NS_PER_MS
        value = forces(k) if callable(forces) else forces
        rows.append(sensors.step(state, [Sample(value, 0, 0, 0)], tick)[0])
        reports += [(k, *report) for report in tick.reports]
        tick.reports.clear()
    return np.array(rows), reports


def spread_is(values, sd):
    assert abs(values.std() / sd - 1.0) < 4.0 / math.sqrt(2.0 * values.size)
    assert abs(values.mean()) < 4.0 * sd / math.sqrt(values.size)


def test_an_ideal_glove_reads_the_force_on_every_part():
    forces = np.linspace(0.0, 20.0, len(PARTS))
    samples, reports = read(ForceSensors(**IDEAL), forces, 2)
    np.testing.assert_array_equal(samples, [forces] * 2)
    assert not reports


@given(st.lists(st.sampled_from(PARTS), min_size=1, unique=True))
@settings(deadline=None, max_examples=30)
def test_sensors_feel_the_parts_that_they_are_on_and_no_others(places):
    forces = np.arange(1.0, 17.0)
    block = ForceSensors(**IDEAL, places=tuple(places))
    samples, _ = read(block, forces, 1)
    assert dict(zip(places, samples[0], strict=True)) == {place: 1.0 + PARTS.index(place) for place in places}
    (port,) = block.outputs
    assert port.row_names == tuple(places)
    assert port.shape == samples[0].shape


def test_below_its_threshold_a_sensor_shows_nothing():
    sensors = ForceSensors(**IDEAL, places=FINGERTIPS, threshold_n=0.1)
    forces = np.zeros(len(PARTS))
    forces[[PARTS.index(place) for place in FINGERTIPS]] = 0.0, 0.05, 0.099, 0.1, 3.0
    np.testing.assert_array_equal(read(sensors, forces, 1)[0], [[0.0, 0.0, 0.0, 0.1, 3.0]])


def test_gain_and_offset_belong_to_the_sensors():
    sensors = ForceSensors(**IDEAL | {"gain_sd": 0.05, "offset_sd": 0.1}, range_n=100.0)
    both = [np.concatenate([read(sensors, np.full(MANY, force), 1, seed=seed, trial=seed % 2)[0][0]
                            for seed in range(80)]) for force in (10.0, 20.0)]
    gain = (both[1] - both[0]) / 10.0
    spread_is(gain - 1.0, 0.05)
    spread_is(both[0] - 10.0 * gain, 0.1)
    first, again = (read(sensors, np.full(MANY, 5.0), 1, trial=trial)[0] for trial in (0, 1))
    np.testing.assert_array_equal(first, again)


def test_noise_and_drift():
    noisy = ForceSensors(**IDEAL | {"noise_sd": 0.03})
    spread_is(read(noisy, np.full(MANY, 5.0), 100)[0] - 5.0, 0.03)
    drifting = ForceSensors(**IDEAL | {"drift": 0.02})
    for period_ms in (10, 40):
        ticks = 4000 // period_ms + 1
        ends = np.concatenate([
            read(drifting, np.full(MANY, 5.0), ticks, trial=trial, period_ms=period_ms)[0][-1]
            for trial in range(30)])
        spread_is(ends - 5.0, 0.04)


def test_digits_and_the_ends_of_the_range():
    sensors = ForceSensors(**IDEAL | {"resolution": 0.1}, places=("F2m", "palm"), range_n=5.0)

    def forces(k):
        on_parts = dict.fromkeys(PARTS, 0.0) | {"F2m": 0.26, "palm": 7.0 if k in (2, 3) else 1.0}
        return np.array(list(on_parts.values()))

    samples, reports = read(sensors, forces, 6)
    np.testing.assert_allclose(samples[:, 0], 0.3)
    np.testing.assert_allclose(samples[:, 1], [1.0, 1.0, 5.0, 5.0, 1.0, 1.0])
    assert reports == [(2, "saturated", "on palm")]
    below = ForceSensors(**IDEAL | {"noise_sd": 0.1})
    assert read(below, np.zeros(MANY), 10)[0].min() == 0.0


@pytest.mark.parametrize("wrong", [{"gain_sd": -0.1}, {"range_n": 0.0}, {"places": ()},
                                   {"places": ("F1d", "F1d")}, {"places": ("F9",)}, {"noise_sd": math.nan},
                                   {"threshold_n": 25.0}])
def test_parameters_that_cannot_be_are_named(wrong):
    with pytest.raises(InputError, match=next(iter(wrong))):
        ForceSensors(**wrong)
