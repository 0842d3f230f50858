import base64
import json

import hypothesis.extra.numpy as arrays
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fesloop.show.report.drawn import Numbers, encoded

_ANY = arrays.arrays(np.float64, st.integers(0, 200),
                     elements=st.floats(allow_nan=True, allow_infinity=True, allow_subnormal=False))
"""Steps between subnormal numbers cannot be divided by 65534."""


def read(made):
    """What a page's script reads, from the description of the encoding alone."""
    made = json.loads(json.dumps(made, allow_nan=False))
    if "count" in made:
        return made["from"] + (made["to"] - made["from"]) * np.arange(made["count"]) / (made["count"] - 1)
    (kind,) = made.keys() & {"f8", "u4", "i2"}
    values = np.frombuffer(base64.b64decode(made[kind]), dtype=f"<{kind}")
    if kind != "i2":
        return values
    return np.where(values == -32768, np.nan, made["low"] + (values + 32767.0) * made["step"])


@given(_ANY)
def test_numbers_come_back_within_half_of_a_65534th_of_their_range_and_none_as_none(values):
    back = read(encoded(values))
    assert back.shape == values.shape
    assert np.array_equal(np.isnan(back), np.isnan(values))
    infinite = np.isinf(values)
    assert np.array_equal(back[infinite], values[infinite])
    finite = np.isfinite(values)
    if finite.any():
        span = np.longdouble(values[finite].max()) - np.longdouble(values[finite].min())
        largest = np.abs(values[finite]).max()
        assert (np.abs(back[finite] - values[finite]) <= span / 65534 / 2 * 1.001 + 1e-12 * largest).all()


@given(arrays.arrays(np.float64, st.integers(0, 64), elements=st.floats(-1e3, 1e3) | st.just(np.nan)))
def test_a_few_numbers_are_exact_but_for_rounding(values):
    assert read(encoded(values)) == pytest.approx(values, rel=1e-9, abs=1e-6, nan_ok=True)


def test_evenly_spaced_numbers_take_three_numbers():
    assert encoded(np.linspace(0.5, 2.5, 1000)) == {"from": 0.5, "to": 2.5, "count": 1000}


def test_numbers_that_are_almost_evenly_spaced_are_kept_as_they_are():
    values = np.linspace(0.0, 1.0, 1000)
    values[500] += 5e-5
    assert np.abs(read(encoded(values)) - values).max() <= 1.0 / 65534


def test_a_number_among_many_equal_ones_is_kept():
    values = np.full(100, 3.0)
    values[40] = np.nan
    assert np.array_equal(read(encoded(values)), values, equal_nan=True)


def test_a_long_line_takes_two_bytes_a_point():
    values = np.sin(np.arange(10_000.0))
    assert len(json.dumps(encoded(values))) < 10_000 * 2 * 4 / 3 + 100


def test_the_same_numbers_are_kept_once_whatever_their_shape():
    numbers = Numbers()
    values = np.random.default_rng(1).normal(size=(50, 4))
    assert numbers.add(values) == numbers.add(values.ravel()) == 0
    assert numbers.add(values + 1.0) == 1
    assert len(numbers.kept) == 2


@given(arrays.arrays(np.int32, st.tuples(st.integers(0, 50), st.just(3)), elements=st.integers(0, 2**31 - 1)))
def test_whole_numbers_are_exact(values):
    numbers = Numbers()
    assert np.array_equal(read(numbers.kept[numbers.add_whole(values)]), values.ravel())
