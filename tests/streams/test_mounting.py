"""Axes of sensors on a finger's hinge are held against those of the segments that they are named after."""

import json

import numpy as np
import pytest
from agreement_parts import G, waves
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from fesloop.apps.cli import main, stream_command
from fesloop.hand.anthropometry import HandSize
from fesloop.hand.skeleton import hand_tree
from fesloop.streams.mounting import hinge_seen

Z = np.array([0.0, 0.0, 1.0])
SEEDS = st.integers(0, 10_000)


def finger(seed, rate=100.0, seconds=30.0, turning=1.0, flexing=1.0):
    """Rates (n, 2, 3) and specific forces of the two segments of a hinge about z that turns at random."""
    rng = np.random.default_rng(seed)
    times = np.arange(round(rate * seconds)) / rate
    parent = waves(rng, times, turning, 1.0)
    flexion = waves(rng, times, flexing, 0.5)[:, 0]
    turns, reach = Rotation.from_rotvec(np.vstack([rng.standard_normal(3), parent[:-1] / rate])), 1
    while reach < times.size:
        turns = Rotation.concatenate([turns[:reach], turns[:-reach] * turns[reach:]])
        reach *= 2
    bend = Rotation.from_rotvec(flexion[:, None] * Z)
    child = bend.inv().apply(parent) + np.gradient(flexion, times)[:, None] * Z
    up = turns.inv().apply(np.tile([0.0, 0.0, G], (times.size, 1)))
    gyr, acc = np.stack([parent, child], axis=1), np.stack([up, bend.inv().apply(up)], axis=1)
    return (gyr + 0.01 * rng.standard_normal(3) + 5e-3 * rng.standard_normal(gyr.shape),
            acc + 0.02 * rng.standard_normal(acc.shape))


@given(seed=SEEDS, tilt=st.floats(0.0, 15.0), turning=st.sampled_from([0.0, 0.2, 1.0, 3.0]),
       flexing=st.sampled_from([0.0, 0.1, 0.5, 1.0]), late=st.integers(0, 2),
       tissue=st.sampled_from([0.0, 0.1]))
@settings(max_examples=8, deadline=None)
def test_sensors_that_sit_about_as_segments_are_never_doubted(seed, tilt, turning, flexing, late, tissue):
    gyr, _ = finger(seed, turning=turning, flexing=flexing)
    rng = np.random.default_rng(seed)
    for sensor in range(2):
        axis = rng.standard_normal(3)
        turned = Rotation.from_rotvec(np.radians(tilt) * axis / np.linalg.norm(axis))
        gyr[:, sensor] = turned.apply(gyr[:, sensor])
    gyr *= 1.0 + tissue * rng.standard_normal(gyr.shape)
    assert not hinge_seen(gyr[:len(gyr) - late, 0], gyr[late:, 1], Z).wrong


@given(seed=SEEDS, both=st.booleans(), turn=st.tuples(*[st.floats(-1.0, 1.0)] * 3))
@settings(max_examples=8, deadline=None)
def test_a_sensor_that_is_turned_is_found_with_the_axis_of_its_hinge(seed, both, turn):
    mounting = Rotation.from_rotvec(np.pi * np.array(turn) / np.sqrt(3.0))
    assume(abs(mounting.apply(Z)[2]) < np.cos(np.radians(60.0)))
    gyr, _ = finger(seed)
    gyr[:, 1] = mounting.apply(gyr[:, 1])
    if both:
        gyr[:, 0] = mounting.apply(gyr[:, 0])
    seen = hinge_seen(gyr[:, 0], gyr[:, 1], Z)
    assert seen.wrong
    for found, true in ((seen.child, mounting.apply(Z)), (seen.parent, mounting.apply(Z) if both else Z)):
        assert abs(found @ true) > np.cos(np.radians(15.0))


def test_every_hinge_of_the_hand_flexes_about_z():
    hinges = [segment for segment in hand_tree(HandSize()).segments if segment.joint == "hinge"]
    assert len(hinges) == 10
    for segment in hinges:
        np.testing.assert_array_equal(segment.frame[0], Z)


