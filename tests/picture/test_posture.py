"""Postures out of a recording, against where MuJoCo had the sensors and the tips."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from fesloop import Experiment
from fesloop.experiment.record_spec import Record
from fesloop.experiment.recording.reading import Recording
from fesloop.hand import quaternion
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.skeleton import dorsal_points
from fesloop.loop.nodes import Node
from fesloop.show.picture.cast import cast_of
from fesloop.show.picture.posture import estimated_posture, true_posture
from fesloop.show.picture.scene import half_sizes, solids_of
from fesloop.show.picture.signals import curve, values_at
from plants.hand.scene import GraspObject
from plants.moving_hand import MovingHand

AT = np.array([0, 123_456_789, 400_000_000])


def sites(posture):
    """Where the sensors are on the hand in a posture, (t, 17, 3)."""
    poses = posture.poses
    return poses.position + quaternion.rotate(poses.orientation, dorsal_points(posture.size))


def test_blocks_are_found_by_what_they_have_and_by_their_wires(grasp):
    with Recording(grasp) as recording:
        cast = cast_of(recording)
    names = [player.name for player in (cast.hand, cast.electrodes, cast.stimulator)]
    assert names == ["hand", "electrodes", "stimulator"]
    assert [tracker.name for tracker in cast.trackers] == ["tracker"]
    assert (cast.muscles, cast.stimulation, cast.multiplexing) == ("muscles", "programme.stimulation", "")
    assert (cast.hand.hand_size.side, cast.hand.hand_size.hand_mm) == ("left", 180.0)


def test_the_true_hand_is_where_mujoco_had_it(grasp):
    with Recording(grasp) as recording:
        hand = cast_of(recording).hand
        posture = true_posture(recording, hand, 0, AT)
        expected = values_at(recording, "hand.site_position", 0, AT)
        tips = values_at(recording, "hand.fingertips", 0, AT)
    np.testing.assert_allclose(sites(posture), expected, atol=1e-9)
    wrist, turn = posture.poses.position[:, :1], posture.poses.orientation[:, :1]
    np.testing.assert_allclose(quaternion.rotate(quaternion.conjugate(turn), posture.poses.position - wrist)[
        :, [4, 7, 10, 13, 16]], tips, atol=1e-9)


@pytest.mark.parametrize("left_out", [
    ["hand.site_orientation", "hand.site_position"], ["hand.angles"], ["hand.site_position"]])
def test_what_is_left_of_a_recording_is_enough(recorded, grasp, left_out):
    with Recording(grasp) as recording:
        whole = true_posture(recording, cast_of(recording).hand, 0, AT)
    names = ", ".join(f'"{name}"' for name in left_out)
    with Recording(recorded(f"record.leave_out=[{names}]")) as recording:
        less = true_posture(recording, cast_of(recording).hand, 0, AT)
    np.testing.assert_allclose(less.poses.position, whole.poses.position, atol=1e-6)


@pytest.mark.slow
def test_a_persons_own_joint_axes_are_drawn_as_they_are(tmp_path):
    tilted = HandSize(axes_deg={"F2m": (5.0, -3.0, 4.0), "hand": (0.0, 6.0, 2.0)})
    hand = MovingHand(script="kortier_flexion", hand=tilted)
    experiment = Experiment(name="tilted", nodes=(Node("hand", hand),), duration_s=3.0,
                            record=Record(plant_rate="100"))
    with Recording(experiment.run(tmp_path).recording) as recording:
        posture = true_posture(recording, cast_of(recording).hand, 0, np.array([2 * 10**9]))
        expected = values_at(recording, "hand.site_orientation", 0, np.array([2 * 10**9]))
    np.testing.assert_array_equal(posture.poses.orientation, expected)


def test_a_tracker_that_does_not_see_the_wrist_is_laid_onto_the_true_palm(grasp):
    with Recording(grasp) as recording:
        cast = cast_of(recording)
        truth = true_posture(recording, cast.hand, 0, AT)
        found, laid_at = estimated_posture(recording, cast.trackers[0], 0, AT, truth)
    assert laid_at == "hand"
    np.testing.assert_allclose(found.poses.position[:, 1], truth.poses.position[:, 1], atol=1e-12)
    turned = quaternion.relative(found.poses.orientation[:, 1], truth.poses.orientation[:, 1])
    assert quaternion.rotation_angle(turned).max() < 1e-6
    lengths = [np.linalg.norm(each.poses.position[:, 6] - each.poses.position[:, 5], axis=-1)
               for each in (found, truth)]
    np.testing.assert_allclose(*lengths)


def test_object_and_table_stand_where_they_were_put_and_sink_when_told(grasp):
    with Recording(grasp) as recording:
        scenes, notes = solids_of(recording, cast_of(recording).hand, 0, AT)
    assert notes == []
    thing, top = scenes[0]
    np.testing.assert_allclose(thing.position, [0.15, 0.2, 0.0], atol=1e-3)
    np.testing.assert_allclose(thing.half, [0.025, 0.06, 0.0])
    assert top.position[2] + top.half[2] == pytest.approx(-0.0601)
    # From .1 s on the table sinks .1 m/s.
    assert scenes[2][1].position[2] == pytest.approx(top.position[2] - 0.03)


def test_an_object_that_waits_to_be_given_is_not_there_yet():
    thing = GraspObject(size_mm=(50.0, 120.0), position_m=(0.0, 0.1, 0.0), given_at_s=0.5)
    places = np.array([[0.0, 0.35, 0.0], [0.0, 0.1, 0.0], [0.0, 0.34, 0.0]])
    rows = {"hand.object_position": places, "hand.object_orientation": np.tile([1.0, 0.0, 0.0, 0.0], (3, 1))}
    times = np.arange(3, dtype=np.int64)
    signals = SimpleNamespace(signals=rows, column=lambda name, trial: (times, rows[name]))
    for each, shown in ((thing, [0, 1, 1]), (replace(thing, given_at_s=0.0), [1, 1, 1]),
                        (replace(thing, waits_m=(0.0, 0.0, 0.0)), [1, 1, 1])):
        hand = SimpleNamespace(name="hand", part=SimpleNamespace(object=each))
        assert [len(solids) for solids in solids_of(signals, hand, 0, times)[0]] == shown


def test_a_mugs_solids_follow_its_pose():
    """A corner of the floor and the handle's outermost point, as a turn by hand has them."""
    turn = np.array([0.5**0.5, 0.0, 0.0, 0.5**0.5])
    thing = SimpleNamespace(shape="mug", size_mm=(80.0, 90.0, 4.0, 30.0))
    hand = SimpleNamespace(name="hand", part=SimpleNamespace(object=thing))
    rows = {"hand.object_position": np.array([[0.1, 0.2, 0.3]]), "hand.object_orientation": turn[np.newaxis]}
    times = np.zeros(1, dtype=np.int64)
    signals = SimpleNamespace(signals=rows, column=lambda name, trial: (times, rows[name]))
    (solids,), notes = solids_of(signals, hand, 0, times)
    assert notes == []
    assert {solid.kind for solid in solids} == {"box", "cylinder", "sphere"}
    # x turns to y: the handle's outside is at y = 0.2 + 0.04 + 0.03.
    for point, distance in (([0.1, 0.27, 0.3], 0.0), ([0.1, 0.2, 0.3], 0.036), ([0.1, 0.2, 0.255], 0.0),
                            ([0.14, 0.2, 0.3], 0.0), ([0.1, 0.2, 0.345], 0.036)):
        nearest = min(float(solid.distances(np.array([point]))[0]) for solid in solids)
        assert abs(nearest) == pytest.approx(distance, abs=5e-4)


