import math
from itertools import product

import numpy as np
import pytest
import scipy.stats as st
from hypothesis import given, settings
from hypothesis import strategies as some

from fesloop.analysis.study.results.statistics import (
    mean_interval,
    median_interval,
    share_difference_interval,
    share_interval,
    sign_test,
    signed_rank_test,
)

CONFIDENCES = some.sampled_from([0.8, 0.9, 0.95, 0.99])
NUMBERS = some.lists(some.floats(-1e3, 1e3), min_size=2, max_size=40)
SWITCHES = some.lists(some.sampled_from([0.0, 1.0]), min_size=1, max_size=60)


@given(NUMBERS, CONFIDENCES)
def test_the_interval_of_a_mean_is_that_of_scipy(values, confidence):
    sd = np.std(values, ddof=1)
    expected = st.t.interval(confidence, len(values) - 1, np.mean(values), max(sd, 1e-300)
                             / math.sqrt(len(values)))
    if sd <= 1e-9 * abs(np.mean(values)):
        expected = math.nan, math.nan
    assert mean_interval(values, confidence) == pytest.approx(expected, rel=1e-9, abs=1e-9, nan_ok=True)


@given(SWITCHES, CONFIDENCES)
def test_the_interval_of_a_share_is_that_of_scipy(values, confidence):
    expected = st.binomtest(int(sum(values)), len(values)).proportion_ci(confidence, method="wilson")
    assert share_interval(values, confidence) == pytest.approx((expected.low, expected.high), abs=1e-12)


