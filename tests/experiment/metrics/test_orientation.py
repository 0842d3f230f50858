"""Orientation metrics: errors put in come out, whatever the motion."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from recording_files import CONTENTS, write
from scipy.spatial.transform import Rotation

from fesloop.errors import InputError
from fesloop.experiment.metrics import orientation as metrics
from fesloop.hand import quaternion
from fesloop.streams.files import open_recording
from fesloop.streams.recording import Reference

small = st.floats(-1.5, 1.5)


def rotations(seed, count=50):
    return Rotation.random(count, rng=np.random.default_rng(seed)).as_quat(scalar_first=True)


@given(st.integers(0, 2**32 - 1), small, st.floats(0.0, 1.5))
def test_heading_and_inclination_errors_come_out_as_put_in(seed, heading, tilt):
    true = rotations(seed)
    tilted = quaternion.from_axis_angle([1.0, 2.0, 0.0], tilt)
    wrong = quaternion.multiply(tilted, quaternion.about_z(heading))
    score = metrics.error_rmse_deg(metrics.orientation_error(quaternion.multiply(wrong, true), true))
    assert score["heading"] == pytest.approx(np.degrees(abs(heading)), abs=1e-6)
    assert score["inclination"] == pytest.approx(np.degrees(tilt), abs=1e-6)
    # cos(total / 2) = cos(heading / 2) cos(tilt / 2)
    total = 2 * np.arccos(np.cos(heading / 2) * np.cos(tilt / 2))
    assert score["total"] == pytest.approx(np.degrees(total), abs=1e-5)


@given(st.integers(0, 2**32 - 1), st.floats(-np.pi, np.pi))
def test_a_constant_heading_is_found_and_removed(seed, heading):
    true = rotations(seed)
    error = metrics.orientation_error(quaternion.multiply(quaternion.about_z(heading), true), true)
    error[::7] = np.nan
    found = metrics.constant_heading(error)
    assert np.exp(1j * found) == pytest.approx(np.exp(1j * heading), abs=1e-9)
    rest = metrics.error_rmse_deg(metrics.without_heading(error, found))
    assert rest["total"] == pytest.approx(0.0, abs=1e-6)


@given(st.integers(0, 2**32 - 1))
def test_relative_error_is_the_angle_between_both_relative_orientations(seed):
    parent, child, parent_true, child_true = (rotations(seed + i) for i in range(4))
    error = metrics.relative_orientation_error(metrics.orientation_error(parent, parent_true),
                                               metrics.orientation_error(child, child_true))
    measured, true = quaternion.relative(parent, child), quaternion.relative(parent_true, child_true)
    expected = quaternion.rotation_angle(quaternion.relative(true, measured))
    np.testing.assert_allclose(quaternion.rotation_angle(error), expected, atol=1e-9)


@given(st.integers(0, 2**32 - 1))
def test_relative_angle_does_not_depend_on_the_mounting(seed):
    relative, mounting = rotations(seed), rotations(seed + 9, 1)
    mounted = quaternion.multiply(quaternion.multiply(quaternion.conjugate(mounting), relative), mounting)
    assert metrics.relative_angle_rmse_deg(mounted, relative) == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("kind", list(CONTENTS))
def test_a_perfect_tracker_scores_zero(tmp_path, kind):
    content = CONTENTS[kind]()
    if kind == "chain5":  # so slow that its 5 s of warm-up end within the file
        content |= {"imu_rigid_hz": 5.0, "omc_hz": 3.75}
    recording = open_recording(write(tmp_path, kind, content))
    level = np.tile([1.0, 0.0, 0.0, 0.0], (recording.samples, len(recording.sensors), 1))
    scores = metrics.score_recording(recording, recording.stamps_ns, level, "absolute")
    expected = {"broad": {"orientation_rmse_deg"}, "body16": set(), "wrist": {"relative_angle_rmse_deg"},
                "chain5": {"orientation_rmse_deg", "relative_angle_rmse_deg"}}
    assert set(scores) == expected[kind]
    for values in scores.get("orientation_rmse_deg", {}).values():
        assert values == pytest.approx({"total": 0.0, "heading": 0.0, "inclination": 0.0})
    assert all(value == 0.0 for value in scores.get("relative_angle_rmse_deg", {}).values())


def test_what_has_no_scored_instant_is_left_out(tmp_path):
    recording = open_recording(write(tmp_path, "chain5"))
    level = np.tile([1.0, 0.0, 0.0, 0.0], (recording.samples, 5, 1))
    assert metrics.score_recording(recording, recording.stamps_ns, level, "relative") == {}


def test_only_marked_samples_are_scored(tmp_path):
    content = CONTENTS["broad"]()
    content["movement"][:20] = 0
    recording = open_recording(write(tmp_path, "broad", content))
    orientation = np.tile([1.0, 0.0, 0.0, 0.0], (recording.samples, 1, 1))
    orientation[:20] = [0.0, 1.0, 0.0, 0.0]
    score = metrics.score_recording(recording, recording.stamps_ns, orientation, "absolute")
    assert score["orientation_rmse_deg"]["imu"]["total"] == pytest.approx(0.0, abs=1e-9)


def test_orientations_of_other_sensors_are_refused(tmp_path):
    recording = open_recording(write(tmp_path, "wrist"))
    three = np.ones((recording.samples, 3, 4))
    with pytest.raises(InputError, match="orientation"):
        metrics.score_recording(recording, recording.stamps_ns, three, "relative")


@given(st.integers(0, 2**32 - 1), st.floats(-3.0, 3.0), st.sampled_from([0, 1, 2]))
def test_a_flexion_is_scored_as_it_is_put_out_and_a_turn_about_another_axis_shows(seed, off, axis):
    """Of sensors turned against their segments, the reference likewise, only the share about z shows it."""
    times = np.arange(0, 400) * 50_000_000
    angle = 0.8 * np.sin(1.5 * times * 1e-9)
    relative = quaternion.from_axis_angle(np.eye(3)[axis], angle)
    parent = np.repeat(rotations(seed, 1), times.size, axis=0)
    true = np.stack([parent, quaternion.multiply(parent, relative)], axis=1)
    reference = Reference(stamps_ns=times, orientation=true, scored=times >= 10**9, sensor_frames=True,
                          north=True)
    flexion = quaternion.euler_zxy(relative)[:, 0]
    found = metrics.flexion_rmse_deg(times, flexion + off, reference, (0, 1))
    assert found == pytest.approx(np.degrees(abs(off)), abs=1e-6)
    assert metrics.flexion_axis_share(times, relative) == pytest.approx(float(axis == 2), abs=1e-6)
    assert metrics.flexion_axis_share(times, np.repeat(relative[:1], times.size, axis=0)) is None


@pytest.mark.parametrize("off_deg", [-3.0, 2.0])
def test_a_flexion_across_half_a_turn_is_off_by_the_difference_alone(off_deg):
    """The reference's angle leaps from 180 to -180 deg, the tracker's goes on."""
    stamps = np.arange(21) * 10_000_000
    true = np.radians(np.linspace(170.0, 190.0, 21))
    still = np.tile([1.0, 0.0, 0.0, 0.0], (21, 1))
    reference = Reference(stamps_ns=stamps, orientation=np.stack([still, quaternion.about_z(true)], axis=1),
                          scored=np.ones(21, dtype=bool), sensor_frames=False, north=False)
    found = metrics.flexion_rmse_deg(stamps, true + np.radians(off_deg), reference, (0, 1))
    assert found == pytest.approx(abs(off_deg), abs=1e-9)
