"""The moving hand of a report, against the recording, against MuJoCo, and against other kinematics."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from homogeneous import segment_matrices
from hypothesis import given
from hypothesis import strategies as st

from controllers.reference import MinimumJerk
from fesloop import Experiment, Recording
from fesloop.experiment.files.parse import load
from fesloop.experiment.running import run
from fesloop.hand import quaternion
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.skeleton import RESTING_DEG, dorsal_points, hand_tree
from fesloop.loop.clock import NS_PER_MS, NS_PER_S
from fesloop.loop.nodes import Node
from fesloop.show.picture.cast import Cast, Player
from fesloop.show.report import motion
from fesloop.show.report.motion import hand_motion, hand_of, step_between
from fesloop.show.report.recorded_hand import hands_at, recorded_hand, rows_of
from fesloop.show.report.run.opening import readable

GRASP = str(Path(__file__).parent.parent / "picture" / "grasp.toml")


def recorded(folder, experiment, *settings):
    return Path(run(load(experiment, settings), folder).recording)


@pytest.fixture(scope="module")
def grasp(tmp_path_factory):
    """Two trials of half a second, and the figure."""
    path = recorded(tmp_path_factory.mktemp("runs"), GRASP, "experiment.trials=2")
    with Recording(path) as recording:
        yield recording, hand_motion(recording)


def at_frames(recording, name, trial, frames):
    """A signal's newest value at every frame, found one by one."""
    signal = recording.signal(name, trial)
    instants = frames.start_s + frames.step_s * np.arange(len(frames.objects))
    return np.stack([signal.values[signal.times_ns <= round(now * NS_PER_S)][-1] for now in instants])


def test_frames_are_even_and_reach_to_the_end(grasp):
    recording, figure = grasp
    assert list(figure.trials) == [0, 1]
    for trial, frames in figure.trials.items():
        assert (frames.start_s, frames.step_s) == (0.0, 0.04)
        last = recording.signal("hand.angles", trial).times_ns[-1] / NS_PER_S
        assert last - 0.04 < 0.04 * (len(frames.objects) - 1) <= last
        assert {name: len(poses) for name, poses in frames.hands.items()} == {
            "truth": len(frames.objects), "estimate": len(frames.objects)}


@pytest.mark.parametrize(("last_ms", "frames"), [(0, 1), (79, 2), (80, 3)])
def test_the_last_instant_has_its_frame_also_of_a_trial_of_one(grasp, monkeypatch, last_ms, frames):
    recording, _ = grasp
    monkeypatch.setattr(motion, "recorded_spans", lambda recording, hand: {1: (0, last_ms * NS_PER_MS)})
    figure = hand_motion(recording)
    assert {trial: len(each.hands["truth"]) for trial, each in figure.trials.items()} == {1: frames}


@pytest.mark.parametrize("trial", [0, 1])
def test_sensors_on_the_true_hand_are_where_mujoco_had_them(grasp, trial):
    recording, figure = grasp
    frames = figure.trials[trial]
    truth = frames.hands["truth"]
    sites = truth[..., 4:] + quaternion.rotate(truth[..., :4], dorsal_points(HandSize(side="left",
                                                                                      hand_mm=180.0)))
    np.testing.assert_allclose(sites, at_frames(recording, "hand.site_position", trial, frames), atol=1e-9)


def test_the_estimated_hand_has_the_trackers_angles_and_the_true_palm(grasp):
    recording, figure = grasp
    frames = figure.trials[0]
    truth, estimate = frames.hands["truth"], frames.hands["estimate"]
    angles = at_frames(recording, "tracker.angles", 0, frames)
    own = segment_matrices(hand_tree(HandSize(side="left", hand_mm=180.0)), angles)
    # Of the tracker of this recording, which does not see the wrist.
    palm = np.tile(np.eye(4), (len(truth), 1, 1))
    palm[:, :3, :3], palm[:, :3, 3] = quaternion.to_matrix(truth[:, 1, :4]), truth[:, 1, 4:]
    expected = (palm @ np.linalg.inv(own[:, 1]))[:, np.newaxis] @ own
    np.testing.assert_allclose(estimate[..., 4:], expected[..., :3, 3], atol=1e-9)
    np.testing.assert_allclose(quaternion.to_matrix(estimate[..., :4]), expected[..., :3, :3], atol=1e-9)
    assert len(figure.shapes["estimate"][0].faces) == 0 < len(figure.shapes["truth"][0].faces)


