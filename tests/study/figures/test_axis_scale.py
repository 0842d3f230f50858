from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as some

from fesloop.show.figures.axis_scale import AxisScale

LEVELS = some.lists(some.integers(1, 10**4).map(lambda tenths: 0.1 * tenths), min_size=1, max_size=12,
                    unique=True).map(sorted).map(tuple)


@pytest.mark.slow
@given(LEVELS, some.sampled_from(["linear", "log", "even"]))
def test_squares_about_levels_touch_and_hold_them(levels, kind):
    scale = AxisScale(levels, kind)
    ends = [scale.span(level) for level in levels]
    assert all(left[1] == right[0] for left, right in pairwise(ends))
    assert all(low <= place <= high for (low, high), place in zip(ends, scale.places, strict=True))
    assert scale.close_ends[0] < scale.places[0] <= scale.places[-1] < scale.close_ends[1]


@given(LEVELS, some.sampled_from(["linear", "log", "even"]))
def test_a_number_that_is_a_level_stands_at_it(levels, kind):
    scale = AxisScale(levels, kind)
    assert scale.along(levels).tolist() == scale.places.tolist() == scale.places_of(levels).tolist()


def test_between_levels_one_apart_numbers_stand_in_proportion_and_beyond_them_nowhere():
    scale = AxisScale((0, 10, 50), "even")
    assert scale.along([5.0, 20.0, 50.0]).tolist() == [0.5, 1.25, 2.0]
    assert np.isnan(scale.along([-1.0, 51.0])).all()


def test_text_stands_one_apart():
    assert AxisScale(("p", "pd"), "even").edges.tolist() == [-0.5, 0.5, 1.5]


def test_one_level_has_a_square_of_its_own():
    assert AxisScale((20.0,), "linear").span(20.0) == (19.5, 20.5)
    assert AxisScale((20.0,), "log").span(20.0) == pytest.approx((20.0 / np.exp(0.5), 20.0 * np.exp(0.5)))
