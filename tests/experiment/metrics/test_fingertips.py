from dataclasses import dataclass

import numpy as np
import pytest

from fesloop.errors import InputErrors, RunError
from fesloop.experiment.files.parse import from_document
from fesloop.experiment.metrics.joints import coverage, fingertip_error, fingertip_rmse_mm
from fesloop.experiment.running import Experiment, run
from fesloop.experiment.score_spec import Score
from fesloop.loop.nodes import Node
from plants.moving_hand import MovingHand
from plants.moving_hand.script import Phase


def test_rmse_is_that_of_the_distance_and_late_estimates_are_judged_at_their_capture():
    times = np.arange(0, 1000, 10)
    truth = np.zeros((100, 2, 3))
    truth[:, 1, 0] = 1e-3 * np.arange(100)
    seen = truth[5:50].copy()
    seen[:, 0] += [3e-3, 4e-3, 0.0]
    error = fingertip_error((times[5:50], seen), (times, truth))
    assert np.allclose(fingertip_rmse_mm(error), [5.0, 0.0])


def test_estimates_before_the_truth_begins_are_left_out():
    estimate = np.array([0, 50, 100]), np.ones((3, 1, 3))
    error = fingertip_error(estimate, (np.array([50]), np.zeros((1, 1, 3))))
    assert error.shape == (2, 1, 3)


def test_intervals_of_gaussian_errors_cover_95_percent():
    rng = np.random.default_rng(0)
    sd = rng.uniform(1e-3, 1e-2, (20000, 2, 3))
    error = sd * rng.standard_normal(sd.shape)
    assert np.allclose(coverage(error, sd), 0.95, atol=0.005)
    assert (coverage(2.0 * error, sd) < 0.72).all()


def test_trackers_and_truth_are_asked_for_together():
    document = {
        "experiment": {"name": "tips", "duration_s": 0.1},
        "blocks": {"hand": {"kind": "moving_hand", "phases": [{"duration_s": 0.1}]}},
        "score": {"fingertips": "hand.fingertips", "tips": ["F1"]}}
    with pytest.raises(InputErrors) as fault:
        from_document(document)
    assert "score.trackers" in str(fault.value)
    assert "score.tips" in str(fault.value)
    document["score"] = {"fingertips": "hand.fingertips", "trackers": ["hand", "imus"]}
    with pytest.raises(InputErrors, match=r"imus\.fingertips"):
        from_document(document)
    document["score"]["trackers"] = ["hand"]
    assert from_document(document).score.trackers == ("hand",)


def test_a_run_is_scored_by_tracker_and_fingertip(tmp_path):
    document = {
        "experiment": {"name": "tips", "duration_s": 0.5},
        "record": {"plant_rate": "100"},
        "blocks": {"hand": {"kind": "moving_hand", "phases": [
            {"duration_s": 0.5, "posture_deg": {"F2_pip_flexion": 60.0}}]}},
        "score": {"fingertips": "hand.fingertips", "trackers": ["hand"]}}
    metrics = from_document(document).run(tmp_path).metrics
    assert metrics["fingertip_rmse_mm"]["hand"] == {f"F{i}": [0.0] for i in range(1, 6)}


@dataclass(frozen=True, slots=True, kw_only=True)
class Broken:
    inputs = ()
    outputs = ()

    def init(self, context):
        return None

    def step(self, state, inputs, tick):
        raise RunError("no answer")


def test_a_run_that_fails_at_its_first_tick_tells_why(tmp_path):
    """Nothing has been recorded then, and nothing is scored."""
    nodes = Node("hand", MovingHand(phases=(Phase(duration_s=0.5),))), Node("broken", Broken(), "100")
    experiment = Experiment(name="tips", nodes=nodes, duration_s=0.5,
                            score=Score(fingertips="hand.fingertips", trackers=("hand",)))
    result = run(experiment, tmp_path)
    assert (result.status, result.cause) == ("failed", "no answer")
    assert result.metrics == {"fingertip_rmse_mm": {"hand": {}}}
