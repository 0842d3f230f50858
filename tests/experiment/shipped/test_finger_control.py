"""`finger_control`: each option and each short name does what it says. About 15 s."""

import math

import pytest

import fesloop
from fesloop import Recording
from fesloop.loop.run import Loop

CONTROLLERS = [["control=pid"], ["control=tuned_pid"], ["control=mpc"], ["control=mpc_no_compensation"],
               ["control=ilc", "trials=4"]]
QUICK = ["control=pid", "noise_deg=0"]


def run(tmp_path, *settings):
    return fesloop.load("finger_control", settings).run(tmp_path)


@pytest.mark.parametrize("controller", CONTROLLERS)
def test_without_anything_wrong_every_controller_follows(controller, tmp_path):
    assert run(tmp_path, *controller).metrics["joint_rmse_deg"][-1] < 1.0


@pytest.mark.slow
@pytest.mark.parametrize("controller", CONTROLLERS)
def test_a_bias_costs_what_it_is(controller, tmp_path):
    """Whatever brings the measured error to nothing leaves the finger off by the bias."""
    metrics = run(tmp_path, *controller, "noise_deg=0", "bias_deg=6.0").metrics
    assert metrics["tracker_rmse_deg"][-1] == pytest.approx(6.0, rel=1e-6)
    assert metrics["joint_rmse_deg"][-1] == pytest.approx(6.0, rel=0.12)


def test_drift_and_noise_are_errors_of_their_size(tmp_path):
    """From 0.5 s to 6 s the mean square of d t is d^2 (6^3 - 0.5^3) / (3 x 5.5)."""
    drift = run(tmp_path, *QUICK, "drift_deg_s=2.0").metrics["tracker_rmse_deg"][0]
    assert drift == pytest.approx(2.0 * math.sqrt((6.0**3 - 0.5**3) / (3.0 * 5.5)), rel=0.01)
    noise = run(tmp_path, "control=pid", "noise_deg=3.0").metrics["tracker_rmse_deg"][0]
    # Some 550 ticks of three joints.
    assert noise == pytest.approx(3.0, rel=4.0 / math.sqrt(2.0 * 1650))
    walk = run(tmp_path, *QUICK, "walk_deg=1.0").metrics["tracker_rmse_deg"][0]
    assert 0.5 < walk < 6.0


def test_a_lag_that_stamps_do_not_show_is_the_trackers_error_and_a_latency_is_not(tmp_path):
    assert run(tmp_path, *QUICK, "delay_ms=50").metrics["tracker_rmse_deg"][0] > 0.3
    assert run(tmp_path, *QUICK, "latency_ms=70").metrics["tracker_rmse_deg"][0] < 1e-9


def test_prediction_across_the_age_of_a_sample_is_what_bears_latency(tmp_path):
    def error(control):
        return run(tmp_path, f"control={control}", "latency_ms=150").metrics["joint_rmse_deg"][0]

    assert error("mpc_adaptive") < 0.3
    assert error("mpc") < 1.0
    assert min(error("pid"), error("mpc_no_compensation")) > 5.0


def test_a_finger_much_stronger_and_quicker_than_told_does_not_swing(tmp_path):
    for control, most_deg in (("mpc", 1.0), ("mpc_adaptive", 0.3)):
        settings = (f"control={control}", "strength=1.5", "speed=1.3", "latency_ms=0")
        assert run(tmp_path, *settings).metrics["joint_rmse_deg"][0] < most_deg


def test_jitter_moves_arrivals_between_none_and_the_most_that_is_asked_for():
    """The least and the most of all ways from the finger back to it, without running anything."""
    def stage(setting):
        paths = Loop(fesloop.load("finger_control", [setting]).wiring).latency_report().paths
        path = next(path for path in paths if "controller" in path.name)
        return next(stage for stage in path.summary() if "controller.measured" in stage.name)

    steady, uneven = stage("jitter_ms=0"), stage("jitter_ms=40")
    assert steady.least_ns == steady.most_ns == 20_000_000
    assert 20_000_000 <= uneven.least_ns < 30_000_000
    assert uneven.most_ns <= 60_000_000


def test_loss_is_that_of_both_radios_and_a_silent_tracker_ends_stimulation(tmp_path):
    settings = ["control=pid", "loss=0.4", "burst_messages=12"]
    result = run(tmp_path, *settings)
    with Recording(result.recording) as recording:
        lost = [recording.messages[0][f"tracker.angles->{end}"]["lost"]
                for end in ("controller.measured", "safety.posture")]
        told = {event.status for event in recording.events if event.where == "safety"}
    assert all(100 < each < 380 for each in lost)
    assert lost[0] != lost[1]
    assert "posture_silent" in told
    with Recording(run(tmp_path, *settings, "silence_ms=2000").recording) as recording:
        assert "posture_silent" not in {event.status for event in recording.events}


def test_sensors_and_a_tracker_can_take_the_exact_ones_place(tmp_path):
    metrics = run(tmp_path, "tracker=vqf", "control=pid").metrics
    assert 0.0 < metrics["tracker_rmse_deg"][0] < 2.0
    assert metrics["joint_rmse_deg"][0] < 2.0