def test_the_object_moves_as_recorded_and_the_table_sinks_as_told(grasp):
    recording, figure = grasp
    frames = figure.trials[1]
    thing, top = figure.objects
    assert (thing.kind, thing.half_sizes, thing.moves) == ("cylinder", (0.025, 0.025, 0.06), True)
    assert (top.kind, top.half_sizes, top.moves) == ("box", (0.3, 0.3, 0.005), True)
    np.testing.assert_array_equal(frames.objects[:, 0, 4:],
                                  at_frames(recording, "hand.object_position", 1, frames))
    np.testing.assert_array_equal(frames.objects[:, 0, :4],
                                  at_frames(recording, "hand.object_orientation", 1, frames))
    since = np.maximum(0.04 * np.arange(len(frames.objects)) - 0.1, 0.0)
    np.testing.assert_allclose(frames.objects[:, 1, 6], -0.0601 - 0.005 - 0.1 * since, atol=1e-9)


def test_a_table_that_stays_has_one_pose(tmp_path):
    path = recorded(tmp_path, GRASP, "blocks.hand.table={height_m=-0.0601, centre_m=[0.15, 0.2]}",
                    "experiment.duration_s=0.2")
    with Recording(path) as recording:
        figure = hand_motion(recording)
    top = figure.objects[1]
    assert not top.moves
    assert top.pose == pytest.approx((1.0, 0.0, 0.0, 0.0, 0.15, 0.2, -0.0651))
    assert figure.trials[0].objects.shape[1] == 1


@pytest.mark.slow
def test_a_finger_bends_as_scored_in_a_hand_at_rest(tmp_path):
    path = recorded(tmp_path, "finger_control", "experiment.duration_s=1", "score.after_s=0")
    with Recording(path) as recording:
        figure = hand_motion(recording)
        frames = figure.trials[0]
        bent = {hand: at_frames(recording, f"{block}.angles", 0, frames)
                for hand, block in (("truth", "patient"), ("estimate", "tracker"))}
    tree = hand_tree(HandSize())
    for hand, angles in bent.items():
        posture = np.tile(np.deg2rad([RESTING_DEG[name] for name in tree.freedoms]), (len(angles), 1))
        for joint, column in zip(("mcp", "pip", "dip"), angles.T, strict=True):
            posture[:, tree.freedom(f"F2_{joint}_flexion")] = column
        relative = np.linalg.inv(segment_matrices(tree, posture)[:, :1]) @ segment_matrices(tree, posture)
        poses = frames.hands[hand]
        own = quaternion.to_matrix(quaternion.relative(poses[:, :1, :4], poses[..., :4]))
        np.testing.assert_allclose(own, relative[..., :3, :3], atol=1e-9)
    shown = [len(mesh.faces) > 0 for mesh in figure.shapes["estimate"]]
    assert [name for name, there in zip(tree.names, shown, strict=True) if there] == ["F2p", "F2m", "F2d"]


def test_a_recording_without_a_hand_has_none(tmp_path):
    reference = Node("reference", MinimumJerk(times_s=(0.0,), angles_deg=((10.0, 20.0, 30.0),)), "100")
    experiment = Experiment(name="none", nodes=(reference,), duration_s=0.1)
    with Recording(experiment.run(tmp_path).recording) as recording:
        assert hand_motion(recording) is None


class Told:
    """Signals that somebody thought of."""

    def __init__(self, late=None, **columns):
        self.columns = {name.replace("_", ".", 1): values for name, values in columns.items()}
        self.signals, self.late = list(self.columns), late or {}

    def column(self, name, trial=0):
        values = self.columns[name]
        return 10_000_000 * (np.arange(len(values)) + self.late.get(name, 0)), values


TRACKER = Player("tracker", SimpleNamespace(size=HandSize(side="left")))
HAND = Player("hand", SimpleNamespace(size=HandSize(side="left")))


def cast(hand=None, trackers=()):
    return Cast(hand, trackers, None, None, "", "", "", "")


def test_a_tracker_by_itself_is_drawn_with_its_palm_down():
    angles = np.random.default_rng(1).uniform(0.0, 0.5, (4, 23))
    signals = Told(tracker_angles=angles)
    hand = recorded_hand(signals, cast(None, (TRACKER,)), {})
    posture = hand.postures(signals, 0, 10_000_000 * np.arange(4))["estimate"]
    back = quaternion.rotate(posture.poses.orientation[:, 0], [1.0, 0.0, 0.0])
    np.testing.assert_allclose(back, [[0.0, 0.0, 1.0]] * 4, atol=1e-12)
    matrices = segment_matrices(hand_tree(TRACKER.hand_size), angles)
    tips = quaternion.rotate(quaternion.conjugate(posture.poses.orientation[:, :1]), posture.poses.position)
    np.testing.assert_allclose(tips, matrices[..., :3, 3], atol=1e-12)


