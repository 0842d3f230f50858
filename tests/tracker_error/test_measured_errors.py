"""Errors as they are read from runs: against a made-up reference, and against a plant's truth."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from recording_files import write
from scipy.spatial.transform import Rotation

import fesloop
from fesloop.analysis.tracker_error.fitting import fit_error
from fesloop.analysis.tracker_error.measured_errors import (
    _orientation_errors,
    filled,
    mean_orientation,
    measured_errors,
    rotation_vector,
)
from fesloop.analysis.tracker_error.series_fit import MotionColumns
from fesloop.errors import InputError
from fesloop.experiment.recording.reading import Recording
from fesloop.hand import quaternion


def test_rotation_vectors_are_scipys():
    rotations = Rotation.random(50, random_state=0)
    q = rotations.as_quat(scalar_first=True)
    np.testing.assert_allclose(rotation_vector(q), rotations.as_rotvec(), atol=1e-12)
    np.testing.assert_allclose(rotation_vector(-q), rotations.as_rotvec(), atol=1e-12)
    np.testing.assert_allclose(rotation_vector(np.array([1.0, 1e-14, 0.0, 0.0])), [2e-14, 0.0, 0.0])


def test_the_mean_orientation_errors_is_scipys_whatever_their_signs():
    rotations = Rotation.from_rotvec(np.random.default_rng(1).normal(0.0, 0.4, (40, 3)))
    q = rotations.as_quat(scalar_first=True) * np.random.default_rng(2).choice([-1.0, 1.0], (40, 1))
    found = mean_orientation(q)
    wanted = rotations.mean().as_quat(scalar_first=True)
    assert abs(found @ wanted) == pytest.approx(1.0)


def test_the_error_about_a_hinges_axis_is_that_of_its_angle():
    times = np.arange(400) / 40.0
    angle = 0.8 * np.sin(times)
    axis = np.array([0.0, 1.0, 0.0])
    true = quaternion.from_axis_angle(axis, angle)
    off = 0.05 * np.cos(3.0 * times)
    estimate = quaternion.from_axis_angle(axis, angle + off)
    true[50:60] = np.nan
    scored = times > 1.0
    records = _orientation_errors("a-b", times, estimate, true, scored, 5.0)
    assert [(record.name, record.moved) for record in records] == [("a-b.x", False), ("a-b.y", True),
                                                                   ("a-b.z", False)]
    about = records[1]
    np.testing.assert_allclose(about.error[about.known], off[about.known], atol=1e-12)
    assert not about.known[:41].any()
    assert not about.known[50:60].any()
    early = (times < 5.0) & scored & about.known
    np.testing.assert_allclose(np.ptp(about.angle - angle), 0.0, atol=0.02)
    assert abs(np.mean(about.angle[early])) < 0.1
    np.testing.assert_allclose(records[0].angle, about.angle)


@given(seed=st.integers(0, 1000), hz=st.sampled_from([30.0, 60.0, 100.0, 200.0]),
       delay_ms=st.floats(0.0, 60.0), noise_deg=st.floats(0.0, 1.0))
@settings(max_examples=25, deadline=None)
def test_a_delay_is_told_whole_whatever_the_noise_of_the_reference(seed, hz, delay_ms, noise_deg):
    """Noise in a rate makes a regression's weight too small (errors in variables)."""
    rng, times = np.random.default_rng(seed), np.arange(round(20.0 * hz)) / hz
    fastest, phase = rng.uniform(0.1, 1.0, (6, 1)), rng.uniform(0.0, 2.0 * np.pi, (6, 1))

    def at(late_s):
        angle = 0.25 * np.sin(2.0 * np.pi * fastest * (times - late_s) + phase).sum(axis=0)
        return Rotation.from_rotvec(angle[:, np.newaxis] * [0.0, 0.0, 1.0])

    noise = Rotation.from_rotvec(np.radians(noise_deg) * rng.standard_normal((times.size, 3)))
    ends = ((at(1e-3 * delay_ms)).as_quat(scalar_first=True), (at(0.0) * noise).as_quat(scalar_first=True))
    record = _orientation_errors("a-b", times, *ends, np.ones(times.size, dtype=bool), times[-1])[2]
    assert record.moved
    motion = MotionColumns(record)
    weights, _ = motion.least_squares(motion.best(), np.arange(times.size))
    assert -1e3 * weights[3] == pytest.approx(delay_ms, abs=1.0 + 0.04 * delay_ms)


