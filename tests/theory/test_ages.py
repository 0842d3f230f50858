"""The chain of ages against what can be written down for one tick, and against arrivals drawn one by one."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from linear_parts import sensed_loop, uniform

from fesloop.analysis.theory import schedule as ages
from fesloop.analysis.theory.linear_loop import linear_loop
from fesloop.analysis.theory.schedule import schedule
from fesloop.loop.duration import Duration

MS = 10**6


def chain(wire, sensor_rate=100):
    """(connection, oldest age, probabilities of the ages as the period begins, transitions, looks)."""
    loop = linear_loop(sensed_loop(0.0, 1.0, 1.0, wire, sensor_rate))
    looks = [each.look for event in schedule(loop, False).events for each in event.deliveries if each.look]
    connection = loop.wire("sensor.y->feedback.y")
    oldest = ages.oldest_age(connection, looks)
    transitions = [ages.transition(connection, look, oldest) for look in looks]
    return oldest, ages.stationary(transitions), transitions, looks


JITTERS = st.one_of(
    st.builds(uniform, st.integers(-3, 0), st.integers(1, 60)),
    st.builds(lambda mean, high: Duration(kind="exponential", mean_ms=mean, high_ms=high),
              st.floats(1.0, 30.0), st.floats(5.0, 60.0)),
    st.builds(lambda mean, sd: Duration(kind="normal", mean_ms=mean, sd_ms=sd, low_ms=-3.0, high_ms=50.0),
              st.floats(0.0, 20.0), st.floats(0.5, 20.0)))


@given(jitter=JITTERS, latency=st.floats(3.0, 60.0), loss=st.one_of(st.just(0.0), st.floats(0.01, 0.8)),
       rate=st.sampled_from([25, 50, 75, 100, 150]))
@settings(max_examples=40, deadline=None)
def test_at_one_tick_the_ages_have_the_odds_of_independent_messages(jitter, latency, loss, rate):
    # Seen from one tick messages are independent: age a is held if that message is there and no newer is.
    wire = {"latency_ms": latency, "jitter": jitter, "loss": loss}
    oldest, found, transitions, looks = chain(wire, rate)
    for transition in transitions:
        assert np.allclose(transition.sum(axis=1), 1.0)
        assert (transition >= 0.0).all()
    last = looks[-1]  # the chain is stationary before the first look, which is after the last
    latency_ns = round(latency * MS)
    there, expected = 1.0, []
    for age in range(oldest):
        sent_ns = (last.sent - 1 - age) * 10**9 // rate
        come = (1.0 - loss) * jitter.share_within(last.time_ns - sent_ns - latency_ns)
        expected.append(there * come)
        there *= 1.0 - come
    assert np.allclose(found, [*expected, there], atol=1e-12)


def test_transitions_are_those_of_messages_drawn_one_by_one():
    wire = {"latency_ms": 12.5, "jitter": uniform(0, 45), "loss": 0.25}
    oldest, _, (chances,), _ = chain(wire)
    rng = np.random.default_rng(3)
    ticks = 100_000
    arrival = 10.0 * np.arange(2 * ticks) + 12.5 + rng.uniform(0, 45, 2 * ticks)
    arrival[rng.random(2 * ticks) < 0.25] = np.inf
    newest = np.full(ticks, -1)
    for age in range(oldest):
        sent = 2 * np.arange(ticks) - age
        there = (sent >= 0) & (arrival[np.maximum(sent, 0)] <= 20.0 * np.arange(ticks))
        newest = np.where((newest < 0) & there, age, newest)
    held = np.where(newest < 0, oldest, newest)[10:]
    counts = np.zeros_like(chances)
    np.add.at(counts, (held[:-1], held[1:]), 1)
    seen = counts.sum(axis=1)
    spread = np.sqrt(chances * (1.0 - chances) / np.maximum(seen, 1.0)[:, None])
    often = seen > 200
    assert often.sum() >= 5
    assert (np.abs(counts / np.maximum(seen, 1.0)[:, None] - chances) <= 4.5 * spread + 1e-12)[often].all()


def test_nothing_is_cut_off_however_long_a_run_of_losses():
    oldest, found, _, _ = chain({"latency_ms": 0.0, "jitter": uniform(0, 15), "loss": 0.95})
    assert oldest <= 4
    assert found[-1] == pytest.approx(1.0 - found[:-1].sum())
    assert found[-1] > 0.8
