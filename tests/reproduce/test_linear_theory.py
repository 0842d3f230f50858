import numpy as np
import pytest

from fesloop.analysis.theory import linear_loop, stationary_cost
from fesloop.apps.reproduce import linear_theory
from fesloop.apps.reproduce.figures import beside_theory, draw
from fesloop.apps.reproduce.linear_theory import (
    EXPERIMENT,
    GAINS,
    POINTS,
    Cost,
    Crossing,
    interval,
    mean_square,
)
from fesloop.errors import InputError, RunError
from fesloop.experiment.files.parse import load


def found(monkeypatch, square=lambda exact: exact, crossing=50.0, spread=0.01, subjects=6):
    """What is found where runs come to `square` of the exact cost, and the loop is critical at `crossing`."""
    exact = {number: np.radians(stationary_cost(load(EXPERIMENT, point.settings)).joint_rms_deg) ** 2
             for number, point in enumerate(POINTS[:1])}
    monkeypatch.setattr(linear_theory, "POINTS", POINTS[:1])
    monkeypatch.setattr(linear_theory, "GAINS", GAINS[:1])

    def kept(task):
        if isinstance(task, Crossing):
            return {"theory": 50.0, "simulated": crossing}
        to_both_sides = np.array([(-1.0) ** seed for seed in task.seeds])
        return {"squares": square(exact[task.point]) * (1.0 + spread * to_both_sides)}

    monkeypatch.setattr(linear_theory, "run_jobs", lambda tasks, *_: {task.key: kept(task) for task in tasks})
    return linear_theory.run(subjects, 1)


def test_there_are_twenty_different_points_and_gains_that_can_be_loaded():
    assert len(POINTS) == len({point.name for point in POINTS}) == len(set(GAINS)) == 20
    assert len({Cost(number, (1,)).key for number in range(20)}) == 20
    loops = [linear_loop(load(EXPERIMENT, point.settings)) for point in POINTS]
    assert sum(loop.random for loop in loops) >= 15


def test_rows_hold_where_runs_agree_with_theory(monkeypatch):
    assert [row.holds for row in found(monkeypatch).rows] == [True, True]


@pytest.mark.parametrize("change", [
    {"square": lambda exact: 1.03 * exact}, {"square": lambda exact: 0.97 * exact}, {"spread": 0.05}])
def test_a_cost_that_is_off_or_too_uncertain_does_not_hold(change, monkeypatch):
    assert [row.holds for row in found(monkeypatch, **change).rows] == [False, True]


@pytest.mark.parametrize("crossing", [49.85, 50.15, np.nan])
def test_a_crossing_that_is_off_does_not_hold(crossing, monkeypatch):
    assert [row.holds for row in found(monkeypatch, crossing=crossing).rows] == [True, False]


def test_the_figure_shows_each_point_and_each_gain(monkeypatch, tmp_path):
    (file,) = draw(found(monkeypatch), tmp_path)
    assert file.name == "beside_theory.png"
    figure = beside_theory(found(monkeypatch, square=lambda exact: 1.5 * exact, crossing=50.04))
    left, right = figure.axes
    assert left.containers[0].lines[0].get_xdata() == pytest.approx([150.0])
    assert right.lines[0].get_ydata() == pytest.approx([0.04])


def test_intervals_hold_the_truth_as_often_as_they_say():
    rng = np.random.default_rng(1)
    found = [interval(rng.normal(5.0, 1.0, 8), 2) for _ in range(4000)]
    held = [abs(mean - 5.0) <= half for mean, half in found]
    assert 1.0 - np.mean(held) == pytest.approx(0.005, abs=4.0 * np.sqrt(0.005 / 4000))
    with pytest.raises(RunError, match="interval"):
        interval(np.ones(1), 20)


def test_the_mean_square_is_that_of_the_metric_of_a_run(tmp_path):
    experiment = load(EXPERIMENT, ("experiment.duration_s=25",), 3)
    metric = experiment.run(tmp_path).metrics["joint_rmse_deg"][0]
    assert np.degrees(np.sqrt(mean_square(experiment, 20))) == pytest.approx(metric, rel=1e-9)


def test_one_run_of_each_point_is_refused_before_the_work_and_not_after_it(monkeypatch):
    monkeypatch.setattr(linear_theory, "run_jobs", lambda *_: pytest.fail("it was begun"))
    with pytest.raises(InputError, match="--subjects: 1; allowed: 2 or more"):
        linear_theory.run(1)