def test_gaps_of_the_motion_are_bridged():
    gaps = np.array([0.0, np.nan, 2.0, np.nan, 4.0])
    np.testing.assert_allclose(filled(np.arange(5.0), gaps), np.arange(5.0))


@pytest.mark.slow
def test_the_errors_of_a_simulated_tracker_are_those_it_was_given(tmp_path):
    settings = ["noise_deg=0.4", "bias_deg=2.0", "experiment.duration_s=12"]
    run = fesloop.load("finger_control", settings).run(tmp_path)
    with Recording(run.recording) as recording:
        found = measured_errors(recording)
    assert [record.name for record in found.records] == ["MCP", "PIP", "DIP"]
    for record in found.records:
        assert np.degrees(record.error.mean()) == pytest.approx(2.0, abs=0.05)
        assert np.degrees(record.error.std()) == pytest.approx(0.4, rel=0.1)
    fitted = fit_error(str(run.recording))
    assert all(judged.rmse_holds for judged in fitted.judgements)
    assert sum(judged.autocorrelation_holds for judged in fitted.judgements) >= 2
    series = fitted.process.series[0]
    assert series.bias_deg == pytest.approx(2.0, abs=0.05)
    assert np.hypot(series.fast_deg, series.quick_deg) == pytest.approx(0.4, rel=0.15)
    assert fitted.process.age_ms == 0.0
    assert fitted.process.loss == 0.0


def test_a_run_that_compares_nothing_is_refused(tmp_path):
    run = fesloop.load("recruitment_sweep", ["experiment.duration_s=1"]).run(tmp_path)
    with pytest.raises(InputError, match="compares no tracker"):
        fit_error(str(run.recording))


def test_settings_are_for_what_is_yet_to_be_played(tmp_path):
    run = fesloop.load("recruitment_sweep", ["experiment.duration_s=1"]).run(tmp_path)
    with pytest.raises(InputError, match=r"--set .*: is given for .*, which is a finished run"):
        fit_error(str(run.recording), settings=("tracker=vqf",))
    with pytest.raises(InputError, match="reference-late"):
        fit_error("a.npz", reference_late_ms=float("nan"))


@pytest.mark.parametrize("align_s", [0.0, 0.5, 1.5])
def test_errors_are_those_of_a_tracker_that_has_aligned(align_s, tmp_path):
    settings = ["experiment.duration_s=3", "score.after_s=0.2", f"blocks.tracker.align_s={align_s}"]
    done = fesloop.load("finger_mpc", settings).run(tmp_path)
    with Recording(done.recording) as recording:
        errors = measured_errors(recording)
    begins_s = max(align_s, 0.2)
    for record in errors.records:
        assert begins_s - 0.02 <= record.times_s[0] <= begins_s + 0.02
    rms = np.sqrt(np.mean([record.rms_deg**2 for record in errors.records]))
    assert rms == pytest.approx(done.metrics["tracker_rmse_deg"][0])


def test_a_tracker_that_never_aligned_is_named(tmp_path):
    """By either way to score it: against a truth here, against a recording's reference below."""
    done = fesloop.load("finger_mpc", ["experiment.duration_s=1", "blocks.tracker.align_s=5"]).run(tmp_path)
    with pytest.raises(InputError, match="tracker never took its initial pose"):
        fit_error(str(done.recording))


def test_a_tracker_that_never_aligned_in_a_replay_is_named(tmp_path):
    settings = [f"recording={write(tmp_path, 'chain5')}", "tracker=vqf", "blocks.tracker.align_s=5",
                "blocks.tracker.initial_angles_deg=[0, 0, 0, 0, 0, 0]"]
    done = fesloop.load("hil_replay", settings).run(tmp_path)
    with pytest.raises(InputError, match="tracker never took its initial pose"):
        fit_error(str(done.recording))
