"""Trackers on real recordings, through replay and loop, against bare VQF and published figures."""

import numpy as np
import pytest
from vqf import VQF

from estimators.fusion import Vqf9Tracker, VqfTracker
from estimators.salchow import SalchowB, SalchowM2
from fesloop.apps.bench.tracker import tick_times_us
from fesloop.experiment.metrics.orientation import score_recording
from fesloop.hand.kinematics import joint_angles, relative_of_segments
from fesloop.hand.segments import Segment, SegmentTree
from fesloop.loop.nodes import Node
from fesloop.loop.record import Recorder
from fesloop.loop.run import Loop
from fesloop.loop.wire import Wire
from fesloop.loop.wiring import Wiring
from fesloop.streams.blocks.replay import Replay

BROAD = ["02_undisturbed_slow_rotation_B", *(pytest.param(name, marks=pytest.mark.slow) for name in (
    "21_undisturbed_fast_combined", "24_disturbed_tapping_A", "30_disturbed_stationary_magnet_C"))]
BOTH = [(VqfTracker(), "relative", "quat6D"), (Vqf9Tracker(), "absolute", "quat9D")]


def replayed(path, tracker, sensor_set=None):
    """(recording, capture instants, orientations, events) of a tracker fed by a replay."""
    replay = Replay(recording=str(path), sensor_set=sensor_set)
    recording = replay.source
    wires = [Wire(source=f"replay.{port.name}", target=f"tracker.{port.name}") for port in tracker.inputs]
    recorder = Recorder()
    nodes = [Node("replay", replay), Node("tracker", tracker, rate=recording.rate)]
    Loop(Wiring(nodes, wires), recorder=recorder).run_until(recording.duration_ns)
    rows = recorder.blocks["tracker"]
    return recording, np.array([r[4] for r in rows]), np.array([r[5][0] for r in rows]), recorder.events


def scores(path, tracker, heading, sensor_set=None):
    recording, times, orientation, events = replayed(path, tracker, sensor_set)
    # VQF begins without a pose, and joints of the chain turn as none of a hand can.
    allowed = {"no_initial_pose"} | ({"implausible_angle"} if path.parent.name == "chain5" else set())
    assert {status for *_, status, _ in events} <= allowed
    return score_recording(recording, times, orientation, heading)


@pytest.mark.slow
@pytest.mark.parametrize("trial", BROAD)
@pytest.mark.parametrize(("tracker", "heading", "key"), BOTH)
def test_broad_within_a_tenth_of_a_bare_batch_run(recordings, trial, tracker, heading, key):
    recording, times, orientation, _ = replayed(recordings / "broad" / f"{trial}.mat", tracker)
    ours = score_recording(recording, times, orientation, heading)["orientation_rmse_deg"]["imu"]
    kinds = (np.ascontiguousarray(kind[:, 0]) for kind in (recording.gyr, recording.acc, recording.mag))
    batch = VQF(1 / float(recording.rate)).updateBatch(*kinds)[key][:, np.newaxis]
    bare = score_recording(recording, recording.stamps_ns, batch, heading)["orientation_rmse_deg"]["imu"]
    assert ours["total"] == pytest.approx(bare["total"], rel=0.1)
    assert ours["inclination"] == pytest.approx(bare["inclination"], rel=0.1)
    assert ours["total"] < 6.0


def test_wrist_angle(recordings):
    score = scores(recordings / "wrist" / "circle-250.npz", VqfTracker(), "relative")
    assert score["relative_angle_rmse_deg"]["radius-carpus"] <= 1.7
    assert "orientation_rmse_deg" not in score


# Hinges, published with the recording: 6-axis 13.2 rigid and 13.4 foam, 9-axis 18.9 and 24.2 deg.
@pytest.mark.parametrize(("tracker", "sensor_set", "published"), [
    (VqfTracker(), "rigid", 13.2), *(pytest.param(*row, marks=pytest.mark.slow) for row in (
        (VqfTracker(), "nonrigid", 13.4), (Vqf9Tracker(), "rigid", 18.9),
        (Vqf9Tracker(), "nonrigid", 24.2)))])
