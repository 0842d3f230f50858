import numpy as np
import pytest
from told_recording import ToldRecording

from fesloop.apps.reproduce.salchow2019 import (
    METHODS,
    PAIRS,
    distance_traces,
    distances,
    node_of,
    scoring_of,
    tip,
    tip_traces,
)
from fesloop.hand import quaternion
from fesloop.hand.kinematics import segment_poses
from fesloop.hand.skeleton import contact_points


def on_tips(offsets_m):
    """A recording of F-F2 in which every method is off by a vector of its own from 5 s on, by 1 m before."""
    recording = ToldRecording("F-F2")
    truth = recording.tips(recording.angles)
    before = recording.times_ns < 5_000_000_000
    for method, offset in zip(METHODS, offsets_m, strict=True):
        told = truth + np.where(before[:, np.newaxis, np.newaxis], 1.0, np.asarray(offset))
        recording.tell(f"{node_of(method)}.fingertips", told)
    return recording


def test_the_error_of_a_tip_is_its_distance_from_the_truth_while_the_movement_lasts():
    scores = tip(on_tips([(0.03, 0.04, 0.0), (0.0, 0.0, 0.01), (0.0, 0.0, 0.0)]), "F2")
    assert scores["B"] == pytest.approx(
        {"rmse": 5.0, "mean": 5.0, "std": 0.0, "low": 5.0, "median": 5.0, "high": 5.0, "worst": 5.0},
        abs=1e-9)
    assert scores["M1"]["rmse"] == pytest.approx(1.0)
    assert scores["M2"]["rmse"] == pytest.approx(0.0, abs=1e-9)


def test_each_movement_is_scored_at_the_finger_that_it_names():
    recording = on_tips([(0.01, 0.0, 0.0)] * 3)
    told, _ = recording.told["salchow_m1.fingertips"]
    told[:, 2, 0] += 0.01
    assert scoring_of("A-F3")(recording)["M1"]["rmse"] == pytest.approx(2.0)
    assert scoring_of("A-F2")(recording)["M1"]["rmse"] == pytest.approx(1.0)


def on_distances(motion, angles_of):
    """A recording in which every method takes the angles for what `angles_of` makes of them."""
    recording = ToldRecording(motion)
    angles = angles_of(recording.angles)
    recording.tell("salchow_b.orientation", segment_poses(recording.tree, angles).orientation)
    for method in ("m1", "m2"):
        recording.tell(f"salchow_{method}.angles", angles)
    return recording


@pytest.mark.slow
@pytest.mark.parametrize("motion", PAIRS)
def test_who_knows_the_posture_knows_the_distances(motion):
    """The published distances, between the published points: no score is off by more than half a mm."""
    scores = distances(on_distances(motion, lambda angles: angles), PAIRS[motion])
    for method in METHODS:
        assert list(scores[method]) == [f"{first[:2]}-{second[:2]}" for first, second, _ in PAIRS[motion]]
        assert all(score["worst"] < 0.05 for score in scores[method].values())


def test_the_error_of_a_distance_is_that_of_eq_32():
    """A hand that is taken for straight: the distance of its points less 3 cm."""
    recording = on_distances("P1", np.zeros_like)
    ends = recording.tips(np.zeros((1, 23)))[0, :2] + contact_points(recording.plant.hand)[:2, 1]
    # The thumb's distal frame is turned in the straight hand: its own orientation carries the point.
    thumb = segment_poses(recording.tree, np.zeros((1, 23))).orientation[0, 4]
    np.testing.assert_allclose(np.abs(thumb[0]), 1.0, atol=1e-12)
    expected = abs(100.0 * np.linalg.norm(ends[1] - ends[0]) - 3.0)
    scores = distances(recording, PAIRS["P1"])
    for method in METHODS:
        assert scores[method]["F1-F2"]["rmse"] == pytest.approx(expected, abs=1e-9)


def test_a_heading_error_that_all_segments_share_cancels_in_distances():
    recording = on_distances("P1", lambda angles: angles)
    told, _ = recording.told["salchow_b.orientation"]
    turn = quaternion.from_axis_angle(np.array([0.0, 0.0, 1.0]), 1.0)
    recording.tell("salchow_b.orientation", quaternion.multiply(turn, told))
    assert distances(recording, PAIRS["P1"])["B"]["F1-F2"]["worst"] < 0.05


def test_pinches_count_while_the_tips_touch():
    """Where the grip is open, an error of a metre is none."""
    recording = on_distances("P3", lambda angles: angles)
    traces = distance_traces(recording)
    assert traces["spans"].shape == (2, 2)
    touching = np.zeros(traces["times_s"].size, dtype=bool)
    for start, stop in traces["spans"]:
        touching |= (traces["times_s"] >= start) & (traces["times_s"] <= stop)
    assert traces["distance_cm"][touching].max() < 0.05
    assert traces["distance_cm"][~touching].max() > 3.0


def test_traces_are_of_the_index_tip_in_cm():
    traces = tip_traces(on_tips([(0.0, 0.0, 0.0), (0.01, 0.0, 0.0), (0.0, 0.0, 0.0)]))
    np.testing.assert_allclose(traces["estimate_cm"] - traces["truth_cm"], [[1.0, 0.0, 0.0]] * len(
        traces["times_s"]), atol=1e-9)
