"""Rotation through gaps: against Gaussian conditioning, drawn processes, and recordings less packets."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm
from tracker_parts import run_tracker

from estimators.arrivals import LOST
from estimators.constrained import ConstrainedTracker
from estimators.gaps import Gaps, bridge, turn_after, turn_within
from estimators.kortier import KortierTracker
from fesloop.experiment.metrics.orientation import score_recording
from fesloop.streams.files import open_recording

PERIOD, SD, DAMPING = 0.01, 2.0, 2.0


def conditioned(gap_s, both):
    """Weight of the known rates and variance of the turn, by conditioning rates on a fine grid."""
    times = np.linspace(0.0, gap_s, 401)
    weights = np.full(401, gap_s / 400)
    weights[[0, -1]] *= 0.5
    lag = DAMPING * np.abs(times[:, None] - times)
    cov = SD**2 * (1.0 - lag) * np.exp(-lag)
    known = [0, -1] if both else [0]
    with_known = weights @ cov[:, known]
    gain = np.linalg.solve(cov[np.ix_(known, known)], with_known)
    return gain[0], weights @ cov @ weights - gain @ with_known


@given(st.floats(0.02, 5.0))
@settings(deadline=None, max_examples=50)
def test_turns_are_those_of_a_conditioned_process(gap_s):
    for both, turn in ((False, turn_within), (True, turn_after)):
        share, variance = turn(gap_s, SD)
        weight, expected = conditioned(gap_s, both)
        assert share == pytest.approx(weight, rel=1e-3, abs=1e-4)
        assert variance == pytest.approx(expected, rel=1e-2, abs=1e-9)


def drawn(sensors, ticks, rng):
    """Rates (ticks, sensors, 3) of the process at samples, and turns since the first sample."""
    drift = np.array([[0.0, 1.0], [-DAMPING**2, -2.0 * DAMPING]])
    cov = SD**2 * np.diag([1.0 / DAMPING**2, 1.0])
    step = expm(PERIOD * drift)
    root = np.linalg.cholesky(cov - step @ cov @ step.T)
    x = np.linalg.cholesky(cov) @ rng.normal(size=(sensors * 3, 2, 1))
    states = [x]
    for _ in range(ticks - 1):
        x = step @ x + root @ rng.normal(size=x.shape)
        states.append(x)
    found = np.array(states)[..., 0].reshape(ticks, sensors, 3, 2)
    return found[..., 1], found[..., 0] - found[0, ..., 0]


@pytest.mark.parametrize("length", [1, 3, 10, 60])
def test_errors_within_and_after_gaps_have_the_stated_variance(length):
    sensors, rng = 3000, np.random.default_rng(length)
    rates, turns = drawn(sensors, length + 2, rng)
    gaps, codes = Gaps.none(sensors), np.zeros(sensors, dtype=np.uint8)
    turned, variance = np.zeros((sensors, 3)), 0.0
    for k in range(length + 2):
        codes[:] = LOST if 0 < k <= length else 0
        told = bridge(rates[k] if 0 in (k, length + 1 - k) else np.full((sensors, 3), np.nan), codes, PERIOD,
                      PERIOD, PERIOD, SD, gaps)
        assert told == (k > 0)
        if k:
            turned += PERIOD * gaps.means
            variance += PERIOD * gaps.spread[0]
            if k > 1 or length == 1:
                square = np.mean((turned - turns[k]) ** 2)
                assert square == pytest.approx(variance + gaps.pending[0], rel=0.06)
    assert gaps.pending.max() == 0.0


@given(st.integers(0, 2**32 - 1))
@settings(deadline=None, max_examples=20)
def test_sound_samples_pass_unchanged_and_nothing_spreads(seed):
    rates = np.random.default_rng(seed).normal(size=(20, 4, 3))
    gaps, codes = Gaps.none(4), np.zeros(4, dtype=np.uint8)
    for k, rate in enumerate(rates):
        assert not bridge(rate, codes, PERIOD, PERIOD, PERIOD, SD, gaps)
        np.testing.assert_array_equal(gaps.rates, rate)
        np.testing.assert_array_equal(gaps.means, 0.5 * (rate + rates[max(k - 1, 0)]))
    assert gaps.spread.max() == gaps.pending.max() == 0.0


def test_samples_taken_for_a_whole_step_add_up_as_without_the_gap():
    """Rates that rise evenly: such a filter is half a period ahead of the newest sample, after a gap too."""
    gaps, codes = Gaps.none(1), np.zeros(1, dtype=np.uint8)
    samples, total = 1.0 + np.arange(10.0), 0.0
    for k, rate in enumerate(samples):
        codes[:] = LOST if k in (4, 5) else 0
        bridge(np.full((1, 3), rate), codes, PERIOD, PERIOD, PERIOD, SD, gaps)
        total += gaps.rates[0, 0]
    assert total == pytest.approx(samples.sum(), rel=0.005)


@given(st.lists(st.integers(0, 3), min_size=20, max_size=60))
@settings(deadline=None, max_examples=100)
def test_late_samples_turn_as_far_as_those_in_time(ages):
    """At tick k the newest sample is that of tick k - age, unless a later one has come."""
    gaps, codes, turned, newest = Gaps.none(1), np.zeros(1, dtype=np.uint8), 0.0, -1

    def rate(k):
        return 1.0 + 0.1 * math.sin(0.05 * k)

    for tick, age in enumerate(ages):
        latest = max(tick - age, newest, 0)
        captured = PERIOD * (latest - newest)
        newest = latest
        bridge(np.full((1, 3), rate(latest)), codes, PERIOD, captured, PERIOD, SD, gaps)
        turned += PERIOD * gaps.means[0, 0] if tick else 0.0
        ahead = gaps.predicted[0, 0]
        whole = PERIOD * sum(0.5 * (rate(k) + rate(k + 1)) for k in range(latest))
        assert turned - ahead == pytest.approx(whole, abs=2e-4 * (1 + tick))


def test_a_gap_without_end_leaves_numbers():
    gaps, codes = Gaps.none(1), np.zeros(1, dtype=np.uint8)
    bridge(np.full((1, 3), 5.0), codes, PERIOD, PERIOD, PERIOD, SD, gaps)
    codes[:] = LOST
    turned = 0.0
    for _ in range(100_000):
        bridge(np.full((1, 3), np.nan), codes, PERIOD, PERIOD, PERIOD, SD, gaps)
        turned += PERIOD * gaps.means[0, 0]
    assert abs(turned) < 1e-9
    assert gaps.spread[0] < 1e-9
    codes[:] = 0
    bridge(np.full((1, 3), 5.0), codes, PERIOD, PERIOD, PERIOD, SD, gaps)
    assert abs(PERIOD * gaps.means[0, 0]) < 1e-9


def without_packets(recording, share, length, seed=0):
    """(gyr, acc) of a recording that has lost this share of each sensor's packets, `length` in a row."""
    rng = np.random.default_rng(seed)
    count, sensors = recording.gyr.shape[:2]
    first = rng.random((count, sensors)) < share / (length - share * (length - 1))
    lost = np.zeros((count, sensors), dtype=np.bool_)
    for k in range(length):
        lost[k:] |= first[:count - k]
    lost[:8] = False
    return [np.where(lost[..., None], np.nan, kind) for kind in (recording.gyr, recording.acc)]