def table(folder, gyr, acc, names=("F2p", "F2m"), axes=""):
    """A table of two sensors with its layout."""
    columns = [f"{name}_{kind}{axis}" for name in names for kind in ("gyr", "acc") for axis in "xyz"]
    rows = np.concatenate([np.concatenate([gyr[:, n], acc[:, n]], axis=1) for n in range(2)], axis=1)
    np.savetxt(folder / "lab.csv", rows, delimiter=",", comments="", fmt="%.9g", header=",".join(columns))
    (folder / "layout.toml").write_text(
        f'rate = "100"\npairs = [{json.dumps(names)}]\n' + "".join(
            f"[sensors.{name}]\n{axes}\n" + "".join(
                f"{kind} = {json.dumps([f'{name}_{kind}{axis}' for axis in 'xyz'])}\n"
                for kind in ("gyr", "acc"))
            for name in names))


TURNS = {  # of the sensor's axes, as rows in the segment's: its key, and what is said of the hinge
    "cyclic": (np.array([[0, 1, 0], [0, 0, 1], [1, 0, 0]]), 'axes = ["z", "x", "y"]', "turns about y of F2p"),
    "x distal, z dorsal": (np.array([[0, -1, 0], [0, 0, 1], [-1, 0, 0]]), 'axes = ["-z", "-x", "y"]',
                           "turns about y of F2p and y of F2m"),
}


@pytest.mark.parametrize("turn", ["cyclic", pytest.param("x distal, z dorsal", marks=pytest.mark.slow)])
def test_import_check_and_run_name_the_joint_and_axes_in_the_layout_mend_it(tmp_path, capsys, turn):
    rows, axes, told = TURNS[turn]
    gyr, acc = (samples @ rows.T for samples in finger(3))
    main_ = ["--layout", str(tmp_path / "layout.toml")]
    for said in ("", axes):
        table(tmp_path, gyr, acc, axes=said)
        target = tmp_path / f"lab{bool(said)}.h5"
        assert main(["import", str(tmp_path / "lab.csv"), str(target), *main_]) == 0
        assert (told in capsys.readouterr().err) == (not said)
        given_ = ["hil_replay", "--set", f"recording={target}"]
        assert main(["check", *given_, "--json"]) == 0
        cautions = json.loads(capsys.readouterr().out)["cautions"]
        assert any(told in each["detail"] for each in cautions
                   if each["status"] == "mounting_disagrees") == (not said)
        assert main(["run", *given_, "--out", str(tmp_path / "runs")]) == 0
        assert capsys.readouterr().err.startswith(
            "fesloop: the recording played by `recording` is wrong: axes of sensors") == (not said)


def test_of_sensors_that_are_no_segments_nothing_is_said(tmp_path, capsys):
    gyr, acc = (samples @ TURNS["cyclic"][0].T for samples in finger(3))
    table(tmp_path, gyr, acc, names=("thigh", "shank"))
    assert main(["import", str(tmp_path / "lab.csv"), str(tmp_path / "lab.h5"), "--layout",
                 str(tmp_path / "layout.toml")]) == 0
    assert "axes of sensors" not in capsys.readouterr().err


@pytest.mark.parametrize(("axes", "why"), [
    ('["x", "y", "y"]', "each of x, y and z once"), ('["x", "z", "y"]', "is left-handed"),
    ('["x", "y", "--z"]', "each of x, y and z once"), ('["x", "y"]', "axes")])
def test_axes_that_are_no_frame_are_refused(tmp_path, capsys, axes, why):
    table(tmp_path, *finger(3, seconds=5.0), axes=f"axes = {axes}")
    assert main(["import", str(tmp_path / "lab.csv"), str(tmp_path / "lab.h5"), "--layout",
                 str(tmp_path / "layout.toml")]) == 2
    told = capsys.readouterr().err
    assert why in told
    assert "F2p" in told


@pytest.mark.slow
def test_a_stream_says_what_import_says(tmp_path, capsys, monkeypatch):
    gyr, acc = (samples @ TURNS["cyclic"][0].T for samples in finger(3))
    gyr[:, 0] = np.clip(gyr[:, 0], -1.0, 1.0)
    acc[:, 1] = acc[:, 1, [1, 0, 2]]
    gyr[500:600, 0] = np.nan
    table(tmp_path, gyr, acc)
    assert main(["import", str(tmp_path / "lab.csv"), str(tmp_path / "lab.h5"), "--layout",
                 str(tmp_path / "layout.toml")]) == 0
    said = capsys.readouterr().err.splitlines()
    assert len(said) >= 4
    monkeypatch.setattr(stream_command, "open_library", lambda network: None)
    monkeypatch.setattr(stream_command.StreamSender, "send", lambda *_: 0)
    assert main(["stream", str(tmp_path / "lab.h5")]) == 0
    streamed = capsys.readouterr().err
    for line in said:
        assert line.partition("lab.csv: ")[2] in streamed
