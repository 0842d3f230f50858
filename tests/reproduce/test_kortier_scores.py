import numpy as np
import pytest
from told_recording import ToldRecording

from fesloop.apps.reproduce.error_model import Reference
from fesloop.apps.reproduce.kortier2014 import clenched_phase, flat_phase, index_tip, pinch, rapid, traces


def told(motion, trials=1):
    recording = ToldRecording(f"kortier_{motion}", trials)
    recording.tell("tracker.angles", recording.angles.copy())
    recording.tell("tracker.fingertips", recording.tips(recording.angles))
    return recording


def test_the_index_tip_is_scored_axis_by_axis_while_the_movement_lasts():
    recording = told("flexion", trials=2)
    estimate, _ = recording.told["tracker.fingertips"]
    estimate[:, 1] += [2e-3, 1e-3, -2e-3]
    estimate[:, [0, 2, 3, 4]] += 1.0
    estimate[recording.times_ns < 8e9] += 1.0
    np.testing.assert_allclose(index_tip(recording)["rms_mm"], [[2.0, 1.0, 2.0, 3.0]] * 2, atol=1e-9)


def test_the_index_tip_is_scored_from_its_first_joint():
    """A tracker with another palm and joint, which the paper's calibration trial shows, loses nothing."""
    recording = told("flexion")
    size = {"side": "left", "joints_mm": [[0.0] * 3, [3.0, -2.0, 4.0], *[[0.0] * 3] * 3]}
    recording.experiment["blocks"]["tracker"] = {"hand": size}
    estimate, _ = recording.told["tracker.fingertips"]
    estimate[:, 1] += 1e-3 * np.array(size["joints_mm"][1])
    np.testing.assert_allclose(index_tip(recording)["rms_mm"], 0.0, atol=1e-9)


def test_an_optical_frame_that_is_turned_and_shifted_shows():
    recording = told("flexion")
    half = np.radians(2.0)
    optical = Reference(np.array([np.cos(half), 0.0, 0.0, np.sin(half)]), np.zeros((5, 3)))
    _, _, z, distance = index_tip(recording, optical)["rms_mm"][0]
    assert z == pytest.approx(0.0, abs=1e-9)
    assert 1.0 < distance < np.radians(4.0) * 95.0
    shifted = Reference(np.array([1.0, 0.0, 0.0, 0.0]), np.full((5, 3), 2e-3))
    np.testing.assert_allclose(index_tip(recording, shifted)["rms_mm"][0][:3], 2.0)


def test_who_knows_the_posture_knows_that_the_tips_touch():
    scores = pinch(told("pinch", trials=2))
    assert scores["rms_mm"].shape == (20,)
    assert scores["rms_mm"].max() < 0.5
    assert scores["share"] < 0.01


def test_a_pinch_is_off_by_what_the_tips_are_apart():
    recording = told("pinch")
    flat = np.zeros_like(recording.angles)
    recording.tell("tracker.angles", flat)
    scores = pinch(recording)
    assert scores["share"] == pytest.approx(1.0)
    np.testing.assert_allclose(scores["rms_mm"], scores["rms_mm"][0])
    assert scores["rms_mm"][0] > 20.0


def test_the_range_of_rapid_movements_is_the_trackers():
    recording = told("rapid")
    estimate, _ = recording.told["tracker.angles"]
    estimate *= 0.5
    scores = rapid(recording)
    # Ten samples a half cycle may miss the turning point by a little.
    assert scores["true_range_deg"] == pytest.approx(80.0, abs=0.5)
    assert scores["range_deg"] == pytest.approx(0.5 * scores["true_range_deg"])


@pytest.mark.parametrize(("motion", "phase", "other"), [
    ("flat", flat_phase, clenched_phase), ("mould", clenched_phase, flat_phase)])
def test_repeatability_is_the_spread_of_ten_holds(motion, phase, other):
    """K14: range, largest less smallest of a trial, and standard deviation, of joint angles."""
    recording = told(motion)
    estimate, _ = recording.told["tracker.angles"]
    bend = np.degrees(recording.angles[:, recording.tree.freedom("F2_pip_flexion")])
    moving = recording.times_ns > 10e9
    there = moving & ((bend < 0.1) if motion == "flat" else (bend > bend[moving].max() - 0.1))
    begins = np.flatnonzero(there & ~np.roll(there, 1))[-10:]
    number = np.searchsorted(begins, np.arange(len(there)), side="right") - 1
    held = there & (number >= 0)
    estimate[held] += np.radians(0.2 * number[held])[:, np.newaxis]
    scores = phase(recording)
    assert scores["range_deg"] == pytest.approx(1.8, abs=0.02)
    assert scores["sd_deg"] == pytest.approx(np.std(0.2 * np.arange(10), ddof=1), abs=0.01)
    assert other(recording)["range_deg"] == pytest.approx(0.0, abs=0.05)


def test_traces_hold_estimate_beside_truth():
    recording = told("rapid")
    recording.tell("hand.rates", np.ones_like(recording.angles))
    kept = traces(recording)
    np.testing.assert_allclose(kept["tip_mm"], kept["true_tip_mm"])
    np.testing.assert_allclose(kept["rate_deg_s"], np.degrees(1.0))
    assert kept["rate_times_s"][[0, -1]] == pytest.approx(kept["times_s"][[0, -1]])
