"""Samples that are flat at the end of a sensor's range are found, and none that are not."""

import numpy as np
from agreement_parts import waves
from hypothesis import given, settings
from hypothesis import strategies as st

from fesloop.streams.doubts import clipped_at

SEEDS = st.integers(0, 10_000)
STEPS = st.sampled_from([0.0, 1e-4, 1e-3, 5e-3])
"""Of the numbers: 0 for floats; 5e-3 rad/s is coarser than any sensor."""


def rates(seed, step, noise=2e-3):
    """Rates (n, 3), rad/s, 40 s at 100 Hz, as a sensor of so fine numbers has them."""
    rng = np.random.default_rng(seed)
    values = waves(rng, np.arange(4000) / 100.0, 3.0, 1.0) + noise * rng.standard_normal((4000, 3))
    return np.round(values / step) * step if step else values


@given(seed=SEEDS, step=STEPS, share=st.floats(0.3, 0.85), scale=st.floats(0.5, 2.0))
@settings(max_examples=30, deadline=None)
def test_the_end_of_a_range_is_found_wherever_it_is(seed, step, share, scale):
    values = rates(seed, step)
    # The end of a range is one of the sensor's numbers.
    end = share * np.abs(values).max(axis=0).min()
    end = max(step, np.round(end / step) * step) if step else end
    level, count = clipped_at(np.clip(values, -end, end) * scale)
    assert np.isclose(level, end * scale)
    assert count >= 3


@given(seed=SEEDS, step=STEPS, noise=st.sampled_from([0.0, 2e-3, 0.05]), moving=st.booleans(),
       held=st.integers(1, 10))
@settings(max_examples=40, deadline=None)
def test_what_is_not_clipped_is_not_said_to_be(seed, step, noise, moving, held):
    values = rates(seed, step, noise)
    if not moving:
        rng = np.random.default_rng(seed)
        values = noise * rng.standard_normal((4000, 3)) + 9.81 * np.eye(3)[0]
        values = np.round(values / step) * step if step else values
    # Samples repeated because radio or table hold them, and zeros where they were lost.
    values = np.repeat(values, held, axis=0)
    values[100:170] = 0.0
    assert clipped_at(values) == (0.0, 0)


def test_lost_samples_and_empty_sensors_are_no_trouble():
    values = np.clip(rates(1, 0.0), -2.0, 2.0)
    values[::7] = np.nan
    assert clipped_at(values)[0] == 2.0
    assert clipped_at(np.full((5, 3), np.nan)) == (0.0, 0)