@given(some.integers(1, 40), CONFIDENCES)
def test_the_interval_of_a_median_is_the_narrowest_that_holds_it_at_that_rate(n, confidence):
    low, high = median_interval(np.arange(n), confidence)
    ways = [st.binom.cdf(n - cut, n, 0.5) - st.binom.cdf(cut - 1, n, 0.5) for cut in range(1, n // 2 + 1)]
    good = [cut for cut, rate in enumerate(ways, 1) if rate >= confidence - 1e-12]
    if not good:
        assert math.isnan(low)
        assert math.isnan(high)
    else:
        assert (low, high) == (max(good) - 1, n - max(good))


def test_fewer_than_six_values_give_no_interval_of_a_median():
    assert np.isnan(median_interval(range(5), 0.95)).all()
    assert median_interval([3, 1, 2, 6, 5, 4], 0.95) == (1.0, 6.0)


@pytest.mark.parametrize("interval", [mean_interval, median_interval])
def test_one_value_or_an_infinite_one_gives_no_interval(interval):
    assert np.isnan(interval([1.0], 0.95)).all()
    assert np.isnan(interval([1.0] * 9 + [math.inf], 0.95)).all()


def test_no_value_gives_no_interval_of_a_share():
    assert np.isnan(share_interval([], 0.95)).all()
    assert np.isnan(share_difference_interval([], [], 0.95)).all()


def counts(both, first, second, neither):
    """Pairs of which both hold, the first alone, the second alone, neither."""
    return (np.repeat([1.0, 1.0, 0.0, 0.0], [both, first, second, neither]),
            np.repeat([1.0, 0.0, 1.0, 0.0], [both, first, second, neither]))


@pytest.mark.parametrize(("table", "expected"), [
    ((36, 12, 2, 0), (0.0569, 0.3404)), ((54, 0, 0, 0), (-0.0664, 0.0664)),
    ((30, 0, 0, 0), (-0.1135, 0.1135)), ((0, 30, 0, 0), (0.8395, 1.0))])
def test_the_interval_of_a_difference_of_shares_is_newcombes(table, expected):
    """Method 10 in the examples of his paper, to its digits."""
    assert share_difference_interval(*counts(*table), 0.95) == pytest.approx(expected, abs=6e-5)


@given(some.tuples(*[some.integers(0, 20)] * 4).filter(any))
def test_the_interval_of_a_difference_of_shares_is_that_of_counts(table):
    """His formulas as they stand in the paper, for the four counts of a table."""
    found = share_difference_interval(*counts(*table), 0.95)
    assert found == pytest.approx(written_out(*table), abs=1e-7)


def written_out(a, b, c, d):
    n = a + b + c + d
    (l2, u2), (l3, u3) = (st.binomtest(k, n).proportion_ci(0.95, method="wilson") for k in (a + b, a + c))
    p, q = (a + b) / n, (a + c) / n
    top = a * d - b * c
    top = max(top - n / 2, 0.0) if top > 0 else top
    bottom = (a + b) * (c + d) * (a + c) * (b + d)
    phi = top / math.sqrt(bottom) if bottom else 0.0
    low = math.sqrt((p - l2) ** 2 - 2 * phi * (p - l2) * (u3 - q) + (u3 - q) ** 2)
    high = math.sqrt((q - l3) ** 2 - 2 * phi * (q - l3) * (u2 - p) + (u2 - p) ** 2)
    return p - q - low, p - q + high


@given(some.lists(some.floats(-10, 10).map(lambda x: round(x, 1)), min_size=1, max_size=30))
def test_the_sign_test_is_that_of_scipy(differences):
    up, down = sum(x > 0 for x in differences), sum(x < 0 for x in differences)
    expected = st.binomtest(up, up + down).pvalue if up + down else 1.0
    assert sign_test(differences) == pytest.approx(expected, rel=1e-9)


def test_the_signed_rank_test_counts_every_sign():
    values = np.array([0.3, -1.1, 2.0, 3.7, 4.5, -0.2])
    ranks = st.rankdata(np.abs(values))
    rank_sum = ranks[values > 0].sum()
    every = np.array([sum(r for r, up in zip(ranks, signs, strict=True) if up)
                      for signs in product([0, 1], repeat=6)])
    middle = ranks.sum() / 2
    expected = np.mean(np.abs(every - middle) >= abs(rank_sum - middle))
    assert signed_rank_test([*values, 0.0]) == pytest.approx(expected)
    assert signed_rank_test([0.0, 0.0]) == 1.0


def covered(interval, draws, truth):
    """How often an interval of a row of draws holds the truth."""
    return np.mean([low <= truth <= high for low, high in (interval(row, 0.9) for row in draws)])


TRIALS = 1000
ROOM = 4.0 * math.sqrt(0.9 * 0.1 / TRIALS)
"""Of a rate of 0.9 counted in that many trials: four standard errors."""


@pytest.mark.parametrize("n", [3, 10, 40])
def test_the_interval_of_a_mean_holds_it_at_its_rate(n):
    draws = np.random.default_rng(n).normal(2.0, 3.0, (TRIALS, n))
    assert covered(mean_interval, draws, 2.0) == pytest.approx(0.9, abs=ROOM)


@pytest.mark.parametrize("n", [8, 25])
def test_the_interval_of_a_median_holds_it_at_its_rate_or_more(n):
    draws = np.random.default_rng(n).exponential(1.0, (TRIALS, n))
    cut = int(st.binom.ppf(0.05, n, 0.5))
    exact = 1.0 - 2.0 * st.binom.cdf(cut - 1, n, 0.5)
    assert exact >= 0.9
    assert covered(median_interval, draws, math.log(2.0)) == pytest.approx(exact, abs=ROOM)


@settings(max_examples=20)
@given(some.integers(10, 60), some.floats(0.1, 0.9))
def test_the_interval_of_a_share_holds_it_at_about_its_rate(n, share):
    """Summed over all counts. Wilson's is not exact: about its rate, never far below."""
    rate = 0.0
    for k in range(n + 1):
        low, high = share_interval([1.0] * k + [0.0] * (n - k), 0.95)
        rate += st.binom.pmf(k, n, share) * (low <= share <= high)
    assert rate >= 0.91


@pytest.mark.parametrize(("alike", "gap"), [(0.0, 0.0), (0.6, 0.0), (0.6, 0.2), (0.9, 0.1)])
def test_the_interval_of_a_difference_of_shares_holds_it_at_its_rate_or_more(alike, gap):
    generator = np.random.default_rng(7)
    trials, n, share = 2000, 40, 0.5
    common = generator.random((trials, n))
    own = np.where(generator.random((trials, n)) < alike, common, generator.random((trials, n)))
    first, second = common < share + gap, own < share
    held = np.mean([low <= gap <= high for low, high in (
        share_difference_interval(one, other, 0.9) for one, other in zip(first, second, strict=True))])
    assert 0.9 - 4.0 * math.sqrt(0.09 / trials) <= held <= 0.995