def test_hinges_of_the_chain(recordings, tracker, sensor_set, published):
    score = scores(recordings / "chain5" / "trial1.npz", tracker, "relative", sensor_set)
    hinges = [score["orientation_rmse_deg"][f"seg{i}-seg{i + 1}"]["total"] for i in (2, 3, 4)]
    assert np.mean(hinges) == pytest.approx(published, rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize(("sensor_set", "published"), [("rigid", 18.1), ("nonrigid", 10.5)])
def test_saddles_of_the_chain(recordings, sensor_set, published):
    score = scores(recordings / "chain5" / "trial1.npz", VqfTracker(), "relative", sensor_set)
    saddles = [score["orientation_rmse_deg"][pair]["total"] for pair in ("seg2-seg4", "seg3-seg5")]
    assert np.mean(saddles) == pytest.approx(published, rel=0.04)


CHAIN5 = (Segment(name="seg1"), Segment(name="seg2", parent="seg1", joint="ball"),
          *(Segment(name=f"seg{i + 1}", parent=f"seg{i}", joint="hinge", axes=(axis,))
            for i, axis in enumerate(((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)), start=2)))
WORN = {"segments": CHAIN5, "sensed": tuple(segment.name for segment in CHAIN5)}


def mean_of_hinges(score):
    return np.mean([score["orientation_rmse_deg"][f"seg{i}-seg{i + 1}"]["total"] for i in (2, 3, 4)])


@pytest.mark.slow
@pytest.mark.parametrize(("sensor_set", "published"), [("rigid", 18.9), ("nonrigid", 24.2)])
def test_salchow_b_is_the_9_axis_baseline(recordings, sensor_set, published):
    score = scores(recordings / "chain5" / "trial1.npz", SalchowB(**WORN), "relative", sensor_set)
    assert mean_of_hinges(score) == pytest.approx(published, rel=0.02)


# The published batch method, which needs no initial pose: 5.30 rigid and 8.22 foam.
@pytest.mark.parametrize("front_end", ["vqf", pytest.param("seel_ruppin", marks=pytest.mark.slow)])
@pytest.mark.parametrize(("sensor_set", "published"), [
    ("rigid", 5.30), pytest.param("nonrigid", 8.22, marks=pytest.mark.slow)])
def test_salchow_m2_with_a_known_pose_holds_the_hinges_for_a_minute(
    recordings, sensor_set, published, front_end
):
    path = recordings / "chain5" / "trial1.npz"
    tree = SegmentTree(CHAIN5)
    # The chain rests for half a second at first, in a pose that only the reference knows.
    first = Replay(recording=str(path)).source.reference.orientation[0]
    pose = np.degrees(joint_angles(tree, relative_of_segments(tree, first)))
    tracker = SalchowM2(**WORN, front_end=front_end, initial_pose_s=0.45,
                        initial_angles_deg=dict(zip(tree.freedoms, pose.tolist(), strict=True)))
    recording, times, orientation, events = replayed(path, tracker, sensor_set)
    assert [status for *_, status, _ in events] == ["aligning", "aligned"]
    assert mean_of_hinges(score_recording(recording, times, orientation, "relative")) < published


@pytest.mark.realtime
def test_sixteen_streams_keep_up_with_100_hz(recordings):
    replay = Replay(recording=str(recordings / "body16" / "qmt_full_body_example_data.mat"), duration_s=30.0)
    source = replay.source
    assert len(source.sensors) == 16
    times = tick_times_us(VqfTracker(sensors=16), (source.gyr[:3000], source.acc[:3000]), 100)
    median, late = np.median(times[100:]), np.percentile(times[100:], 99)
    print(f"body16: {median:.1f} us a tick (median), {late:.1f} us (p99)")
    assert late < 10_000.0
