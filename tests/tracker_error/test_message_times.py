"""Age and loss of estimates."""

import numpy as np
import pytest

from fesloop.analysis.tracker_error.fitting import message_times
from fesloop.experiment.recording.reading import Signal

MS = 1_000_000


def signal(newest_ns, left_ns):
    count = len(newest_ns)
    return Signal("tracker.angles", "rad", np.arange(count), np.asarray(left_ns), np.zeros((count, 1)),
                  np.asarray(newest_ns), np.asarray(newest_ns), np.asarray(left_ns))


def test_what_is_prompt_and_whole_has_neither():
    ticks = np.arange(100) * 10 * MS
    found = message_times(signal(ticks, ticks), np.zeros(100, dtype=bool), 10**12)
    assert (found.age_ms, found.jitter.kind, found.loss, found.burst_messages) == (0.0, "zero", 0.0, 0.0)


def test_age_is_a_least_one_and_what_comes_on_top():
    ticks = np.arange(5000) * 10 * MS
    late = np.random.default_rng(0).exponential(3.0, 5000) * MS
    left = ticks + 20 * MS + late.astype(int)
    found = message_times(signal(ticks, left), np.zeros(5000, dtype=bool), 10**18)
    assert found.age_ms == pytest.approx(20.0, abs=0.01)
    assert found.jitter.mean_ms == pytest.approx(3.0, rel=0.05)


def test_losses_and_their_bursts_are_counted_before_the_cut_alone():
    newest = np.arange(100)
    for start in (10, 30, 50):
        newest[start:start + 4] = newest[start - 1]
    newest[80:] = newest[79]
    left = np.arange(100) * 10 * MS
    found = message_times(signal(newest * 10 * MS, left), np.zeros(100, dtype=bool), left[60])
    assert found.loss == pytest.approx(12 / 60)
    assert found.burst_messages == pytest.approx(4.0)


def test_ticks_of_which_a_sensor_was_lost_are_lost():
    ticks, lost = np.arange(100) * 10 * MS, np.arange(100) % 10 == 5
    found = message_times(signal(ticks, ticks), lost, 10**12)
    assert found.loss == pytest.approx(0.1)
    assert found.burst_messages == pytest.approx(1.0, abs=0.01)


def test_nothing_at_all_is_no_loss():
    ticks = np.arange(10)
    assert message_times(signal(np.full(10, -1), ticks), np.zeros(10, dtype=bool), 10**12).loss == 0.0