def hinges(tracker, recording, gyr, acc):
    orientation = run_tracker(tracker, gyr, acc, rate=40)[0][0]
    score = score_recording(recording, recording.stamps_ns, orientation, "relative")
    return np.mean([score["orientation_rmse_deg"][f"seg{i}-seg{i + 1}"]["total"] for i in (2, 3, 4)])


@pytest.mark.parametrize(("tracker", "sensor_set"), [
    (ConstrainedTracker(sensors=5), "rigid"),
    *(pytest.param(*row, marks=pytest.mark.slow) for row in (
        (ConstrainedTracker(sensors=5), "nonrigid"),
        (KortierTracker(sensors=5, magnetometers=False), "rigid"),
        (KortierTracker(sensors=5, magnetometers=False), "nonrigid")))])
def test_hinges_of_the_chain_through_lost_packets(recordings, tracker, sensor_set):
    recording = open_recording(str(recordings / "chain5" / "trial1.npz"), sensor_set)
    whole = hinges(tracker, recording, recording.gyr, recording.acc)
    for share, length, most in ((0.05, 1, 1.25), (0.2, 1, 1.5), (0.2, 3, 2.5)):
        found = hinges(tracker, recording, *without_packets(recording, share, length))
        print(f"{share:g} lost, {length} in a row: {found:.2f} deg, without loss {whole:.2f}")
        assert found <= most * whole
