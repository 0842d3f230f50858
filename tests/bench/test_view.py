"""The bench of a watched loop: its arithmetic on made-up stamps, and a few seconds of it; about 20 s."""

import numpy as np
import pytest

from fesloop.apps.bench import view
from fesloop.apps.bench.view import _late, _result, _Turn
from fesloop.errors import RunError

pytestmark = pytest.mark.realtime

US, S = 1000, 10**9


def turns():
    """Ten seconds each: not watched, watched, not watched, watched."""
    return [_Turn(bool(i % 2), 10 * i * S, 10 * (i + 1) * S, frames=250 * (i % 2), seconds=9.0 * (i % 2))
            for i in range(4)]


def test_instants_belong_to_the_turn_in_which_they_were():
    instants = np.arange(0, 40 * S, S)
    late = np.arange(40)
    assert [_late(late, instants, turn).tolist() for turn in turns()] == [
        list(range(first, first + 10)) for first in (0, 10, 20, 30)]


def test_watched_turns_are_compared_with_the_others():
    late = [np.full(1000, each * US) for each in (100, 110, 100, 130)]
    found = _result(turns(), late)
    watched, alone = found["rows"]
    assert (watched["us_median"], watched["us_p99"], watched["us_worst"]) == (120.0, 130.0, 130.0)
    assert (watched["reference_us_median"], watched["reference_us_p99"]) == (100.0, 100.0)
    assert (alone["us_median"], alone["reference"], alone["ratio"]) == (100.0, None, None)
    ratio = found["p99_ratio"]
    assert ratio["ratio"] == pytest.approx(1.3)
    assert (ratio["low"], ratio["high"]) == (pytest.approx(1.1), pytest.approx(1.3))
    assert found["turns"] == {"watched": 2, "not watched": 2}
    assert found["frames_per_s"] == pytest.approx(250 / 9)


def test_a_stall_in_one_turn_does_not_decide_the_ratio_of_turns():
    late = [np.full(1000, each * US) for each in (100, 110, 100, 110, 100, 110)]
    late[2][:] = 10**6 * US
    six = [_Turn(bool(i % 2), 10 * i * S, 10 * (i + 1) * S) for i in range(6)]
    found = _result(six, late)
    assert found["p99_ratio"]["ratio"] < 0.01
    assert found["turn_p99_ratio"]["ratio"] == pytest.approx(1.1)
    assert found["us_p99_of_turns"] == {"watched": [110.0] * 3, "not watched": [100.0, 10**6, 100.0]}


def test_a_run_that_nobody_watched_says_nothing():
    with pytest.raises(RunError, match="no instant"):
        _result(turns()[:1], [np.ones(5)])


@pytest.mark.slow
def test_a_watched_run_of_some_seconds():
    found = view.run(count=2, turn_s=2.0, experiment="finger_control")
    assert [row["us_median"] > 0.0 for row in found["rows"]] == [True, True]
    assert found["turns"] == {"watched": 1, "not watched": 1}
    assert found["frames_per_s"] > 0.0
    assert found["p99_ratio"]["low"] <= found["p99_ratio"]["high"]
