"""Axes of hinges that the constrained tracker learns from motion."""

import math
import pickle
import re

import numpy as np
import pytest
from jointed_parts import Errors, Jointed, away, moving_hinge
from tracker_parts import run_tracker

import fesloop
from estimators.body.joint_constraints import Joint, joints_between
from estimators.constrained import ConstrainedTracker
from fesloop.errors import InputError
from fesloop.experiment.recording.reading import Recording
from fesloop.hand import quaternion
from fesloop.loop.signals import Port, Sensors
from fesloop.streams.files import open_recording

HINGE = ConstrainedTracker(sensors=2, joints="hinge")
TIMES = np.arange(20 * 50) / 50.0
SENSORS = Errors(bias=math.radians(0.5), walk=1e-4)


def statuses(reports):
    return [status for status, _ in reports]


@pytest.mark.parametrize("seed", range(3))
def test_a_hinge_of_sensors_mounted_anyhow_is_tracked_once_its_axes_are_learnt(seed):
    gyr, acc, axes, true = moving_hinge(seed, TIMES, errors=SENSORS)
    (_, angles, sd, *_), reports, state = run_tracker(HINGE, gyr, acc, rate=50)
    assert statuses(reports)[:4] == ["learning_axes", "untracked", "axes_learnt", "tracked"]
    found = state.table.axes[0]
    sign = np.sign(found[0] @ axes[0])
    assert np.degrees(np.arccos(np.sum(sign * found * axes, axis=1))).max() < 2.0
    begun = np.flatnonzero(sd[:, 0] < math.pi)[0]
    assert 9.9 <= TIMES[begun] < 15.0
    # Whatever the mounting, the angle has an unknown zero.
    late = slice(begun + 100, None)
    error = away(sign * angles[late, 0], true[late])
    error = away(error, np.angle(np.mean(np.exp(1j * error))))
    assert np.degrees(np.sqrt(np.mean(error ** 2))) < 2.0


def test_learnt_axes_that_are_given_are_tracked_from_the_first_sample():
    gyr, acc, *_ = moving_hinge(1, TIMES, errors=SENSORS)
    _, reports, state = run_tracker(HINGE, gyr, acc, rate=50)
    detail = dict(reports)["axes_learnt"]
    parent, child = (tuple(map(float, text.split(", "))) for text in re.findall(r"\[(.*?)\]", detail))
    np.testing.assert_allclose([parent, child], state.table.axes[0], atol=6e-4)
    known = Joint(parent=0, child=1, kind="hinge", parent_axis=parent, child_axis=child)
    _, reports, _ = run_tracker(ConstrainedTracker(sensors=2, joints=(known,)), gyr, acc, rate=50, last=100)
    assert "untracked" not in statuses(reports)


def test_each_hinge_of_a_tree_is_learnt_while_the_others_are_tracked():
    chain = (Joint(parent=0, child=1, kind="ball"), Joint(parent=1, child=2, kind="hinge"),
             Joint(parent=1, child=3, kind="hinge", parent_axis=(1.0, 0.0, 0.0), child_axis=(1.0, 0.0, 0.0)))
    told = (*chain[:2], Joint(parent=1, child=3, kind="hinge", learn_axes=True))
    gyr, acc = Jointed(chain, 2, SENSORS).samples(TIMES)
    (_, _, sd, aligned, _), reports, _ = run_tracker(
        ConstrainedTracker(sensors=4, joints=told), gyr, acc, rate=50)
    # Neither score nor stimulation by a posture of which one joint is not known.
    np.testing.assert_array_equal(aligned[:, 0] > 0.5, sd[:, 4] < math.pi)
    assert ("untracked", "joint 1-3") in reports
    assert (sd[100, :4] < math.pi).all()
    assert sd[100, 4] == math.pi
    assert sd[-1, 4] < math.radians(15.0)


def test_motion_that_does_not_show_the_axes_is_reported_and_nothing_is_made_up():
    # Both turn about one level axis that no rate distinguishes from another of the still sensor.
    angle = np.sin(TIMES)
    gyr, acc = np.zeros((2, len(TIMES), 2, 3))
    gyr[:, 1, 2] = np.cos(TIMES)
    acc[:, 0, 1] = 9.81
    acc[:, 1, :2] = 9.81 * np.stack([np.sin(angle), np.cos(angle)], axis=1)
    (_, angles, sd, *_), reports, _ = run_tracker(HINGE, gyr, acc, rate=50)
    assert statuses(reports).count("axes_not_learnt") == 1
    assert "move the joint itself" in dict(reports)["axes_not_learnt"]
    assert "axes_learnt" not in statuses(reports)
    assert (sd == math.pi).all()
    assert (angles == 0.0).all()


@pytest.mark.slow
@pytest.mark.parametrize(("sensor_set", "most_deg"), [("rigid", (3.5, 1.5, 2.0)),
                                                      ("nonrigid", (9.5, 7.5, 10.5))])
