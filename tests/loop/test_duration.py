"""The distribution function of durations against what is drawn."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fesloop.errors import InputError
from fesloop.loop.clock import FOREVER
from fesloop.loop.duration import ZERO, Duration

KINDS = st.one_of(
    st.builds(lambda low, width: Duration(kind="uniform", low_ms=low, high_ms=low + width),
              st.integers(-5, 20), st.floats(0.0, 30.0)),
    st.builds(lambda mean, high: Duration(kind="exponential", mean_ms=mean, high_ms=high),
              st.floats(0.5, 30.0), st.floats(0.0, 60.0)),
    st.builds(lambda mean, sd: Duration(kind="normal", mean_ms=mean, sd_ms=sd, low_ms=-3.0, high_ms=50.0),
              st.floats(-5.0, 60.0), st.floats(0.1, 20.0)))


@given(KINDS, st.integers(-10_000_000, 70_000_000))
def test_the_share_within_a_limit_is_the_share_of_the_numbers_that_draw_no_more(jitter, limit_ns):
    # draw_ns rises with its number, so the share is where it passes the limit.
    share = jitter.share_within(limit_ns)
    assert 0.0 <= share <= 1.0
    below, above = share - 1e-7, share + 1e-7
    if below >= 0.0:
        assert jitter.draw_ns(below) <= limit_ns
    if above < 1.0:
        assert jitter.draw_ns(above) > limit_ns or math.isclose(share, jitter.share_within(limit_ns + 1))


@given(KINDS, st.floats(0.0, 1.0, exclude_max=True))
def test_no_number_draws_less_than_the_least_or_more_than_the_most(jitter, uniform):
    assert jitter.least_ns <= jitter.draw_ns(uniform) <= jitter.most_ns


@pytest.mark.parametrize("scale", [0.0, -1.0, math.nan, math.inf, 1e300, 1.1e6])
def test_a_measured_time_is_not_scaled_beyond_what_stamps_reach(scale):
    with pytest.raises(InputError, match=r"^scale: .*; allowed: above 0, at most 1e\+06$"):
        Duration(kind="measured", scale=scale)
    hour_ns = 3_600_000_000_000
    assert round(hour_ns * Duration(kind="measured", scale=1e6).scale) < FOREVER


def test_what_is_not_drawn_has_no_distribution():
    with pytest.raises(InputError, match="uniform, normal, exponential"):
        ZERO.share_within(0)


@pytest.mark.parametrize(("kind", "given"), [
    ("fixed", {"ms": 5e12}), ("uniform", {"low_ms": -5e12, "high_ms": 1.0}),
    ("exponential", {"mean_ms": 1.0, "high_ms": 1e300})])
def test_a_duration_is_no_longer_than_any_run(kind, given):
    """Stamps of a recording are 64 bits of ns, 292 years."""
    with pytest.raises(InputError, match=r"is longer than any run; allowed: below 4\.61e"):
        Duration(kind=kind, **given)


@pytest.mark.parametrize(("duration", "words"), [
    (ZERO, "0 ms"), (Duration(kind="fixed", ms=2.5), "2.5 ms"),
    (Duration(kind="uniform", low_ms=0.0, high_ms=40.0), "0 to 40 ms"),
    (Duration(kind="normal", mean_ms=5.0, sd_ms=2.0, low_ms=0.0, high_ms=20.0), "5 +- 2 ms (0 to 20)"),
    (Duration(kind="exponential", mean_ms=3.0, high_ms=9.0), "3 ms on average (at most 9)"),
    (Duration(kind="measured"), "measured")])
def test_a_duration_is_told_in_words(duration, words):
    assert str(duration) == words
