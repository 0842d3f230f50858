import numpy as np
import pytest
from told_recording import ToldRecording

import fesloop
from fesloop.apps.reproduce.hand_recording import (
    Seen,
    contact_points_of,
    plant_of,
    poses_by_angles,
    poses_by_orientations,
    seen,
    size_of,
    spans,
    within,
)
from fesloop.experiment.recording.reading import Recording
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.skeleton import contact_points


@pytest.fixture(scope="module")
def moved(tmp_path_factory):
    """A second of the shipped experiment, really recorded."""
    settings = ["duration_s=1", "score.after_s=0", "blocks.hand.hand.axes_deg={F2m=[5.0, 0.0, 0.0]}"]
    result = fesloop.load("kortier2014", settings, 4).run(
        tmp_path_factory.mktemp("runs"))
    with Recording(result.recording) as recording:
        yield recording


def test_the_plant_of_a_recording_is_the_one_that_moved(moved):
    plant = plant_of(moved)
    assert plant.script == "kortier_flexion"
    assert plant.hand == HandSize(side="left", axes_deg={"F2m": (5.0, 0.0, 0.0)})
    assert size_of(moved, "tracker") == HandSize(side="left")
    assert spans(moved, "task") == [pytest.approx((10.0, 15.0))]


def test_truth_is_that_of_the_capture(moved):
    rows = seen(moved, "tracker.fingertips", "hand.fingertips")
    truth = moved.signal("hand.fingertips")
    at = np.searchsorted(truth.times_ns, np.round(rows.times_s * 1e9).astype(int), side="right") - 1
    np.testing.assert_array_equal(rows.truth, truth.values[at])


def test_late_estimates_are_held_against_what_they_saw():
    recording = ToldRecording("F-F2")
    late = np.roll(recording.angles, 5, axis=0)
    captured = recording.times_ns - 5 * 10_000_000
    recording.tell("tracker.angles", late, captured)
    rows = seen(recording, "tracker.angles", "hand.angles")
    assert len(rows.times_s) == len(recording.times_ns) - 5
    np.testing.assert_array_equal(rows.estimate, rows.truth)


def test_only_what_lies_in_the_span_counts():
    rows = Seen(np.arange(10.0), np.arange(10.0), np.zeros(10))
    np.testing.assert_array_equal(within(rows, (2.0, 4.0)).estimate, [2.0, 3.0, 4.0])


def test_points_of_contact_stand_on_the_fingertips_whose_names_they_bear():
    size = HandSize(side="left")
    straight = poses_by_angles(size, np.zeros((1, 23)))
    found = contact_points_of(size, straight, ("F2 left", "F3 right", "F2 tip"))[0]
    bottom_up = contact_points(size)
    ends = straight.position[0, [7, 10]]
    np.testing.assert_allclose(found[0], ends[0] + bottom_up[1, 3], atol=1e-12)
    np.testing.assert_allclose(found[1], ends[1] + bottom_up[2, 4], atol=1e-12)
    np.testing.assert_allclose(found[2], ends[0], atol=1e-12)
    # On a left hand the index finger's left side faces the middle finger.
    assert np.linalg.norm(found[0] - found[1]) < np.linalg.norm(ends[0] - ends[1])


def test_a_hand_is_where_it_is_by_angles_and_by_orientations():
    size, rng = HandSize(side="left"), np.random.default_rng(1)
    angles = rng.uniform(-0.5, 0.5, (5, 23))
    by_angles = poses_by_angles(size, angles)
    turned = poses_by_orientations(size, by_angles.orientation)
    np.testing.assert_allclose(turned.position, by_angles.position, atol=1e-12)