def test_hinges_of_the_recorded_chain_are_tracked_about_learnt_axes(recordings, sensor_set, most_deg):
    source = open_recording(recordings / "chain5" / "trial1.npz", sensor_set)
    stamps = source.reference.stamps_ns
    at = np.searchsorted(stamps, source.stamps_ns).clip(max=len(stamps) - 1)
    for first, most in enumerate(most_deg, start=1):
        both = [first, first + 1]
        (orientation, _, sd, *_), _, _ = run_tracker(
            HINGE, *(np.ascontiguousarray(kind[:, both]) for kind in (source.gyr, source.acc)), rate=40)
        true = quaternion.relative(*np.moveaxis(source.reference.orientation[at][:, both], 1, 0))
        error = quaternion.rotation_angle(quaternion.relative(
            quaternion.relative(orientation[:, 0], orientation[:, 1]), true))
        tracked = (sd[:, 0] < math.pi) & (np.arange(len(sd)) > 15 * 40) & np.isfinite(error)
        assert tracked.mean() > 0.6
        assert np.degrees(np.sqrt(np.mean(error[tracked] ** 2))) < most


def test_what_is_missing_or_at_rest_teaches_nothing():
    gyr, acc, *_ = moving_hinge(0, TIMES, errors=SENSORS)
    gyr[100:300, 1] = np.nan
    still = np.repeat(acc[:1], 200, axis=0)
    gyr, acc = np.concatenate([np.zeros((200, 2, 3)), gyr]), np.concatenate([still, acc])
    (_, _, sd, *_), reports, _ = run_tracker(HINGE, gyr, acc, rate=50)
    assert "axes_learnt" in statuses(reports)
    assert np.flatnonzero(sd[:, 0] < math.pi)[0] >= 200 + 200 + 500 - 1


def test_a_search_that_is_saved_goes_on_bit_for_bit():
    gyr, acc, *_ = moving_hinge(2, TIMES, errors=SENSORS)
    whole, reports, _ = run_tracker(HINGE, gyr, acc, rate=50)
    first, before, state = run_tracker(HINGE, gyr, acc, rate=50, last=333)
    rest, after, _ = run_tracker(HINGE, gyr, acc, rate=50, state=pickle.loads(pickle.dumps(state)), first=333)
    assert before + after == reports
    for port, (one, two) in zip(whole, zip(first, rest, strict=True), strict=True):
        np.testing.assert_array_equal(port, np.concatenate([one, two]))


def test_joints_by_kind_are_between_the_pairs_that_the_source_states():
    stated = {"gyr": Sensors(("a", "b", "c"), ((0, 2), (0, 1)))}
    for kind in ("hinge", "ball"):
        tracker = ConstrainedTracker(joints=kind).with_sensors(stated)
        assert tracker.joints == joints_between(kind, ((0, 2), (0, 1)))
        assert tracker.table.known.tolist() == [kind == "ball"] * 2
    with pytest.raises(InputError, match="neighbours is not stated"):
        ConstrainedTracker(joints="hinge").with_sensors({"gyr": Sensors(("a", "b", "c"))})
    chained = ConstrainedTracker(joints="ball").resolve({"gyr": (3, 3)})
    assert chained.table.ends.tolist() == [[0, 1], [1, 2]]
    assert Port("angles", (6,), "rad") in chained.outputs


@pytest.mark.parametrize("wrong", [{"kind": "ball"}, {"kind": "hinge", "child_axis": (1.0, 0.0, 0.0)}])
def test_axes_are_learnt_or_given_and_those_of_hinges_alone(wrong):
    with pytest.raises(InputError, match=r"learn_axes: true for a (ball|hinge) with axes"):
        Joint(parent=0, child=1, learn_axes=True, **wrong)


def test_a_replay_of_two_sensors_takes_their_joint_from_the_command_line(tmp_path):
    gyr, acc, *_ = moving_hinge(3, TIMES, errors=SENSORS)
    rows = np.concatenate([gyr, acc], axis=2).reshape(len(TIMES), 12)
    np.savetxt(tmp_path / "lab.csv", rows, delimiter=",")
    (tmp_path / "layout.toml").write_text(
        "rate = 50\n[text]\nheader = 0\n"
        "[sensors.hand]\ngyr = [1, 2, 3]\nacc = [4, 5, 6]\n"
        "[sensors.finger]\ngyr = [7, 8, 9]\nacc = [10, 11, 12]\n")
    settings = [f"recording={tmp_path / 'lab.csv'}", f"blocks.recording.layout={tmp_path / 'layout.toml'}",
                "tracker=constrained", "joints=hinge"]
    result = fesloop.load("replay", settings).run(tmp_path / "runs")
    with Recording(result.recording) as run:
        learnt = [event.detail for event in run.events if event.status == "axes_learnt"]
        assert learnt[0].startswith("joint hand-finger: parent_axis")
        assert run.signal("tracker.angles").rows == run.signal("tracker.angle_sd").rows == ("hand-finger",)
        assert run.signal("tracker.orientation").rows == ("hand", "finger")
    for tracker in ("constrained", "kortier"):
        with pytest.raises(InputError, match=r"replay `--set tracker=constrained --set joints=hinge`"):
            fesloop.load("replay", [*settings[:2], f"tracker={tracker}"])
    with pytest.raises(InputError, match=r"joints .*saddle.*; allowed: .*hinge.*ball"):
        fesloop.load("replay", [*settings[:-1], "joints=saddle"])
