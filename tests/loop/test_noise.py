"""Counter-based noise: a function of its arguments, and of the distribution that it claims."""

import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from fesloop.loop.block import Context
from fesloop.loop.duration import Duration
from fesloop.loop.noise import NoiseStream, stream_key
from fesloop.loop.wire import Wire


@given(st.lists(st.integers(0, 5000), min_size=1, max_size=20), st.integers(0, 2**64))
def test_a_row_does_not_depend_on_what_was_asked_before(ticks, seed):
    stream = Context("imu", seed).noise(3)
    for tick in ticks:
        assert np.array_equal(stream.row(tick), Context("imu", seed).noise(3).row(tick))
    assert np.array_equal(pickle.loads(pickle.dumps(stream)).row(ticks[0]), stream.row(ticks[0]))


def test_streams_of_other_names_seeds_trials_purposes_are_independent():
    keys = {stream_key(seed, name, trial)
            for seed in range(5) for name in ("a", "b", "a/b") for trial in range(5)}
    assert len(keys) == 75
    one = np.concatenate([Context("a", 1).noise(2).row(k) for k in range(2000)])
    other = np.concatenate([Context("b", 1).noise(2).row(k) for k in range(2000)])
    assert abs(np.corrcoef(one, other)[0, 1]) < 0.06


@pytest.mark.parametrize(("kind", "distribution"), [("normal", stats.norm()), ("uniform", stats.uniform())])
def test_rows_have_the_distribution_and_no_memory(kind, distribution):
    stream = Context("a", 11).noise(2, kind)
    rows = np.array([stream.row(k) for k in range(4000)])
    assert stats.kstest(rows.ravel(), distribution.cdf).pvalue > 1e-3
    centred = rows[:, 0] - rows[:, 0].mean()
    assert abs(np.corrcoef(centred[1:], centred[:-1])[0, 1]) < 0.06


def test_unknown_kinds_are_refused():
    with pytest.raises(ValueError, match="normal, uniform"):
        NoiseStream(1, 2, "pink")


@pytest.mark.parametrize(("duration", "distribution"), [
    (Duration(kind="uniform", low_ms=2, high_ms=5), stats.uniform(2, 3)),
    (Duration(kind="exponential", mean_ms=4, high_ms=1e4), stats.expon(scale=4)),
    (Duration(kind="normal", mean_ms=9, sd_ms=2, low_ms=-100, high_ms=100), stats.norm(9, 2))])
def test_durations_have_their_distribution_and_bounds(duration, distribution):
    stream = Context("w", 3).noise(1, "uniform")
    ns = np.array([duration.draw_ns(float(stream.row(k)[0])) for k in range(4000)])
    assert stats.kstest(ns * 1e-6, distribution.cdf).pvalue > 1e-3
    assert ns.min() >= duration.least_ns
    assert ns.max() <= duration.most_ns


@given(st.floats(0, 1, exclude_max=True), st.floats(-50, 50), st.floats(0, 20), st.floats(-50, 50),
       st.floats(0, 9))
def test_a_clipped_normal_keeps_its_bounds(uniform, mean, sd, low, width):
    duration = Duration(kind="normal", mean_ms=mean, sd_ms=sd, low_ms=low, high_ms=low + width)
    assert duration.least_ns <= duration.draw_ns(uniform) <= duration.most_ns


def test_what_a_wire_draws_depends_on_seed_ends_trial_and_tick_alone():
    def drawn(wire, seed=1, trial=0):
        stream = wire.noise(seed, trial)
        return [stream.row(tick).tolist() for tick in range(3)]

    wire = Wire("a.y", "b.u", loss=0.1)
    assert drawn(wire) == drawn(Wire("a.y", "b.u", latency_ms=5))
    others = [drawn(wire, seed=2), drawn(wire, trial=1), drawn(Wire("a.y", "c.u")), drawn(Wire("c.y", "b.u"))]
    assert all(other != drawn(wire) for other in others)
    assert len({tuple(row) for row in drawn(wire)}) == 3
