import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from controllers.safety import Safety
from fesloop.errors import InputError
from fesloop.loop.block import Context, Tick
from fesloop.loop.signals import NEVER, Sample

MS = 1_000_000
GENTLE = {"channels": 1, "current_max_ma": 40.0, "width_max_us": 400.0, "charge_max_uc": 8.0,
          "charge_rise_uc": 2.0, "max_age_ms": 100.0, "ramp_ms": 50.0}


def run(safety, values, ages_ms=None, period_ms=25):
    """Pulses (ticks, channels, 2) and reports for one input a tick."""
    state, tick, pulses = safety.init(Context("safety")), Tick(), []
    for k, value in enumerate(values):
        now = tick.time_ns = k * period_ms * MS
        age = 0 if ages_ms is None else ages_ms[k] * MS
        sample = Sample(np.array(value, dtype=float), now - age, now, now)
        pulses.append(safety.step(state, (sample,), tick)[0])
    return np.array(pulses), tick.reports


@settings(deadline=None, max_examples=200)
@given(st.lists(st.tuples(*[st.floats() | st.sampled_from([0.02, 3e-4, 1e-3, -0.01])] * 4,
                          st.sampled_from([0, 0, 0, 90, 101, 5000])), min_size=1, max_size=12))
def test_output_is_within_every_limit_whatever_comes_in(rows):
    safety = Safety(**GENTLE | {"channels": 2, "energy_max_mj": 2.0})
    values = [[row[0:2], row[2:4]] for row in rows]
    pulses, _ = run(safety, values, [row[4] for row in rows])
    current, width = pulses[:, :, 0], pulses[:, :, 1]
    assert np.isfinite(pulses).all()
    assert (pulses >= 0.0).all()
    assert current.max() <= 40e-3
    assert width.max() <= 400e-6
    charge = current * width
    assert charge.max() <= 8e-6
    assert (2.0 * 500.0 * current**2 * width).max() <= 2e-3
    risen = np.diff(charge, axis=0, prepend=np.zeros((1, 2)))
    assert risen.max() <= 2e-6 * (1.0 + 1e-12)


def test_what_is_within_the_limits_passes_unchanged():
    values = [[[10e-3, 190e-6]], [[20e-3, 190e-6]], [[0.0, 0.0]]]
    pulses, reports = run(Safety(**GENTLE), values)
    np.testing.assert_array_equal(pulses, values)
    assert reports == []


def test_charge_rises_by_the_limit_and_falls_at_once():
    pulses, reports = run(Safety(**GENTLE), [[[20e-3, 399e-6]]] * 5 + [[[20e-3, 50e-6]]])
    charges = pulses[:, 0, 1] * 20e-3
    np.testing.assert_allclose(charges, [2e-6, 4e-6, 6e-6, 7.98e-6, 7.98e-6, 1e-6], rtol=1e-12)
    assert [status for status, _ in reports] == ["slew_limited"]


@pytest.mark.parametrize(("ages_ms", "bad", "status"), [
    ([0, 0, 120, 130, 140, 0], {}, "stale_input"),
    (None, {2: math.nan, 3: math.inf, 4: math.nan}, "non_finite"),
])
def test_bad_input_ramps_to_zero_is_told_once_and_ends(ages_ms, bad, status):
    values = [[[19e-3, bad.get(k, 100e-6)]] for k in range(6)]
    pulses, reports = run(Safety(**GENTLE), values, ages_ms)
    np.testing.assert_allclose(pulses[:, 0, 1], [100e-6, 100e-6, 100e-6, 50e-6, 0.0, 100e-6])
    assert [told for told, _ in reports] == [status]


def test_nothing_passes_before_the_first_input():
    safety, tick = Safety(**GENTLE), Tick()
    state = safety.init(Context("safety"))
    absent = Sample(np.full((1, 2), 0.01), NEVER, NEVER, NEVER)
    assert not safety.step(state, (absent,), tick)[0].any()
    assert [status for status, _ in tick.reports] == ["no_input"]


def test_takes_the_number_of_channels_from_the_wire():
    open_ended = Safety()
    assert open_ended.inputs[0].shape == (None, 2)
    assert open_ended.resolve({"stimulation": (3, 2)}).outputs[0].shape == (3, 2)


@pytest.mark.parametrize(("key", "value"), [
    ("current_max_ma", 0.0), ("charge_max_uc", math.nan), ("energy_max_mj", 301.0), ("max_age_ms", -1.0),
    ("channels", -1)])
def test_names_the_faulty_key(key, value):
    with pytest.raises(InputError, match=key):
        Safety(**{key: value})
