"""What the shipped experiments are to show."""

import numpy as np
import pytest
from recording_files import write
from vqf import VQF

import fesloop
from fesloop import Recording
from fesloop.errors import InputError
from fesloop.experiment.metrics.orientation import score_recording
from fesloop.streams.files import open_recording


@pytest.mark.slow
def test_finger_ilc_learns_within_five_trials_with_tracker_and_mismatch(tmp_path):
    experiment = fesloop.load("finger_ilc")
    patient = next(node.part for node in experiment.nodes if node.name == "patient")
    assert (patient.strength, patient.speed) == (1.2, 0.85)
    result = experiment.run(tmp_path)
    errors = result.metrics["joint_rmse_deg"]
    assert errors[0] > 5.0
    assert errors[5] < 2.0
    assert max(result.metrics["tracker_rmse_deg"]) < 2.0


def test_finger_mpc_holds_at_20_ms(tmp_path):
    result = fesloop.load("finger_mpc", ["latency_ms=20"]).run(tmp_path)
    assert result.metrics["joint_rmse_deg"][0] < 3.0


@pytest.mark.slow
def test_100_ms_of_latency_cost_finger_mpc_less_than_a_third_of_its_error(tmp_path):
    prompt, late = (fesloop.load("finger_mpc", [f"latency_ms={latency}"]).run(tmp_path)
                    .metrics["joint_rmse_deg"][0] for latency in (0, 100))
    assert late <= 1.3 * prompt


def test_latency_costs_a_pid_its_stability(tmp_path):
    errors = [fesloop.load("finger_pid_latency", [f"latency_ms={latency}"]).run(tmp_path)
              .metrics["joint_rmse_deg"][0] for latency in (30, 200)]
    assert errors[0] < 1.5
    assert errors[1] > 5.0


@pytest.mark.slow
def test_finger_fmu_moves_as_the_finger_does(tmp_path):
    """The FMU steps on a 1 kHz grid that every instant of this wiring lies on."""
    as_fmu = fesloop.load("finger_fmu").run(tmp_path)
    native = fesloop.load("finger_fmu").document()
    native["blocks"]["finger"] = {"kind": "finger"}
    from fesloop.experiment.files.parse import from_document

    as_finger = from_document(native).run(tmp_path)
    with Recording(as_fmu.recording) as one, Recording(as_finger.recording) as other:
        np.testing.assert_allclose(one.signal("finger.angles").values, other.signal("finger.angles").values,
                                   atol=1e-9)


@pytest.mark.parametrize("name", [
    "02_undisturbed_slow_rotation_B", *(pytest.param(name, marks=pytest.mark.slow) for name in (
        "21_undisturbed_fast_combined", "24_disturbed_tapping_A", "30_disturbed_stationary_magnet_C"))])
def test_replay_of_broad_is_as_good_as_bare_vqf(recordings, tmp_path, name):
    path = recordings / "broad" / f"{name}.mat"
    result = fesloop.load("replay", [f"recording={path}"]).run(tmp_path)
    recording = open_recording(path)
    bare = VQF(float(1 / recording.rate)).updateBatch(
        np.ascontiguousarray(recording.gyr[:, 0]), np.ascontiguousarray(recording.acc[:, 0]))["quat6D"]
    wanted = score_recording(recording, recording.stamps_ns, bare[:, None], "relative")
    ours = result.metrics["orientation_rmse_deg"]["imu"]["total"]
    assert ours == pytest.approx(wanted["orientation_rmse_deg"]["imu"]["total"], rel=0.1)


def test_replay_of_wrist_keeps_the_angle_between_the_segments(recordings, tmp_path):
    result = fesloop.load("replay", [f"recording={recordings / 'wrist' / 'circle-250.npz'}"]).run(tmp_path)
    assert result.metrics["relative_angle_rmse_deg"]["radius-carpus"] <= 1.7


@pytest.mark.slow
def test_replay_of_body16_carries_16_streams_and_times_the_tracker(recordings, tmp_path):
    path = recordings / "body16" / "qmt_full_body_example_data.mat"
    result = fesloop.load("replay", [f"recording={path}"]).run(tmp_path)
    times = result.metrics["step_us"]["tracker"]
    assert 0.0 < times["median"] <= times["p99"]
    with Recording(result.recording) as recording:
        assert recording.signal("tracker.orientation").values.shape[1:] == (16, 4)
        assert recording.step_times_ns["tracker"].size == recording.signal("tracker.angles").times_ns.size
        assert recording.signal("safety.stimulation").values.max() > 0.0


def test_the_tracker_of_a_replay_can_be_chosen_and_takes_the_magnetometer_where_there_is_one(
        recordings, tmp_path):
    broad = recordings / "broad" / "02_undisturbed_slow_rotation_B.mat"
    settings = ["tracker=vqf9", f"recording={broad}", "blocks.recording.duration_s=60"]
    experiment = fesloop.load("replay", settings)
    assert "recording.mag->tracker.mag" in [wire.name for wire in experiment.wires]
    assert experiment.run(tmp_path).metrics["orientation_rmse_deg"]["imu"]["total"] < 10.0
    wires = fesloop.load("replay", [f"recording={broad}"]).wires
    assert "recording.mag->tracker.mag" not in [wire.name for wire in wires]


def test_a_tracker_that_needs_a_magnetometer_is_told_that_the_recording_has_none(tmp_path):
    path = write(tmp_path, "wrist")
    with pytest.raises(InputError, match=r"recording\.mag.*has no output port .mag.; allowed: gyr, acc"):
        fesloop.load("replay", ["tracker=vqf9", f"recording={path}"])