def test_what_a_tracker_does_not_know_is_not_a_number_and_no_more_than_that():
    angles = np.zeros((3, 23))
    tree = hand_tree(TRACKER.hand_size)
    angles[1, tree.freedom("F3_pip_flexion")] = np.nan
    signals = Told(tracker_angles=angles, hand_angles=np.zeros((3, 23)))
    hand = recorded_hand(signals, cast(HAND, (TRACKER,)), {})
    postures = hand.postures(signals, 0, 10_000_000 * np.arange(3))
    lost = np.isnan(rows_of(postures["estimate"])).any(axis=-1)
    unknown = {tree.names[k] for k in np.flatnonzero(lost[1])}
    assert unknown == {"F3m", "F3d"}
    assert not lost[[0, 2]].any()
    assert np.isfinite(rows_of(postures["truth"])).all()


def test_before_its_first_estimate_a_tracker_knows_nothing():
    signals = Told({"tracker.angles": 2}, tracker_angles=np.zeros((2, 23)), hand_angles=np.zeros((4, 23)))
    hand = recorded_hand(signals, cast(HAND, (TRACKER,)), {})
    postures = hand.postures(signals, 0, 10_000_000 * np.arange(4))
    assert np.isnan(rows_of(postures["estimate"])).all(axis=(1, 2)).tolist() == [True, True, False, False]
    assert np.isfinite(rows_of(postures["estimate"])[2:]).all()
    assert np.isfinite(rows_of(postures["truth"])).all()


@pytest.mark.parametrize("ends", ["hand", "tracker"])
def test_what_a_file_has_lost_the_end_of_is_not_shown_to_stand_still(ends):
    """One signal ends after two rows of 10 ms, the other after fifty; rows stand for .1 s."""
    rows = {"hand_angles": np.zeros((50, 23)), "tracker_angles": np.zeros((50, 23))}
    rows[f"{ends}_angles"] = np.zeros((2, 23))
    signals, at_ns = Told(**rows), 10_000_000 * np.arange(50)
    whole = recorded_hand(signals, cast(HAND, (TRACKER,)), {})
    still = hands_at(signals, whole, 0, at_ns)
    assert all(np.isfinite(poses).all() for poses in still.hands.values())
    left = hands_at(signals, replace(whole, held_ns=100_000_000), 0, at_ns)
    lost = {name: np.isnan(poses).all(axis=(1, 2)).tolist() for name, poses in left.hands.items()}
    name, other = ("truth", "estimate") if ends == "hand" else ("estimate", "truth")
    assert lost[name] == [False] * 12 + [True] * 38
    if other == "truth":
        assert not any(lost[other])


def test_of_a_damaged_file_rows_do_not_stand_for_ever(grasp, tmp_path):
    recording, _ = grasp
    assert hand_of(recording).held_ns > 10**18
    cut = tmp_path / "cut.h5"
    whole = recording.path.read_bytes()
    cut.write_bytes(whole[:int(0.9 * len(whole))])
    with readable(cut) as (left, _):
        assert hand_of(left).held_ns == 100 * NS_PER_MS
        hand = hand_of(left)
        times = left.signal("hand.site_orientation", 0).times_ns
        at_ns = times[-1] + np.array([0, 90, 110]) * NS_PER_MS
        found = hands_at(left, hand, 0, at_ns)
    lost = [False, False, True]
    assert np.isnan(found.hands["truth"]).all(axis=(1, 2)).tolist() == lost
    thing, top = (solid.role for solid in found.solids)
    assert (thing, top) == ("object", "surface")
    assert np.isnan(found.solid_poses[:, 0]).all(axis=1).tolist() == lost
    assert np.isfinite(found.solid_poses[:, 1]).all()


@pytest.mark.parametrize(("columns", "score"), [
    ({"tracker_angles": np.zeros((3, 3))}, {}),
    ({"plant_angles": np.zeros((3, 2))}, {"truth": "plant.angles"}),
    ({"tracker_angles": np.zeros((3, 3))}, {"estimate": "tracker.angles"}),
    ({}, {"truth": "plant.angles"})])
def test_other_angles_are_no_hand(columns, score):
    assert recorded_hand(Told(**columns), cast(None, (TRACKER,)), score) is None


@given(whole_s=st.floats(0.0, 1e5))
def test_frames_are_few(whole_s):
    whole_ns = round(whole_s * NS_PER_S)
    step_ns = step_between(whole_ns)
    assert step_ns % 40_000_000 == 0
    assert whole_ns / step_ns <= 4000
    assert step_ns == 40_000_000 or whole_ns / (step_ns - 40_000_000) > 4000
