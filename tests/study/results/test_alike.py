"""Repeated values that do not differ have no interval, and are said not to."""

import numpy as np
import pytest

from fesloop.analysis.study.results.estimates import in_words, spread
from fesloop.analysis.study.results.statistics import mean_interval, share_interval
from fesloop.show.report.study.shown import value_text


@pytest.mark.parametrize("value", [27.8, 0.1, 0.0, -3e5])
@pytest.mark.parametrize("count", [2, 3, 7])
def test_values_that_do_not_differ_are_said_not_to(value, count):
    values = np.full(count, value)
    low, high = mean_interval(values, 0.95)
    told = in_words(float(values.mean()), low, high, count, spread(values))
    assert told == f"{value:.3g} (no interval: {count} values that do not differ)"
    assert value_text(value, low, high, spread(values), share=False).endswith(" (values do not differ)")
    values[0] += 0.1
    assert " to " in in_words(value, *mean_interval(values, 0.95), count, spread(values))


def test_a_share_of_successes_alone_is_as_unsure_as_their_number():
    low, high = share_interval([1.0, 1.0, 1.0], 0.95)
    assert in_words(1.0, low, high, 3, 0.0) == f"1 ({low:.3g} to 1)"
