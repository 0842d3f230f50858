"""The shipped grasps by predictive control: IMUs and a tracker in the loop, a late one too. About 30 s."""

import pytest

import fesloop
from fesloop import Recording


@pytest.mark.parametrize("latency_ms", [10, 100])
def test_a_hand_grasps_at_once_and_late_samples_cost_little(latency_ms, tmp_path):
    result = fesloop.load("grasp_mpc", [f"tracker_latency_ms={latency_ms}"]).run(tmp_path)
    metrics = result.metrics
    assert metrics["held"] == [True]
    assert metrics["grip_margin"][0] > 1.0
    for row in ("wrist_extension", "finger_flexion"):
        assert metrics["joints"][row]["joint_rmse_deg"][0] < 2.5
    assert metrics["wrist_extension_deg"][0] == pytest.approx(25.0, abs=6.0)
    with Recording(result.recording) as recording:
        told = {event.status for event in recording.events if event.where == "controller"}
    assert "touching" in told
    assert told <= {"no_input", "saturated", "touching"}


def test_age_that_is_not_compensated_costs_more(tmp_path):
    errors = [fesloop.load("grasp_mpc", ["tracker_latency_ms=150", "scene=free", f"compensate_age={known}"])
              .run(tmp_path).metrics["joint_rmse_deg"][0] for known in ("true", "false")]
    assert errors[1] > 1.5 * errors[0]


def test_two_fingers_pinch_a_tube_and_the_others_do_not_touch_it(tmp_path):
    metrics = fesloop.load("pinch_mpc").run(tmp_path).metrics
    assert metrics["held"] == [True]
    force = metrics["grip_force_n"]
    assert force["F2"][0] + force["F3"][0] > 0.5
    assert max(force["F4"][0], force["F5"][0]) < 0.1