def test_an_objects_half_sizes():
    np.testing.assert_allclose(half_sizes("card", (50.0, 80.0, 1.0)), [0.025, 0.04, 0.0005])
    np.testing.assert_allclose(half_sizes("ball", (50.0,)), [0.025, 0.0, 0.0])


def test_a_signal_is_held_until_the_next_value(grasp):
    with Recording(grasp) as recording:
        signal = recording.signal("hand.angles")
        at = np.array([-5, 10_000_000, 19_999_999, 20_000_000, 10**12])
        held = values_at(recording, "hand.angles", 0, at)
    np.testing.assert_array_equal(held, signal.values[[0, 1, 1, 2, -1]])


def test_a_thinned_curve_loses_no_peak(grasp, monkeypatch):
    monkeypatch.setattr("fesloop.show.picture.signals._POINTS", 7)
    monkeypatch.setattr("fesloop.show.picture.signals._ROWS_A_READ", 16)
    with Recording(grasp) as recording:
        signal = recording.signal("hand.rates")
        seconds, values = curve(recording, "hand.rates", 0, 400_000_000)
    shown = signal.values[signal.times_ns <= 400_000_000]
    assert len(seconds) == len(values) < len(shown)
    assert (np.diff(seconds) >= 0.0).all()
    np.testing.assert_array_equal(values.max(axis=0), shown.max(axis=0))
    np.testing.assert_array_equal(values.min(axis=0), shown.min(axis=0))
