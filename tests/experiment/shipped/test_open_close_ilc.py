"""The shipped experiment of free opening and closing, cut short: learnt through the tracker. About 30 s."""

import pytest

import fesloop


@pytest.mark.slow
def test_a_hand_learns_to_open_and_close_from_trial_to_trial(tmp_path):
    # Muscles that are equally strong in all trials: variation bounds what learning reaches.
    same = fesloop.load("open_close_ilc", ["trials=3", "blocks.muscles.variation.scale=0"])
    metrics = same.run(tmp_path).metrics
    errors = metrics["joint_rmse_deg"]
    assert errors[0] > 6.0
    assert errors[2] < 2.5
    assert errors[2] < 0.35 * errors[0]
    assert max(metrics["tracker_rmse_deg"]) < 1.5
    assert list(metrics["joints"]) == ["wrist_extension", "finger_flexion", "thumb_flexion"]
    assert "held" not in metrics
