"""The trial and the instant with which pictures, films, views and reports begin."""

from types import SimpleNamespace

import numpy as np
import pytest

from fesloop.show.best_trial import best_trial, telling_s

NAN = float("nan")


@pytest.mark.parametrize(("trials", "status", "metrics", "best"), [
    (4, "done", {"joint_rmse_deg": [9.0, 4.0, 3.0, 5.0]}, 2),
    (4, "done", {"joint_rmse_deg": [1.0, 4.0, 3.0, 5.0], "held": [False, True, True, True]}, 2),
    (4, "done", {"joint_rmse_deg": [9.0, 4.0, 3.0, 5.0], "held": [False, None, False, False]}, 2),
    (3, "done", {"joint_rmse_deg": [1.0, 4.0, 3.0]}, 2),
    (3, "done", {"joint_rmse_deg": [1.0, 4.0, 3.0], "held": [True, False, True]}, 0),
    (3, "done", {"joint_rmse_deg": [NAN, NAN, NAN]}, 2),
    (3, "done", {"joint_rmse_deg": [NAN, NAN, NAN], "held": [True, True, False]}, 1),
    (3, "done", {}, 2),
    (3, "done", {"joint_rmse_deg": {"a": 1.0}, "held": [True]}, 2),
    (3, "running", {"joint_rmse_deg": [3.0, 2.0, 0.5]}, 1),
    (2, "failed", {"joint_rmse_deg": [3.0, 2.0]}, 0),
    (1, "done", {"joint_rmse_deg": [3.0]}, 0),
    (1, "running", {}, 0),
    (0, "failed", {}, 0),
])
def test_the_best_trial_held_its_object_or_has_the_least_error_and_is_complete(trials, status, metrics, best):
    assert best_trial(SimpleNamespace(trials=trials, status=status), metrics) == best


TIMES = np.arange(5.0)


def moved(*at):
    """Positions of two segments, the second so far from the first, m."""
    found = np.zeros((len(at), 2, 3))
    found[:, 1, 0] = at
    return found


def test_the_telling_instant_is_in_the_middle_of_the_hold_or_farthest_from_the_start():
    grasp = {"grasp": {"from_s": 1.0, "until_s": 4.0}}
    assert telling_s(grasp, TIMES, moved(0, 9, 1, 1, 1)) == 2.5
    assert telling_s({}, TIMES, moved(0, 1, 9, 1, 1)) == 2.0
    assert telling_s({}, TIMES, moved(NAN, 5, 5, 1, 6)) == 3.0
    assert telling_s({"grasp": {"from_s": 1.0, "until_s": 40.0}}, TIMES, moved(0, 1, 2, 3, 9)) == 4.0
    assert telling_s({"grasp": "odd"}, TIMES, moved(0, 1, 2, 3, 9)) == 4.0
    assert telling_s({}, TIMES, moved(*[NAN] * 5)) is None
