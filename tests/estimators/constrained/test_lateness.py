"""Clock offsets of sensors: found from shared accelerations, made good, and not seen where there are none."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tracker_parts import run_tracker

from estimators.body.joint_constraints import Joint
from estimators.constrained import ConstrainedTracker
from estimators.constrained.filter import LOST, SOUND
from estimators.constrained.lateness import LOW, WHOLE, Lateness, advanced, ahead, correlate, differences
from fesloop.experiment.files.parse import load
from fesloop.experiment.metrics.orientation import score_recording
from fesloop.experiment.recording.reading import Recording
from fesloop.experiment.running import run
from fesloop.hand import quaternion
from fesloop.loop.signals import Sample
from fesloop.streams.files import open_recording

PERIOD = 0.01
ENDS = np.array([[0, 1], [1, 2]])


def put(lateness, gyr, acc, ticks=1):
    """Rates and accelerations that the tracker is given for these samples."""
    samples = lateness.align([Sample(gyr, 0, 0, 0), Sample(acc, 0, 0, 0)], ticks)
    return samples[0].value, samples[1].value


@given(st.lists(st.floats(0.0, 0.09), min_size=3, max_size=3), st.integers(0, 2**32 - 1))
@settings(deadline=None, max_examples=50)
def test_all_samples_are_of_one_instant_and_turns_lead_from_it_to_now(late_s, seed):
    """Rates grow linearly in time, which interpolation and trapezoids keep."""
    rng = np.random.default_rng(seed)
    slope, start = rng.normal(size=(2, 3, 3))
    lateness = Lateness.unknown(3, 2, PERIOD)
    lateness.late_s[:] = np.array(late_s) - min(late_s)
    lateness.known = bool(lateness.late_s.any())
    lateness.watched = True
    for k in range(40):
        sampled_s = k * PERIOD - lateness.late_s[:, np.newaxis]
        gyr, acc = put(lateness, start + slope * sampled_s, slope * sampled_s)
    if not lateness.known:
        return
    instant_s = 39 * PERIOD - lateness.late_s.max()
    np.testing.assert_allclose(gyr, start + slope * instant_s, atol=1e-9)
    np.testing.assert_allclose(acc, slope * instant_s, atol=1e-9)
    newest_s, late = sampled_s, lateness.late_s[:, np.newaxis]
    wait = lateness.late_s.max() - late
    turned = wait * (start + slope * (newest_s - 0.5 * wait)) + late * (start + slope * newest_s)
    np.testing.assert_allclose(lateness.turns(), turned, atol=1e-9)


def test_ticks_that_were_skipped_leave_a_gap():
    lateness = Lateness.unknown(2, 1, PERIOD)
    lateness.late_s[:], lateness.known, lateness.watched = (0.0, 0.03), True, True
    for _ in range(10):
        put(lateness, np.ones((2, 3)), np.ones((2, 3)))
    for ticks, lost in ((3, False), (1, True), (1, True), (1, False)):
        gyr, _ = put(lateness, np.ones((2, 3)), np.ones((2, 3)), ticks)
        assert np.isnan(gyr[0]).all() == lost
        assert (gyr[1] == 1.0).all()


def test_relative_orientations_follow_both_sensors():
    rng = np.random.default_rng(5)
    whole, turns = quaternion.normalized(rng.normal(size=(3, 4))), rng.normal(size=(3, 3))
    q = quaternion.multiply(quaternion.conjugate(whole[:2]), whole[1:])
    later = advanced(whole, turns)
    expected = quaternion.multiply(quaternion.conjugate(later[:2]), later[1:])
    np.testing.assert_allclose(np.abs(np.sum(ahead(q, ENDS, turns) * expected, axis=1)), 1.0, atol=1e-12)


@pytest.mark.parametrize("seed", range(5))
def test_noise_of_a_hand_at_rest_is_never_late(seed):
    rng = np.random.default_rng(seed)
    gyr = 1e-3 * rng.normal(size=(3000, 3, 3))
    acc = np.array([0.0, 0.0, 9.81]) + 0.05 * rng.normal(size=(3000, 3, 3))
    joints = (Joint(parent=0, child=1, kind="ball"), Joint(parent=1, child=2, kind="ball"))
    reports = run_tracker(ConstrainedTracker(sensors=3, joints=joints), gyr, acc, rate=100)[1]
    assert not [each for each in reports if each[0] == "late_sensor"]


def later_by(recording, delay_s, sensors):
    """Samples of the recording with those of some sensors late."""
    times, kinds = recording.stamps_ns * 1e-9, [recording.gyr.copy(), recording.acc.copy()]
    for samples in kinds:
        for i in sensors:
            for a in range(3):
                samples[:, i, a] = np.interp(times - delay_s, times, samples[:, i, a])
    return kinds


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize(("lost", "within_s"), [(0.0, 1e-3), (0.05, 6e-3), (0.1, 9e-3)])
def test_lost_samples_make_no_difference_look_like_none(lost, within_s, seed):
    """A lost sample is missing twice at every lag but 0, at which sums of products then peaked."""
    lateness, rng = Lateness.unknown(2, 1, 0.025), np.random.default_rng(seed)
    times, ends = np.arange(2400) * 0.025, np.array([[0, 1]])
    waves = rng.uniform(0.5, 3.0, 20), rng.uniform(0.0, 7.0, (20, 3))

    def shared(at):
        return np.sin(2.0 * np.pi * waves[0][:, np.newaxis] * at + waves[1]).sum(axis=0)

    seen = np.where(rng.random((len(times), 2)) < lost, LOST, SOUND)
    for k in range(1, len(times)):
        acc = np.array([[shared(at), shared(at - 0.04)] for at in times[k - 1:k + 1]])
        correlate(np.array([[1.0, 0.0, 0.0, 0.0]]), np.zeros((1, 9)), ends, np.zeros((2, 2, 3)), acc,
                  seen[k - 1:k + 1], lateness.period_s, lateness.spacing, lateness.frame, lateness.passed,
                  lateness.kept, lateness.product, lateness.energy, lateness.usable, lateness.lasted)
    for band in (WHOLE, LOW):
        late_s, sd_s = np.zeros((2, 1))
        differences(lateness.product[band], lateness.energy[band], lateness.lasted, 0.025, band, late_s, sd_s)
        assert math.isclose(late_s[0], 0.04, abs_tol=within_s)


@pytest.mark.slow
@pytest.mark.parametrize(("late_s", "slow"), [({2: 0.04}, 3), ({2: 0.04}, 2), ({1: 0.03, 4: 0.05}, 3)])
def test_late_sensors_are_found_beside_a_slow_one_and_losses(late_s, slow, recordings):
    recording = open_recording(recordings / "chain5" / "trial1.npz", "rigid")
    gyr, acc = later_by(recording, 0.0, ())
    for sensor, delay_s in late_s.items():
        for kind, shifted in zip((gyr, acc), later_by(recording, delay_s, (sensor,)), strict=True):
            kind[:, sensor] = shifted[:, sensor]
    lost = np.random.default_rng(1).random(gyr.shape[:2]) < 0.05
    lost[1::2, slow] = True
    gyr[lost] = acc[lost] = np.nan
    _, reports, state = run_tracker(ConstrainedTracker(sensors=5), gyr, acc, rate=40)
    true = np.array([1e3 * late_s.get(sensor, 0.0) for sensor in range(5)])
    found = 1e3 * state.lateness.late_s
    assert np.abs(found - np.median(found - true) - true).max() < 10.0
    assert [detail for status, detail in reports if status == "slow_sensor"] == [
        f"samples come at different rates: sensor {slow} each 2. tick"]


@pytest.mark.slow
def test_what_foam_and_losses_hide_is_said_to_be_unknown(recordings):
    recording = open_recording(recordings / "chain5" / "trial1.npz", "nonrigid")
    gyr, acc = later_by(recording, 0.04, (2,))
    lost = np.random.default_rng(1).random(gyr.shape[:2]) < 0.05
    lost[1::2, 2] = True
    gyr[lost] = acc[lost] = np.nan
    _, reports, _ = run_tracker(ConstrainedTracker(sensors=5), gyr, acc, rate=40)
    told = [detail for status, detail in reports if status == "late_sensor"]
    assert "not known yet between 1 and 2" in told[-1]


@pytest.mark.slow
@pytest.mark.parametrize("sensors", [(2, 4), (1, 2)])
@pytest.mark.parametrize(("sensor_set", "within_ms"), [("rigid", 5.0), ("nonrigid", 10.0)])
def test_two_sensors_40_ms_late_are_found_and_cost_little(sensor_set, within_ms, sensors, recordings):
    recording = open_recording(recordings / "chain5" / "trial1.npz", sensor_set)
    rms_deg = []
    for late in ((), sensors):
        kinds = later_by(recording, 0.04, late)
        outputs, reports, state = run_tracker(ConstrainedTracker(sensors=5), *kinds, rate=40)
        score = score_recording(recording, recording.stamps_ns, outputs[0], "relative")
        rms_deg.append(np.mean([score["orientation_rmse_deg"][f"seg{i}-seg{i + 1}"]["total"]
                                for i in (2, 3, 4)]))
        assert bool(late) == any(status == "late_sensor" for status, _ in reports)
    assert rms_deg[1] < 1.2 * rms_deg[0]
    true = np.isin(np.arange(5), sensors) * 40.0
    found = 1e3 * state.lateness.late_s
    assert np.abs(found - np.median(found - true) - true).max() < within_ms


@pytest.mark.slow
@pytest.mark.parametrize("sensor", range(5))
def test_joints_of_a_late_sensor_are_of_their_kind_once_it_is_found(sensor, recordings):
    """Lever arms that were learnt from late samples are put right: that is no misfit."""
    recording = open_recording(recordings / "chain5" / "trial1.npz", "rigid")
    _, reports, _ = run_tracker(ConstrainedTracker(sensors=5), *later_by(recording, 0.04, (sensor,)), rate=40)
    assert {status for status, _ in reports} >= {"late_sensor"}
    assert "misfit" not in dict(reports)


@pytest.mark.slow
def test_a_late_sensor_of_a_wrist_is_found_within_26_s(recordings):
    recording = open_recording(recordings / "wrist" / "circle-250.npz")
    tracker = ConstrainedTracker(sensors=2, joints=(Joint(parent=0, child=1, kind="ball"),))
    for late in (0, 1):
        kinds = later_by(recording, 0.04, (late,))
        _, reports, state = run_tracker(tracker, *kinds, rate=125, last=3250)
        assert sum(status == "late_sensor" for status, _ in reports) == 1
        assert math.isclose(state.lateness.late_s[late], 0.04, abs_tol=0.008)


@pytest.mark.slow
@pytest.mark.parametrize("member", [0, 7])
def test_soft_tissue_that_rings_is_not_late(member, tmp_path):
    """Sensors of a hand that short stimulation throws about, which above 5 Hz seem 15 to 20 ms late."""
    result = run(load("array_search_gp", [f"member={member}", "duration_s=25"]), tmp_path)
    assert "late_sensor" not in {event.status for event in Recording(result.recording).events}
