"""`fesloop calibrate`: all that a simulated or real recording shows, and messages where it shows nothing."""

import json
import tomllib

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from estimators.calibration.block import SegmentCalibration
from estimators.calibration.from_recording import calibrate_recording
from fesloop.apps.cli import main
from fesloop.errors import InputError, InputErrors
from fesloop.loop.signals import Sensors
from fesloop.models.calibration import Calibration, SensorRotation

RATE, G = 100.0, 9.80665
WRIST, LATE_S, REACH = np.array([0.4, 1.1, 0.9]), 0.15, 0.08
TO_WRIST = Rotation.from_euler("z", 50, degrees=True)
MOUNTING = Rotation.from_euler("xyz", [[20, -15, 30], [-10, 25, 140]], degrees=True)
LAYOUT = """rate = "100"
pairs = [["hand", "finger"]]
[units]
gyr = "rad/s"
acc = "m/s^2"
[text]
separator = ","
header = 1
"""


def write_table(path, names, columns):
    np.savetxt(path, np.column_stack(columns), delimiter=",", header=",".join(names), comments="", fmt="%.9g")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Two sensors on a hinge, flat for 3 s and then in motion, and a marker on the finger, with a layout."""
    where, t = tmp_path_factory.mktemp("hinge"), np.arange(int(20 * RATE)) / RATE
    moves = np.clip((t - 3.5) / 2.0, 0.0, 1.0)
    flexion = moves * np.radians(35.0) * (1.0 - np.cos(2.5 * t) + 0.6 * np.sin(0.71 * t) ** 2)
    arm = moves * np.array([0.5 * np.sin(1.1 * t), 0.6 * np.sin(0.7 * t + 0.3), 0.4 * np.sin(1.7 * t)])
    hand = Rotation.from_euler("zxy", arm.T) * Rotation.from_euler("y", 90, degrees=True)
    finger = hand * Rotation.from_rotvec(np.outer(flexion, [0, 0, 1]))
    rng, names, columns, layout = np.random.default_rng(1), [], [], LAYOUT
    for name, segment, mounting in (("hand", hand, MOUNTING[0]), ("finger", finger, MOUNTING[1])):
        sensor = segment * mounting
        samples = [(sensor[:-1].inv() * sensor[1:]).as_rotvec() * RATE, sensor[:-1].inv().apply([0, 0, G])]
        columns += [each + sd * rng.standard_normal(each.shape)
                    for each, sd in zip(samples, (2e-3, 2e-2), strict=True)]
        own = [[f"{name}_{kind}{axis}" for axis in "xyz"] for kind in "wa"]
        names += own[0] + own[1]
        layout += f"[sensors.{name}]\ngyr = {json.dumps(own[0])}\nacc = {json.dumps(own[1])}\n"
    write_table(where / "hinge.csv", names, columns)
    (where / "layout.toml").write_text(layout)
    tip = WRIST + TO_WRIST.inv().apply(finger.apply([0, REACH, 0])) + 2e-4 * rng.standard_normal((t.size, 3))
    corners = np.array([[0.1, 0.0, 0.0], [0.0, 0.2, 0.0], [0.0, 0.0, 0.1]])
    resting = np.tile((WRIST + TO_WRIST.inv().apply(corners)).reshape(9), (t.size, 1))
    marked = ["time_s", *(f"{name}_{axis}" for name in ("finger", "a", "b", "c") for axis in "xyz")]
    write_table(where / "markers.csv", marked, [t + LATE_S, tip, resting])
    write_table(where / "fixture.csv", marked[4:], [np.vstack([corners.reshape(9)] * 2)])
    return where


def calibrated(folder, **task):
    return calibrate_recording(str(folder / "hinge.csv"), layout=str(folder / "layout.toml"), **task)


def off_deg(found, true):
    return np.degrees((Rotation.from_quat(found, scalar_first=True).inv() * true).magnitude())


def test_axes_and_rotations_of_a_hinge(folder):
    found = calibrated(folder, flat_s=(0.0, 3.0)).calibration
    hinge, = found.hinges
    for axis, mounting in zip((hinge.parent_axis, hinge.child_axis), MOUNTING, strict=True):
        assert abs(np.dot(axis, mounting.inv().apply([0, 0, 1]))) > np.cos(np.radians(0.2))
    assert [each.name for each in found.sensors] == ["hand", "finger"]
    for each, mounting in zip(found.sensors, MOUNTING, strict=True):
        assert off_deg(each.rotation, mounting) < 0.2


def test_a_left_hand_lies_with_its_other_side_up(folder):
    right, left = (calibrated(folder, flat_s=(0.0, 3.0), side=side).calibration for side in ("right", "left"))
    for one, other in zip(right.sensors, left.sensors, strict=True):
        turn = Rotation.from_quat(one.rotation, scalar_first=True)
        assert off_deg(other.rotation, Rotation.from_euler("z", 180, degrees=True) * turn) < 0.2


def test_centre_clock_and_frame_of_markers(folder, tmp_path):
    task = {"markers": str(folder / "markers.csv"), "marker": "finger", "arcs_s": (3.5, 20.0)}
    rotation = tuple(TO_WRIST.as_quat(scalar_first=True))
    stated = calibrated(folder, **task, rotation=rotation)
    centre, clock, frame = (each[0] for each in (stated.calibration.centres, stated.calibration.clocks,
                                                 stated.calibration.frames))
    np.testing.assert_allclose(centre.centre_m, WRIST, atol=5e-4)
    assert centre.radius_m == pytest.approx(REACH, abs=5e-4)
    assert clock.late_ms == pytest.approx(1e3 * LATE_S, abs=6.0)  # half a sample of the rates' mean
    np.testing.assert_allclose(frame.origin_m, WRIST, atol=5e-4)
    fitted = calibrated(folder, **task, fixture=str(folder / "fixture.csv")).calibration.frames[0]
    np.testing.assert_allclose(fitted.origin_m, WRIST, atol=1e-6)
    assert off_deg(fitted.rotation, TO_WRIST) < 1e-4
    stated.write_markers(tmp_path / "wrist.csv")
    rows = np.loadtxt(tmp_path / "wrist.csv", delimiter=",", skiprows=1)
    assert np.linalg.norm(rows[:, 1:4], axis=1).mean() == pytest.approx(REACH, abs=5e-4)
    assert rows[0, 0] == pytest.approx(LATE_S + clock.offset_s)


@pytest.mark.slow
def test_a_reference_shows_rotations_and_its_delay(recordings):
    # The stamps of this reference are about 16 ms late: half a sample of its 30 Hz.
    found = calibrate_recording(str(recordings / "chain5" / "trial1.npz"))
    assert {f"{each.parent}-{each.child}" for each in found.calibration.hinges} == {
        "seg2-seg3", "seg3-seg4", "seg4-seg5"}
    assert any(line.startswith("seg3-seg5: hinge axis: ") for line in found.refused)  # a saddle
    assert len(found.calibration.sensors) == 5
    for each in found.calibration.sensors:
        assert off_deg(each.rotation, Rotation.identity()) < 2.0
    assert 10.0 < found.calibration.clocks[0].late_ms < 25.0


def test_the_file_comes_back_and_gives_a_block_its_rotations(folder, tmp_path):
    found = calibrated(folder, flat_s=(0.0, 3.0)).calibration
    path = tmp_path / "calibration.toml"
    found.save(path)
    table = Calibration.file_tables(path)
    back = Calibration(sensors=tuple(SensorRotation(**{**each, "rotation": tuple(each["rotation"])})
                                     for each in table["sensors"]))
    order = ["finger", "hand"]
    np.testing.assert_allclose(back.rotations(order), found.rotations(order), atol=1e-7)
    block = SegmentCalibration(calibration=back, sensors=2)
    state = block.with_sensors({"gyr": Sensors(("finger", "hand"))}).init(None)
    for row, mounting in zip(state.rotations, MOUNTING[[1, 0]], strict=True):
        assert off_deg(row, mounting) < 0.2


def test_sensors_that_the_file_lacks_are_named(folder):
    known = Calibration(sensors=(SensorRotation(name="hand", rotation=(1.0, 0.0, 0.0, 0.0)),))
    with pytest.raises(InputError, match="has no rotation of finger; allowed: hand"):
        SegmentCalibration(calibration=known).with_sensors({"gyr": Sensors(("hand", "finger"))})
    with pytest.raises(InputError, match="rotations: is given together with calibration"):
        SegmentCalibration(calibration=known, rotations=((1.0, 0.0, 0.0, 0.0),))
    with pytest.raises(InputError, match="wired ones have no names"):
        SegmentCalibration(calibration=known, sensors=1).init(None)


@pytest.mark.parametrize(("task", "fault"), [
    ({"joints": ("hand-fingr",)}, "joint: .hand-fingr.*did you mean"),
    ({"flat_s": (5.0, 8.0)}, "flat: hand: .*moved in the flat pose"),
    ({"flat_s": (3.0, 3.0)}, "flat_s: 3 to 3 s"),
    ({"marker": "finger"}, "marker: is given without markers"),
    ({"low_pass_hz": 50.0}, "low_pass_hz: 50; allowed: below half the rate"),
    ({"markers": "hinge.csv", "marker": "finger"}, "lacks columns of markers"),
    ({"markers": "markers.csv", "marker": "tip"}, "tip: is no marker of this file; allowed: finger, a, b, c"),
    ({"markers": "markers.csv", "marker": "finger", "sensor": "thumb"}, "sensor: 'thumb'; allowed: hand"),
    ({"markers": "markers.csv", "marker": "a"}, "positions: are all the same"),
])
def test_what_cannot_be_used_is_named(folder, task, fault):
    if "markers" in task:
        task = {**task, "markers": str(folder / task["markers"])}
    with pytest.raises(InputErrors if "flat: " in fault else InputError, match=fault):
        calibrated(folder, **task)


def test_the_command_writes_a_file_and_one_object(folder, tmp_path, capsys):
    out = tmp_path / "found.toml"
    given = ["calibrate", str(folder / "hinge.csv"), "--out", str(out),
             "--layout", str(folder / "layout.toml")]
    assert main([*given, "--flat", "0", "3", "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    table = tomllib.loads(out.read_text())
    assert table["format"] == "fesloop calibration 1"
    assert [each["name"] for each in table["sensors"]] == [each["name"] for each in printed["sensors"]]
    assert main(given) == 2
    assert "found.toml" in capsys.readouterr().err
