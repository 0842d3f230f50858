"""A clock's exact rate is found from its stamps, which are whole ns."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fesloop.experiment.export.rates import rate_of_stamps
from fesloop.loop.clock import RateClock


@settings(max_examples=300)
@given(rate=st.one_of(st.integers(1, 2000).map(Fraction), st.sampled_from(
    [Fraction(2000, 7), Fraction(60000, 1001), Fraction(1000, 3), Fraction(15625, 64)])),
    ticks=st.integers(3, 500), first=st.integers(0, 100))
def test_of_a_clock_it_is_the_clocks(rate, ticks, first):
    clock = RateClock.from_rate(str(rate))
    stamps = np.array([clock.tick(first + number) for number in range(ticks)])
    found = rate_of_stamps(stamps)
    assert found.even
    assert found.hertz == pytest.approx(float(rate), rel=2.1e-9 * float(rate) / (ticks - 1))
    assert found.exact.denominator <= rate.denominator


@pytest.mark.parametrize(("stamps", "hertz", "even"), [
    ([], 0.0, False), ([7], 0.0, False), ([7, 7], 0.0, False),
    ([0, 10**7, 2 * 10**7, 4 * 10**7], 75.0, False),
    ([5, 10**7 + 5, 2 * 10**7 + 5], 100.0, True), ([0, 10**7 + 3, 2 * 10**7], 100.0, False)])
def test_of_few_and_uneven_stamps(stamps, hertz, even):
    found = rate_of_stamps(np.array(stamps, np.int64))
    assert (found.hertz, found.even) == (hertz, even)
